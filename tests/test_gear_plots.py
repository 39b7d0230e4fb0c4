"""Drawings of gear-driven wheels: the pin stands in a slot, gears touch, paths close."""

import math

import numpy as np
import pytest

from escapement import GearDriven
from escapement.errors import InvalidValue
from escapement.plots import gear_driven
from escapement.plots._gear_shapes import GearWheels

WHEELS = [
    GearDriven(4, 1, "epicycloid"),
    GearDriven(12, 3, "hypocycloid"),
    GearDriven(12, 3, "contracted-hypocycloid"),
    GearDriven(9, "1/2", "pericycloid"),
    GearDriven(12, 5, "epicycloid", pins=6),
    GearDriven(24, 5, "contracted-hypocycloid", pins=2),
    GearDriven(11, "1/3", "hypocycloid", unused_lobes=2),
    GearDriven(4, 0, "hypocycloid"),
]


def named(wheel):
    return f"{wheel.stations} {wheel.curve} {wheel.pins}"


@pytest.mark.parametrize("wheel", WHEELS, ids=named)
def test_a_pin_stands_in_a_slot_while_it_drives(wheel):
    shapes = GearWheels(wheel)
    pitch = 2.0 * math.pi / wheel.slots
    for cell in range(-3, 40):
        for place in (-0.499, -0.2, 0.0, 0.4, 0.499):
            theta = cell * wheel.cell_angle + place * wheel.alpha
            pins = np.array([complex(shapes.pin_at(theta, j)) for j in range(wheel.pins)])
            in_wheel = pins * np.exp(-1j * shapes.wheel_at(theta))
            aside = np.angle(in_wheel) / pitch
            aside = np.abs(aside - np.rint(aside)) * pitch * abs(pins)
            engaged = (abs(pins) < shapes.mouth) == shapes.inward
            assert aside[engaged].max() < 1e-12
            # the others are out of the wheel's way
            assert engaged.sum() == 1


@pytest.mark.parametrize("wheel", WHEELS, ids=named)
def test_the_path_closes_and_gears_touch(wheel):
    shapes = GearWheels(wheel)
    path = shapes.path()
    assert abs(path[0] - path[-1]) < 1e-12
    k = float(wheel.gear_ratio)
    distance = 1.0 + shapes.planet if k < 0.0 else abs(1.0 - shapes.planet)
    assert wheel.carrier_over_fixed == pytest.approx(distance, rel=1e-14)
    assert abs(path).max() <= shapes.reach
    ax = gear_driven.plot_gear_driven(wheel, 0.3)
    ids = {artist.get_gid() for artist in ax.get_children()}
    assert {"follower", "fixed-gear", "planet", "carrier", "path", "pin-0"} <= ids


def test_rings_of_slots_do_not_cross():
    for wheel in WHEELS[:-1]:
        shapes = GearWheels(wheel)
        outline = shapes.outlines()[0]
        assert np.all(np.diff(np.unwrap(np.angle(outline))) < 0.9 * math.pi)
        steps = np.unwrap(np.angle(outline))
        assert steps[-1] - steps[0] == pytest.approx(2.0 * math.pi, abs=2.0 * math.pi / wheel.slots)


def test_another_mechanism_is_refused():
    with pytest.raises(InvalidValue, match="mechanism must be gear-driven"):
        gear_driven.plot_gear_driven("wheel")
    with pytest.raises(InvalidValue, match="theta must be a finite"):
        gear_driven.plot_gear_driven(WHEELS[0], math.nan)


def test_sheets():
    assert len(gear_driven.plot_gear_driven_examples().axes) == 4
    assert len(gear_driven.plot_curves().axes) == 4
