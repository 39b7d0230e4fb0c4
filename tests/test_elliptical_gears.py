"""The elliptical gears themselves: pitch curves, inertia, construction, teeth."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import escapement as esc
from elliptical_tools import PAPER, drives
from escapement.mechanisms.elliptical_teeth import fewest_teeth, tooth_module


@settings(deadline=None)
@given(drives, st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=20))
def test_pitch_curves_roll_without_slip(drive, places):
    theta = np.array(places) * drive.cell_angle
    driving, driven = drive.pitch_ellipses
    alpha, beta = drive.ratio * theta, theta + drive.follower_angle(theta)
    size = drive.centre_distance
    total = driving.radius(alpha) + driven.radius(beta)
    np.testing.assert_allclose(total, size, rtol=1e-12)
    slack = 1e-12 * (1.0 + np.abs(places).max())
    np.testing.assert_allclose(driving.arc(alpha), driven.arc(beta), rtol=0.0, atol=slack * size)
    # one common tangent: angles from opposite radii
    both = driving.tangent_angle(alpha) + driven.tangent_angle(beta)
    np.testing.assert_allclose(both, math.pi, rtol=0.0, atol=1e-12)
    # and the radii give the speeds
    ratio = drive.ratio * driving.radius(alpha) / driven.radius(beta) - 1.0
    np.testing.assert_allclose(
        drive.transmission(theta).g, ratio, rtol=0.0, atol=1e-11 * drive.ratio**2
    )


def test_curvature_is_the_turn_of_the_tangent_over_the_arc():
    for gear in PAPER.pitch_ellipses:
        around = float(4 * gear.semi_major_axis * mpmath.ellipe(gear.eccentricity**2))
        assert float(gear.arc(2.0 * math.pi)) == pytest.approx(around, rel=1e-14)
        angle = np.linspace(0.0, 2.0 * math.pi, 37)
        h = 1e-4
        turn = angle + gear.tangent_angle(angle)
        turned = (angle + h + gear.tangent_angle(angle + h)) - (
            angle - h + gear.tangent_angle(angle - h)
        )
        assert (np.diff(turn) > 0.0).all()
        slope = turned / (gear.arc(angle + h) - gear.arc(angle - h))
        np.testing.assert_allclose(gear.curvature(angle), slope, rtol=1e-7)
        a, b = PAPER.semi_major_axis, PAPER.semi_minor_axis
        assert float(gear.curvature(0.0)) == pytest.approx(a / b**2, rel=1e-14)


def test_planet_inertia_is_that_of_a_plate_in_motion():
    """Kinetic energy of a homogeneous ellipse, point by point, at several driver angles."""
    drive, density = PAPER, 3.0
    a, b, c = drive.semi_major_axis, drive.semi_minor_axis, drive.focal_distance
    nodes, weights = np.polynomial.legendre.leggauss(40)
    r, turn = 0.5 * (nodes + 1.0), np.linspace(0.0, 2.0 * math.pi, 64, endpoint=False)
    area = (0.5 * weights * r)[:, None] * np.full(turn.size, 2.0 * math.pi / turn.size) * a * b
    # seen from the shaft; the far vertex points at the carrier's axis when theta = 0
    plate = -(c + a * r[:, None] * np.cos(turn) + 1j * b * r[:, None] * np.sin(turn))
    mass = density * area.sum()
    moment = density * (area * np.abs(plate) ** 2).sum()
    mean, swing = drive.planet_inertia(mass, moment, offset=c)
    for theta in np.linspace(0.0, drive.cell_angle, 7):
        spin = 1.0 + drive.ratio
        points = plate * np.exp(1j * spin * theta)
        speed = 1j * drive.centre_distance * np.exp(1j * theta) + 1j * spin * points
        energy = 0.5 * density * (area * np.abs(speed) ** 2).sum()
        assert 0.5 * (mean - swing * math.cos(drive.ratio * theta)) == pytest.approx(
            energy, rel=1e-12
        )
    assert drive.planet_inertia(mass, moment)[1] == 0.0


@settings(deadline=None)
@given(st.floats(1e-3, 6.28), st.floats(1e-3, 1e3))
def test_a_wanted_stop_interval(interval, distance):
    drive = esc.EllipticalPlanetary.from_stop_interval(interval, distance)
    assert drive.cell_angle == pytest.approx(interval, rel=1e-14)
    assert drive.centre_distance == pytest.approx(distance, rel=1e-14)
    assert drive.follower_step == pytest.approx(2.0 * math.pi - interval, rel=1e-9)


@pytest.mark.parametrize(
    ("sun", "planet", "stations"), [(2.0, 1.0, 2), (3, 1, 3), (4, 3, 4), (math.pi, 1.0, None)]
)
def test_stations(sun, planet, stations):
    drive = esc.EllipticalPlanetary(sun, planet)
    assert drive.stations == stations
    if stations:
        stops = drive.follower_step * np.arange(stations) / (2.0 * math.pi)
        assert np.unique(np.round(stops % 1.0, 9) % 1.0).size == stations


def test_fewest_teeth_of_a_circle_are_those_of_every_textbook():
    round_one = esc.EllipticalPlanetary.from_ellipse(1.0, 1e-6)
    assert fewest_teeth(round_one) == 18
    assert fewest_teeth(round_one, math.radians(14.5)) == 32
    assert fewest_teeth(round_one, addendum=0.8) == 14
    assert fewest_teeth(PAPER) == 19


def test_drives_of_teeth_and_of_an_ellipse():
    around = 2.0 * float(PAPER.pitch_ellipses[0].arc(math.pi))
    assert 25 * math.pi * tooth_module(PAPER, 25) == pytest.approx(around, rel=1e-13)
    assert esc.EllipticalPlanetary.from_teeth(32, 18, 0.001).ratio == pytest.approx(16 / 9)
    drive = esc.EllipticalPlanetary.from_ellipse(0.0125, 0.28)
    assert [drive.sun_radius, drive.planet_radius] == pytest.approx([0.016, 0.009], rel=1e-15)
