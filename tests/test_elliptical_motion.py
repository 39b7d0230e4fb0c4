"""Motion of the elliptical planetary drive against the paper's equations."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from any_path import series_of
from elliptical_tools import PAPER, drives
from escapement.mechanisms.slotted import transmission

places = st.floats(-1.0, 1.0)


def analogue(drive, theta):
    """The paper's (9), with (6), in 30 digits: output over input speed."""
    with mpmath.workdps(30):
        sun, planet = mpmath.mpf(drive.sun_radius), mpmath.mpf(drive.planet_radius)
        a, e = (sun + planet) / 2, (sun - planet) / (sun + planet)
        rho = a * (1 - e**2) / (1 - e * mpmath.cos(sun / planet * theta))
        return 1 - sun * rho / (planet * (sun + planet - rho))


@settings(deadline=None, max_examples=40)
@given(drives, st.floats(-3.0, 3.0))
def test_transmission_is_equation_9(drive, place):
    theta = place * drive.cell_angle
    found = drive.transmission(theta)
    expected = -analogue(drive, mpmath.mpf(theta))
    # an angle of this size carries its own rounding into the planet's turn
    assert float(found.g) == pytest.approx(float(expected), abs=1e-14 * (1.0 + drive.ratio**4))
    assert float(found.u) == 0.0


@settings(deadline=None, max_examples=15)
@given(drives.filter(lambda drive: drive.ratio < 5.0), places)
def test_position_function_is_the_integral_of_equation_9(drive, place):
    theta = 0.5 * place * drive.cell_angle
    with mpmath.workdps(20):
        integral = mpmath.quad(lambda x: analogue(drive, x), [0, theta / 2, theta])
    scale = 1.0 + drive.follower_step
    assert float(drive.follower_angle(theta)) == pytest.approx(-float(integral), abs=1e-14 * scale)


@settings(deadline=None)
@given(drives)
def test_the_output_stops_at_both_ends_of_a_cell(drive):
    ends = np.array(drive.breaks)
    found = drive.transmission(ends)
    assert np.abs(found.g).max() < 1e-28 * drive.ratio_max * drive.ratio**2
    assert np.abs(found.dg).max() < 1e-14 * drive.ratio_max * drive.ratio
    assert np.diff(ends)[0] == pytest.approx(drive.cell_angle, rel=1e-15)
    turned = np.diff(drive.follower_angle(ends))[0]
    assert turned == pytest.approx(drive.follower_step, rel=1e-13)
    inside = np.linspace(*ends, 101)[1:-1]
    assert (drive.transmission(inside).g > 0.0).all()
    away = drive.follower_angle(inside + 7.0 * drive.cell_angle) - 7.0 * drive.follower_step
    np.testing.assert_allclose(away, drive.follower_angle(inside), rtol=0.0, atol=1e-12)


@settings(deadline=None)
@given(drives)
def test_kernels_see_the_same_transmission(drive):
    theta = np.linspace(*drive.breaks, 201)
    mine, theirs = drive.transmission(theta), transmission(drive.path, theta)
    # the stops lie a few last digits outside, and the angle itself has one
    moved = 10.0 * math.ulp(drive.breaks[1])
    slope = np.abs(mine.dg).max()
    assert np.abs(mine.g - theirs.g).max() <= 1e-14 * drive.ratio_max + moved * slope
    # a rounding error in every coefficient of order k comes out k^2 times as great
    edges, series = series_of(drive.path)
    pieces, order = series.shape
    length = np.diff(edges)
    piece = np.clip(np.searchsorted(edges[:-1], theta, "right") - 1, 0, pieces - 1)
    tops = np.maximum(mine.g, drive.transmission(edges[piece]).g)
    tops = np.maximum(tops, drive.transmission(edges[piece] + length[piece]).g)
    rounding = np.finfo(float).eps * tops * 2.0 / length[piece] * order**3
    bend = np.abs(drive.jerk(theta)).max()
    assert (np.abs(mine.dg - theirs.dg) <= rounding + moved * bend).all()


@settings(deadline=None)
@given(drives)
def test_peak_acceleration(drive):
    top, angle = drive.acceleration_max
    # of a slender ellipse the peak is narrow
    near = angle * np.linspace(0.99, 1.01, 401)
    theta = np.union1d(np.linspace(drive.breaks[0], 0.0, 4001), near)
    found = drive.transmission(theta).dg
    assert top >= found.max() * (1.0 - 1e-13)
    assert top == pytest.approx(found.max(), rel=1e-4)
    scale = drive.ratio**2 * drive.ratio_max * drive.ratio**2
    assert abs(float(drive.jerk(angle))) < 1e-12 * scale


@settings(deadline=None)
@given(drives, st.floats(1e-9, 0.99), st.floats(1e-9, 3.3))
def test_dwells_end_where_they_say(drive, speed, position):
    stop = drive.breaks[1]
    limit = speed * drive.ratio_max
    half = 0.5 * drive.dwell_below(limit)
    ends = drive.transmission(np.array([stop - half, stop + half])).g
    np.testing.assert_allclose(ends, limit, rtol=1e-7)
    limit = position * drive.follower_step
    half = 0.5 * drive.dwell_within(limit)
    moved = drive.follower_angle(np.array([stop - half, stop, stop + half]))
    np.testing.assert_allclose(np.diff(moved), limit, rtol=1e-6, atol=1e-14)


def test_dwell_of_the_whole_cell():
    assert PAPER.dwell_below(PAPER.ratio_max) == PAPER.cell_angle
    assert PAPER.dwell_within(0.5 * PAPER.follower_step) == PAPER.cell_angle
    assert PAPER.dwell_within(PAPER.follower_step) == 2.0 * PAPER.cell_angle
    assert PAPER.dwell_below(0.0) == 0.0
    # within the resolution of the paper's encoders the output rests for a ninth of the time
    share = PAPER.dwell_within(2.0 * math.pi / 4096) / PAPER.cell_angle
    assert share == pytest.approx(0.115, abs=5e-4)
