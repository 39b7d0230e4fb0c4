"""Drawings of gear-driven wheels: the pin stands in a slot, gears touch, paths close."""

import math
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from matplotlib.path import Path

from escapement import GearDriven
from escapement.base.errors import InvalidValue
from escapement.mechanisms.gear_equation import CURVES
from escapement.outlines.gears import GearDrivenOutline
from escapement.plots import drawing, gear_driven

WHEELS = [
    GearDriven(4, 1, "epicycloid"),
    GearDriven(12, 3, "hypocycloid"),
    GearDriven(12, 3, "contracted-hypocycloid"),
    GearDriven(9, "1/2", "pericycloid"),
    GearDriven(12, 5, "epicycloid", pins=6),
    GearDriven(24, 5, "contracted-hypocycloid", pins=2),
    GearDriven(7, 11, "pericycloid", pins=2),
    GearDriven(11, "1/2", "hypocycloid", unused_lobes=2),
    GearDriven(4, 0, "hypocycloid"),
]


@pytest.mark.parametrize("wheel", WHEELS, ids=repr)
def test_a_pin_stands_in_a_slot_while_it_drives(wheel):
    shapes = GearDrivenOutline(wheel)
    pitch = 2.0 * math.pi / wheel.slots
    for cell, place in product(range(-3, 40), (-0.499, -0.2, 0.0, 0.4, 0.499)):
        theta = cell * wheel.cell_angle + place * wheel.alpha
        pins = np.array([complex(shapes.pin_at(theta, j)) for j in range(wheel.pins)])
        aside = np.angle(pins * np.exp(-1j * shapes.wheel_at(theta))) / pitch
        aside = np.abs(aside - np.rint(aside)) * pitch * abs(pins)
        engaged = (abs(pins) < shapes.mouth) == shapes.inward
        assert aside[engaged].max() < 1e-12
        # the others are out of the wheel's way
        assert engaged.sum() == 1


@pytest.mark.parametrize("wheel", WHEELS, ids=repr)
def test_the_path_closes_and_gears_touch(wheel):
    shapes = GearDrivenOutline(wheel)
    path = shapes.path()
    assert abs(path[0] - path[-1]) < 1e-12
    k = float(wheel.gear_ratio)
    distance = 1.0 + shapes.planet_radius if k < 0.0 else abs(1.0 - shapes.planet_radius)
    assert wheel.carrier_over_fixed == pytest.approx(distance, rel=1e-14)
    assert abs(path).max() <= shapes.reach
    ax = gear_driven.plot_gear_driven(wheel, 0.3)
    ids = {artist.get_gid() for artist in ax.get_children()}
    assert {"follower", "fixed-gear", "planet", "carrier", "path", "pin-0"} <= ids


@pytest.mark.parametrize("unused", [1, 2, 3])
@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize(
    ("n", "m", "pins"), [(12, 0, 1), (11, "1/3", 1), (14, "1/2", 2), (12, "1/2", 1), (6, "1/2", 1)]
)
def test_unused_lobes_stay_clear_of_slots(curve, n, m, pins, unused):
    """Where a mechanism is refused a lobe does sweep over a slot; else none does.

    The wheel is locked meanwhile, half a step beyond dead centre.
    """
    try:
        wheel = GearDriven(n, m, curve, pins)
    except InvalidValue:
        return  # too many pins
    sense = 1 if wheel.turns_with_driver else -1
    spacing = (unused + 1) / (pins * abs(wheel.gear_ratio)) - Fraction(sense, n)
    slots = spacing.denominator
    pitch, swept = 2.0 * math.pi / slots, []
    for lobe in range(1, unused + 1):
        place = np.linspace(-0.5, 0.5, 41) * wheel.alpha
        # every pin passes in the same way: the one that comes at this lobe
        at = np.exp(1j * lobe * wheel.cell_angle) * GearDrivenOutline(wheel).pin_at(place, 0)
        turned = np.unwrap(np.angle(at * np.exp(-0.5j * sense * wheel.follower_step)))
        low, high = turned.min() - 1e-9, turned.max() + 1e-9
        swept.append(math.floor(high / pitch) >= math.ceil(low / pitch))
    if any(swept):
        with pytest.raises(InvalidValue, match="unused_lobes must let the pin"):
            GearDriven(n, m, curve, pins, unused)
    else:
        shapes = GearDrivenOutline(GearDriven(n, m, curve, pins, unused))
        assert shapes.mechanism.slots == slots
        assert len(shapes.reliefs(0.0)) == unused * slots


@pytest.mark.parametrize("curve", CURVES)
def test_the_wheel_is_cut_away_where_unused_lobes_pass(curve):
    m, unused = ("1/2", 1) if "hypo" in curve else (0, 2)
    wheel = GearDriven(12, m, curve, unused_lobes=unused)
    shapes = GearDrivenOutline(wheel)
    bands = [Path(drawing.rows(body.edges[0].drawn())) for body in shapes.reliefs(0.0)]
    lobe = 2.0 * math.pi / abs(float(wheel.gear_ratio))
    for cell, passing, place in product(range(5), range(1, unused + 1), (-0.49, 0.0, 0.49)):
        theta = cell * wheel.cell_angle + passing * lobe + place * wheel.alpha
        pin = complex(shapes.pin_at(theta, 0)) * np.exp(-1j * shapes.wheel_at(theta))
        assert any(band.contains_point((pin.real, pin.imag)) for band in bands)


def test_rings_of_slots_do_not_cross():
    for wheel in WHEELS[:-1]:
        steps = np.unwrap(np.angle(GearDrivenOutline(wheel).wheel_edges()[0].drawn()))
        assert np.all(np.abs(np.diff(steps)) < 0.9 * math.pi)
        turned, pitch = abs(steps[-1] - steps[0]), 2.0 * math.pi / wheel.slots
        assert turned == pytest.approx(2.0 * math.pi, abs=pitch)


def test_what_cannot_be_drawn_is_refused():
    for said, *given in (
        ("theta must be a finite", WHEELS[0], math.nan),
        ("slots must be at most 200 in a drawing, got 203", GearDriven(203, 0)),
        ("lobes of the whole path must be at most 200", GearDriven(4, 1001, "epicycloid")),
    ):
        with pytest.raises(InvalidValue, match=said):
            gear_driven.plot_gear_driven(*given)
