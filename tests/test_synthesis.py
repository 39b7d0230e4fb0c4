"""Peaks, charts, inverse synthesis and gears, against quadrature, scans and kinetic energy."""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from escapement import GearDriven, Geneva
from escapement.base.errors import InvalidValue
from escapement.synthesis import (
    find_mechanisms,
    follower_motion,
    gear_pairs,
    motion_peaks,
    motion_ratio_chart,
    planet_inertia,
)

WHEELS = [
    Geneva(4, pins=1),
    Geneva(12, pins=1),
    Geneva(9, internal=True),
    GearDriven(4, 1, "epicycloid"),
    GearDriven(24, 8, "epicycloid"),
    GearDriven(12, 3, "hypocycloid"),
    GearDriven(24, 1, "hypocycloid"),
    GearDriven(24, 1, "contracted-hypocycloid"),
    GearDriven(8, "1/2", "pericycloid"),
]


each_wheel = pytest.mark.parametrize(
    "wheel", WHEELS, ids=lambda w: f"{type(w).__name__} {w.follower_step:.3f}"
)


@each_wheel
def test_peaks_are_those_of_the_transmission(wheel):
    found, angle, step = motion_peaks(wheel), wheel.engagement_angle, wheel.follower_step
    theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 100_001)
    table, jerk = wheel.transmission(theta), wheel.jerk(theta)
    # the search sees a peak between two angles a little too low
    for peak, power, values in (
        (found.velocity_max, 1, table.g), (found.acceleration_max, 2, table.dg),
        (found.jerk_max, 3, jerk),
    ):  # fmt: skip
        greatest = np.abs(values).max() * angle**power / step
        assert greatest == pytest.approx(peak, rel=1e-6)
        assert greatest < peak * (1.0 + 1e-10)
    start = table.dg[0] * angle**2 / step
    assert found.acceleration_start == pytest.approx(start, rel=1e-11)
    cycle = found.per_cycle()
    assert cycle.velocity_max * found.motion_ratio == pytest.approx(found.velocity_max)
    assert cycle.jerk_max * found.motion_ratio**3 == pytest.approx(found.jerk_max)


@each_wheel
def test_motion_over_a_cycle(wheel):
    """Each is the derivative of the one before; the follower rests in the dwell."""
    share, h = wheel.motion_ratio, 1e-5
    time = np.concatenate([np.linspace(0.02, 0.98, 25) * share, [share + 0.01, 0.995]])
    nodes = time[:, None] + h * np.array([-2.0, -1.0, 1.0, 2.0])
    found, near = follower_motion(wheel, time), follower_motion(wheel, nodes - 3.0)
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * h)
    for low, high in pairwise(("angle", "velocity", "acceleration", "jerk")):
        value = getattr(found, high)
        assert getattr(near, low) @ weights == pytest.approx(value, abs=3e-7 * abs(value).max())
    ends = follower_motion(wheel, [0.0, 0.5 * share, share, 0.999, 1.0, -2.0])
    assert ends.angle == pytest.approx([0.0, 0.5, 1.0, 1.0, 1.0, -2.0], abs=1e-13)
    assert ends.velocity[[0, 2, 3, 4]] == pytest.approx(0.0, abs=1e-10)
    cycle = motion_peaks(wheel).per_cycle()
    assert ends.velocity[1] == pytest.approx(cycle.velocity_max)
    assert ends.acceleration[0] == pytest.approx(cycle.acceleration_start)
    assert ends.jerk[0] == pytest.approx(cycle.jerk_start)
    assert (found.velocity[-2:], found.jerk[-2:]) == pytest.approx((0.0, 0.0))


def test_uniform_motion_has_no_acceleration():
    found = follower_motion(GearDriven(4, 0), [0.1, 0.5, 0.9])
    assert found.angle == pytest.approx([0.1, 0.5, 0.9])
    assert found.velocity == pytest.approx(1.0)
    assert not np.any([found.acceleration, found.jerk])
    with pytest.raises(InvalidValue, match="a slotted wheel"):
        follower_motion("wheel", 0.0)
    with pytest.raises(InvalidValue, match="time must be finite"):
        follower_motion(WHEELS[0], [0.0, math.nan])


def test_the_jerk_at_the_start_stays():
    """The wheel is still taken along at once: Dijksman's aim is met in V alone.

    In a cycle of the same time no gear-driven wheel begins with less acceleration
    than the ordinary ones, which begin alike, external and internal.
    """
    for n in range(4, 25):
        start = [
            motion_peaks(Geneva(n, pins=1, internal=inside)).per_cycle().acceleration_start
            for inside in (False, True)
        ]
        assert start[0] == pytest.approx(start[1], rel=1e-12)
        inward = [GearDriven(n, m, "epicycloid") for m in range(12)]
        outward = [GearDriven(n, Fraction(m, 2)) for m in range(n - 4)]
        for wheel in inward + outward:
            assert motion_peaks(wheel).per_cycle().acceleration_start > 1.05 * start[0]


def test_charts_are_those_of_mechanisms():
    for curve, lobes in [("hypocycloid", ["31/100", 2, "49/10"]), ("epicycloid", [0, "7/10", 9])]:
        chart = motion_ratio_chart(15, [float(Fraction(m)) for m in lobes], curve)
        exact = [GearDriven(15, m, curve).motion_ratio for m in lobes]
        assert chart == pytest.approx(exact, rel=1e-12)
    assert np.isnan(motion_ratio_chart(5, [0.51, 1.0, 3.0], "hypocycloid")).all()
    assert motion_ratio_chart(5, 0.5, "hypocycloid") == 1.0
    with pytest.raises(InvalidValue, match="lobes must be at least 0 and at most 100000"):
        motion_ratio_chart(3, [1e6], "epicycloid")


def test_an_epicycloid_takes_less_than_this():
    """What docs/gear-driven.md says."""
    most = [float(motion_ratio_chart(n, 0.0, "epicycloid")) for n in range(3, 200)]
    assert most == sorted(most)
    assert most[13 - 3] < 1.0 / 3.0 < most[14 - 3]
    assert 0.43 < motion_ratio_chart(10**6, 0.0, "epicycloid") < 0.431


def test_the_search_finds_all_there_is():
    """Against a plain loop over everything, whatever the wish."""
    wished = {
        (curve, m, pins, unused)
        for curve in ("hypocycloid", "epicycloid")
        for m in [Fraction(i, 2) for i in range(13)]
        for pins in (1, 2)
        for unused in (0, 1, 2)
        if _fits(8, m, curve, pins, unused, 0.3, 0.05)
    }
    found = find_mechanisms(8, 0.3, tolerance=0.05, most_lobes=6, most_pins=2, most_unused=2)
    listed = [one.mechanism for one in found]
    assert {(w.curve, w.lobes, w.pins, w.unused_lobes) for w in listed} == wished
    assert len(wished) > 5
    errors = [abs(one.motion_ratio - 0.3) for one in found]
    assert errors == sorted(errors)


def _fits(n, m, curve, pins, unused, wanted, room):
    try:
        wheel = GearDriven(n, m, curve, pins, unused)
    except InvalidValue:
        return False
    return not wheel.through_centre and abs(wheel.motion_ratio - wanted) <= room


def test_what_is_just_on_a_limit_is_found():
    """Six pins never let go at V0 = 1/6, which 1 - 5/6 is not in doubles."""
    exact, dwell = (
        find_mechanisms(12, tolerance=0.0, **wish)
        for wish in ({"motion_ratio": 1.0 / 6.0}, {"motion_ratio": 1.0 - 5.0 / 6.0})
    )
    assert [one.mechanism for one in exact] == [one.mechanism for one in dwell] != []
    closest = min(one.closest_radius for one in exact)
    again = find_mechanisms(12, 1.0 / 6.0, tolerance=0.0, shaft_radius=closest * (1.0 + 1e-14))
    assert len(again) == len(exact)


def test_sizes_are_kept():
    wishes = {"largest_radius": 0.05, "shaft_radius": 0.004, "planet_radius": 0.006}
    found = find_mechanisms(6, 0.1, most_slots=6, **wishes)
    free = find_mechanisms(6, motion_ratio=0.1)
    assert 0 < len(found) < len(free)
    for one in found:
        wheel, size = one.mechanism, one.mechanism.fixed_radius
        theta = np.linspace(0.0, 20.0 * math.pi, 20_001)
        reach = size * wheel.radius(theta)
        assert reach.max() <= 0.05 * (1.0 + 1e-12)
        assert reach.min() >= 0.004
        assert one.closest_radius == pytest.approx(reach.min(), rel=1e-4)
        assert size / abs(wheel.gear_ratio) >= 0.006
        assert wheel.slots <= 6


@pytest.mark.parametrize("wheel", WHEELS[3:], ids=lambda w: f"{w.stations} {w.curve}")
def test_gears_have_the_exact_ratio_and_touch(wheel):
    pairs = gear_pairs(wheel, 0.06)
    assert pairs
    assert gear_pairs(wheel, 1e-3) == []
    for pair in pairs:
        assert Fraction(pair.fixed_teeth, pair.planet_teeth) == abs(wheel.gear_ratio)
        assert pair.reach <= 0.06 * (1.0 + 1e-12)
        sense = -1.0 if pair.internal else 1.0
        distance = abs(pair.fixed_radius + sense * pair.planet_radius)
        assert pair.carrier_length == pytest.approx(distance, rel=1e-12)
    assert [p.module for p in pairs] == sorted((p.module for p in pairs), reverse=True)


@pytest.mark.parametrize("wheel", [GearDriven(12, 5, "epicycloid", pins=6), GearDriven(12, 3)])
def test_planets_have_the_kinetic_energy_of_a_constant_inertia(wheel):
    """Energy of planet and pins at unit carrier speed, from their positions."""
    size, mass, own, pin = 0.03, 0.02, 3e-6, 0.001
    first, _, second, rate = wheel.arms
    theta = np.linspace(0.0, 2.0 * math.pi / abs(1.0 - rate), 97)[:-1]
    twice = mass * (size * first) ** 2 + own * rate**2
    phase = 2.0 * math.pi * np.arange(wheel.pins)[:, None] / wheel.pins
    velocity = first * np.exp(1j * theta) + rate * second * np.exp(1j * (rate * theta + phase))
    total = twice + pin * size**2 * (abs(velocity) ** 2).sum(axis=0)
    constant = planet_inertia(wheel, size, mass, own, pin)
    assert total.mean() == pytest.approx(constant, rel=1e-13)
    swing = 2.0 * pin * size**2 * first * second * rate * np.cos((1.0 - rate) * theta)
    assert total == pytest.approx(constant + (swing if wheel.pins == 1 else 0.0), rel=1e-13)
    assert planet_inertia(wheel, size, mass, own, pin, planets=3) == pytest.approx(3.0 * constant)
