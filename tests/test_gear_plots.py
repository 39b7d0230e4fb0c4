"""Drawings of gear-driven wheels: the pin stands in a slot, gears touch, paths close."""

import math
from itertools import product

import numpy as np
import pytest
from matplotlib.path import Path

from escapement import GearDriven
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
