"""Gear-driven wheels: their motion, cognates, slots, and what cannot be."""

import math
from fractions import Fraction

import numpy as np
import pytest

from escapement import Escapement, GearDriven, Inertia
from escapement.constant_speed import jerk_function
from escapement.errors import InvalidValue
from escapement.mechanisms.gear_equation import COGNATES, CURVES, lobe_ratios
from escapement.model import Mechanism
from gear_chart import chart, position


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize(("n", "m"), [(12, 3), (12, 0), (24, 5), (9, "1/2"), (7, "2/3")])
def test_transmission_is_that_of_the_path(curve, n, m):
    wheel = GearDriven(n, m, curve)
    theta = np.linspace(*wheel.breaks[::2], 41)[1:-1]
    k, arms = float(wheel.gear_ratio), wheel.arms
    assert arms.first == pytest.approx(1.0 - 1.0 / k, rel=1e-14)
    at, speed, rate = position(k, arms.first, arms.second, theta)
    q = speed / at
    forward = 1.0 if wheel.turns_with_driver else -1.0
    found = wheel.transmission(theta)
    assert found.g == pytest.approx(forward * q.imag, abs=1e-12)
    assert found.u == pytest.approx(q.real, abs=1e-12)
    assert found.dg == pytest.approx(forward * (rate / at - q * q).imag, abs=1e-11)
    assert wheel.radius(theta) == pytest.approx(abs(at), rel=1e-13)
    middle = position(k, arms.first, arms.second, 0.0)[0]
    angle = forward * np.unwrap(np.angle(at / middle))
    assert wheel.follower_angle(theta) == pytest.approx(angle, abs=1e-13)
    slope = jerk_function(wheel, theta)  # of an interpolant of g'
    scale = np.abs(slope).max()
    assert wheel.jerk(theta) == pytest.approx(slope, abs=1e-9 * scale)
    assert isinstance(wheel, Mechanism)


def test_cognates_trace_the_same_path():
    for source in chart()[::5]:
        other = source.cognate
        assert other.curve == COGNATES[source.curve]
        assert other.cognate == source
        theta = np.linspace(-math.pi, math.pi, 25) / abs(float(source.gear_ratio))
        k = float(source.gear_ratio)
        path = position(k, source.arms.first, source.arms.second, theta)[0]
        scale = k * source.arms.second  # its fixed gear over this one's
        same = (
            scale
            * position(
                float(other.gear_ratio), other.arms.first, other.arms.second, (1.0 - k) * theta
            )[0]
        )
        assert scale > 0.0
        assert np.abs(same - path).max() < 1e-13 * max(1.0, scale)
        # both spend the same share of a cycle in motion, and turn the wheel alike
        assert other.motion_ratio == source.motion_ratio
        assert other.alpha == pytest.approx(abs(1.0 - k) * source.alpha, rel=1e-14)
        assert other.cell_angle == pytest.approx(abs(1.0 - k) * source.cell_angle, rel=1e-14)
        g, u = source.transmission(theta[12:14]).g, source.transmission(theta[12:14]).u
        turned = other.transmission(abs(1.0 - k) * theta[12:14])
        assert turned.g * abs(1.0 - k) == pytest.approx(g, rel=1e-12)
        assert turned.u * abs(1.0 - k) == pytest.approx(u, rel=1e-9, abs=1e-12)


def test_dimensions_of_cognates():
    """R' = R0' - (R/R0) R0', carrier and arm trade places (Dijksman, unnumbered)."""
    for source in (GearDriven(12, 3), GearDriven(12, 5, "epicycloid")):
        other = source.cognate
        assert 1 / other.gear_ratio == 1 - 1 / source.gear_ratio
        scale = float(source.gear_ratio) * source.arms.second
        assert scale * other.carrier_over_fixed == pytest.approx(source.arm_over_fixed, rel=1e-14)
        assert scale * other.arm_over_fixed == pytest.approx(source.carrier_over_fixed, rel=1e-14)


def follow(wheel, arrivals):
    """Slots of the wheel that pins enter, in whole parts of its circumference.

    Pin j arrives at carrier angle (i p + j) lobe/p in that direction; at each arrival
    that is used the wheel steps back by gamma against the carrier.
    """
    lobe = 1 / abs(wheel.gear_ratio)  # of a turn
    step = Fraction(1, wheel.stations)
    wheel_turn, used = Fraction(0), set()
    for i in range(arrivals):
        direction = i * lobe / wheel.pins
        if i % (wheel.unused_lobes + 1) == 0:
            used.add((direction - wheel_turn) % 1)
            wheel_turn -= step
    return used


@pytest.mark.parametrize(
    ("arguments", "slots"),
    [
        ((4, 1, "epicycloid"), 4),
        ((12, 5, "epicycloid"), 12),
        ((12, 3, "hypocycloid"), 12),
        ((12, 5, "epicycloid", 6), 6),
        ((24, 5, "hypocycloid", 2), 6),
        ((12, 0, "epicycloid", 1, 1), 4),
        ((12, 2, "hypocycloid", 1, 0), 3),
        ((9, "1/2", "epicycloid"), 18),
        ((11, "1/2", "hypocycloid", 1, 2), 2),
    ],
)
def test_slots(arguments, slots):
    wheel = GearDriven(*arguments)
    entered = follow(wheel, 40 * wheel.slots * (wheel.unused_lobes + 1))
    assert wheel.slots == len(entered)
    assert wheel.slots == slots
    cell = 2.0 * math.pi / abs(float(wheel.gear_ratio)) * (wheel.unused_lobes + 1) / wheel.pins
    assert wheel.cell_angle == pytest.approx(cell)
    assert wheel.motion_ratio == pytest.approx(wheel.alpha / cell)


def test_unused_lobes_must_find_no_slot():
    """Where a slot stands in the way of an unused lobe the number is refused, else not."""
    refused = accepted = 0
    for n in range(3, 20):
        for m in range(8):
            for unused in range(1, 5):
                free = GearDriven(n, m, "epicycloid")
                spacing = Fraction((unused + 1) * (m + 1) + 1, n)
                slots = {i * spacing % 1 for i in range(n)}
                arrivals = {Fraction(i * (m + 1) + 1, n) % 1 for i in range(1, unused + 1)}
                if slots & arrivals:
                    with pytest.raises(InvalidValue, match="unused_lobes must leave the pin"):
                        GearDriven(n, m, "epicycloid", 1, unused)
                    refused += 1
                else:
                    wheel = GearDriven(n, m, "epicycloid", 1, unused)
                    assert wheel.slots == len(slots)
                    assert wheel.motion_ratio == pytest.approx(free.motion_ratio / (unused + 1))
                    accepted += 1
    assert min(refused, accepted) > 50


@pytest.mark.parametrize("n", [4, 6, 10, 24])
@pytest.mark.parametrize(("curve", "sign"), [("hypocycloid", -1.0), ("epicycloid", 1.0)])
def test_through_the_centre(n, curve, sign):
    """V = 1 with one pin: |k| = 2n/(n-2), the wheel turns uniformly and never rests."""
    m = Fraction(n, 2) - 2
    count = len(lobe_ratios(n, m, curve))
    wheel = GearDriven(n, m, curve, solution=count)
    assert wheel.through_centre
    assert wheel.motion_ratio == 1.0
    assert wheel.alpha == pytest.approx(math.pi - 2.0 * math.pi / n, rel=1e-15)
    assert wheel.entry_radius_over_fixed == wheel.closest_radius_over_fixed == 0.0
    k = float(wheel.gear_ratio)
    theta = np.linspace(-0.49, 0.49, 9) * wheel.alpha
    at, speed, _ = position(k, wheel.arms.first, wheel.arms.second, theta)
    assert (speed / at).imag == pytest.approx(1.0 - k / 2.0, rel=1e-12)
    assert wheel.transmission(theta).g == pytest.approx(abs(1.0 - k / 2.0), rel=1e-15)
    assert wheel.transmission(theta).u == pytest.approx((speed / at).real, rel=1e-11, abs=1e-12)
    assert np.isinf(wheel.transmission(wheel.breaks[-1]).u)
    assert wheel.turns_with_driver == (sign > 0.0)
    turned = np.diff(wheel.follower_angle(np.array(wheel.breaks)[::2]))[0]
    assert turned == pytest.approx(wheel.follower_step, rel=1e-14)
    step = 2.0 * math.pi / n
    assert turned == pytest.approx(step if sign < 0.0 else 2.0 * math.pi - step, rel=1e-14)
    with pytest.raises(InvalidValue, match="passes through the wheel's centre"):
        Escapement(wheel, Inertia(1.0, 1.0), 1.0, 0.1)


IMPOSSIBLE = {
    "two stations": ((2, 0), "stations must be .* at least 3, got 2"),
    "negative lobes": ((4, -1, "epicycloid"), "lobes must be a rational number of at least 0.*-1"),
    "irrational": ((4, math.sqrt(2.0), "epicycloid"), "lobes must be a rational number.*1.414"),
    "lobes in words": ((4, "one", "epicycloid"), "lobes must be a rational number.*'one'"),
    "division by zero": ((4, "1/0", "epicycloid"), "lobes must be a rational"),
    "not a number": ((4, math.nan, "epicycloid"), "lobes must be a rational"),
    "truth": ((4, True, "epicycloid"), "lobes must be a rational number.*True"),
    "too many lobes": ((6, 2), "lobes must be below stations/2 - 1 = 2 for a hypocycloid.*'2'"),
    "the same cognate": ((6, 2, "contracted-hypocycloid"), "lobes must be below"),
    "beyond the limit": ((5, 1), "no mechanism corresponds to stations 5, lobes 1.*alpha <= pi"),
    "unknown curve": ((5, 1, "epicycle"), "curve must be .*did you mean 'epicycloid'"),
    "no pin": ((4, 1, "epicycloid", 0), "pins must be .* at least 1, got 0"),
    "too many pins": ((4, 1, "epicycloid", 9), "pins must be at most 8 .*0.119282"),
    "negative lobe": ((4, 1, "epicycloid", 1, -1), "unused_lobes must be .* at least 0"),
    "slot in the way": ((6, "1/2", "epicycloid", 1, 1), "unused_lobes .*where lobe 1 passes"),
    "dwell at full speed": ((12, 4, "hypocycloid", 1, 2), "unused_lobes must be 0 .*jump"),
    "lobes without end": ((4, 100_001, "epicycloid"), "lobes must be at most 100000, got '100001'"),
    "unused ones without end": ((4, 1, "epicycloid", 1, 10**6), "unused_lobes must be .*100000"),
    "second of one": ((4, 1, "epicycloid", 1, 0, 2), "solution must be at most 1 here, got 2"),
    "no radius": ((4, 1, "epicycloid", 1, 0, 1, 0.0), "fixed_radius must be greater than 0"),
}


@pytest.mark.parametrize(("arguments", "words"), IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_what_cannot_be_is_one_line(arguments, words):
    with pytest.raises(InvalidValue, match=words) as caught:
        GearDriven(*arguments)
    assert "\n" not in str(caught.value)
