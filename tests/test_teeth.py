"""Teeth of elliptical and round gears: rolled on each other, and against the involute."""

import math

import numpy as np
import pytest

import escapement as esc
from escapement.mechanisms.elliptical_teeth import PitchEllipse, fewest_teeth, tooth_module
from escapement.outlines.gaps import gap, outside, segments_of
from escapement.outlines.meshed import spur_teeth, toothed_gears
from escapement.outlines.parts import outline_of
from escapement.outlines.teeth import rack_cut

PAPER = esc.EllipticalPlanetary(0.016, 0.009)
PRESSURE = math.radians(20.0)


def rolled(mechanism, fits, angles):
    """Gap of the whole gears at driver angles [m]."""
    gears = toothed_gears(mechanism, fits.teeth, fits.clearance)
    found = []
    for theta in angles:
        inner = theta + float(mechanism.follower_angle(theta))
        driven = gears["driven"].moved(np.exp(-1j * inner))
        outer = -np.exp(1j * mechanism.ratio * theta)
        driving = gears["driving"].moved(outer, mechanism.centre_distance)
        found.append(gap(segments_of([driven]), segments_of([driving]))[0])
    return np.array(found)


@pytest.mark.parametrize(
    ("mechanism", "teeth"), [(PAPER, 0), (PAPER, 24), (esc.EllipticalPlanetary(0.03, 0.01), 0)]
)
def test_the_gears_roll_in_contact_and_without_overlap(mechanism, teeth):
    angles = np.random.default_rng(7).uniform(*mechanism.breaks, 12)
    gaps = rolled(mechanism, esc.Fits(teeth=teeth), angles)
    assert gaps.min() > -5e-7  # arcs within 0.2 um on each gear
    assert gaps.max() < 1e-7  # flanks touch


def test_backlash_is_the_gap_of_the_flanks():
    """A play j along the pitch curve leaves j/2 cos(alpha) between the flanks on each side."""
    gaps = rolled(PAPER, esc.Fits(clearance=6e-5), np.linspace(*PAPER.breaks, 5)[1:-1])
    np.testing.assert_allclose(gaps, 3e-5 * math.cos(PRESSURE), atol=5e-7)


def test_a_tooth_that_meets_a_tooth_is_seen():
    gears = toothed_gears(PAPER, 0, 0.0)
    wrong = rack_cut(PAPER.pitch_ellipses[1], fewest_teeth(PAPER), True)
    other = gears["driving"].moved(-1.0, PAPER.centre_distance)
    module = tooth_module(PAPER, fewest_teeth(PAPER))
    assert gap(segments_of([wrong]), segments_of([other]))[0] < -0.3 * module


def test_the_check_sees_the_teeth_near_the_line_of_centres():
    outline = outline_of(PAPER, esc.Fits())
    for theta in np.linspace(*PAPER.breaks, 7):
        near = gap(*(segments_of(body.edges) for body in outline.bodies(float(theta))[2:]))[0]
        assert 1e-3 * near == pytest.approx(rolled(PAPER, esc.Fits(), [theta])[0], abs=1e-12)


def test_flanks_of_a_round_gear_are_involutes():
    teeth, radius = 30, 0.015
    module, base = 2 * radius / teeth, radius * math.cos(PRESSURE)
    edge = rack_cut(PitchEllipse(radius, 0.0), teeth, True)
    r = np.linspace(radius - 0.7 * module, radius + 0.95 * module, 9)
    spread = np.sqrt((r / base) ** 2 - 1.0)
    involute = spread - np.arctan(spread)
    half = 0.5 * math.pi / teeth + (math.tan(PRESSURE) - PRESSURE)
    points = r * np.exp(1j * (half - involute))
    distance, _ = outside(segments_of([edge]), points)
    assert np.abs(distance).max() < 2.5e-7
    # tip and root circles
    sizes = np.abs(edge.corners)
    assert sizes.max() == pytest.approx(radius + module, rel=1e-9)
    assert sizes.min() == pytest.approx(radius - 1.25 * module, rel=1e-9)


def test_sun_and_planet_mesh():
    sun_teeth, planet_teeth = spur_teeth(PAPER)
    assert (sun_teeth, planet_teeth) == (32, 18)
    gears = toothed_gears(PAPER, 0, 0.0)
    for turn in (0.0, 0.05, 0.13):
        one = gears["sun"].moved(np.exp(-1j * turn))
        other = gears["planet"].moved(-np.exp(1j * turn * PAPER.ratio), PAPER.centre_distance)
        assert abs(gap(segments_of([one]), segments_of([other]))[0]) < 5e-7


def test_parts_are_cut_and_their_mass_is_near_that_of_the_pitch_curve():
    parts = {part.name: part for part in esc.parts_of(PAPER, esc.Fits(teeth=25))}
    assert not any(part.toothed for part in parts.values())
    area = math.pi * PAPER.semi_major_axis * PAPER.semi_minor_axis
    for name in ("driven", "driving"):
        assert parts[name].edge.moments.area == pytest.approx(area, rel=0.03)
    # no ratio of whole numbers: spur gears stay pitch circles
    odd = esc.parts_of(esc.EllipticalPlanetary(0.016, 0.016 / math.pi))
    assert {part.name for part in odd if part.toothed} == {"sun", "planet"}
