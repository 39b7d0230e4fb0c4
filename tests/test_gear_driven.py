"""Gear-driven wheels: roots of equation (8), motion, cognates, slots, and refusals."""

import math
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from escapement import Escapement, GearDriven, Inertia
from escapement.base.errors import InvalidValue
from escapement.mechanisms.gear_equation import COGNATES, CURVES, gear_ratio, lobe_ratios
from escapement.mechanisms.protocol import Mechanism
from gear_chart import LOBES, SOURCES, STATIONS, chart, position


def tangency(k, gamma, alpha):
    """Zero where an arm exists with which the pin stands on a slot and moves along it.

    At -alpha/2 both the pin and its velocity lie on the ray at gamma/2: two equations,
    linear in the two vectors, whose determinant this is. Nothing of (8) enters.
    """
    a, b = (alpha + gamma) / 2.0, ((k - 1.0) * alpha - gamma) / 2.0
    return (k - 1.0) * np.sin(a) * np.cos(b) - np.cos(a) * np.sin(b)


def scan(n, k):
    """V0 of each sign change of `tangency` over a fine grid of alpha."""
    gamma = 2.0 * math.pi / n
    last = min(math.pi - gamma, 2.0 * math.pi / abs(k))
    alpha = np.linspace(0.0, last * (1.0 - 1e-9), 4001)[1:]
    sign = np.sign(tangency(k, gamma, alpha))
    place = np.flatnonzero(sign[1:] != sign[:-1])
    return abs(k) / (2.0 * math.pi) * alpha[place], last * abs(k) / (2.0 * math.pi) / 4000


def test_no_solution_is_missed():
    """Beside one through the wheel's centre there is never a second mechanism."""
    missing, found = 0, 0
    for curve, n, m in product(SOURCES, STATIONS, LOBES):
        if curve == "hypocycloid" and 2 * (m + 1) >= n:
            continue
        every = lobe_ratios(n, m, curve)
        ratios = [v for v in every if v < 1.0]
        expected, step = scan(n, float(gear_ratio(n, m, curve)))
        assert len(ratios) == expected.size, (n, m, curve)
        assert np.all((ratios >= expected - 1e-12) & (ratios <= expected + step + 1e-12))
        central = (m + 1) / n == Fraction(1, 2) - Fraction(1, n)
        assert (every[-1:] == [1.0]) == central
        assert len(every) <= 1 + (central and curve == "epicycloid")
        # hypocycloids exist up to the one through the centre
        assert (not every) == (curve == "hypocycloid" and m + 1 > Fraction(n, 2) - 1)
        found += len(ratios)
        missing += not ratios
    assert found > 2000
    assert missing > 50


def test_follower_turns_by_a_station_from_rest_to_rest_and_never_back():
    assert len(chart()) > 2000
    for wheel in (*chart()[::3], *(wheel.cognate for wheel in chart()[1::9])):
        ends = np.array([wheel.breaks[0], wheel.breaks[-1]])
        assert 0.0 <= wheel.transmission(ends).g.min() <= wheel.transmission(ends).g.max() < 1e-13
        turned = np.diff(wheel.follower_angle(ends))[0]
        assert turned == pytest.approx(2.0 * math.pi / wheel.stations, abs=1e-13)
        if wheel.curve in SOURCES:
            assert 0.0 < wheel.alpha <= math.pi - 2.0 * math.pi / wheel.stations
        assert 0.0 < wheel.motion_ratio < 1.0
        # and never turns back: g falls all the way from dead centre to the exit
        inside = wheel.transmission(np.linspace(0.0, 1.0, 33)[:-1] * wheel.breaks[-1])
        assert inside.g.min() > 0.0
        assert (np.diff(inside.g) < 0.0).all()


def test_two_wheels_are_always_engaged():
    """p V0 = 1: six pins on an epicycloid for 12 stations, two on a hypocycloid for 24.

    V0 = 1/p and a rational c make the ratio of two sines of rational angles rational,
    which leaves c = 2 and c = -1/2 only.
    """
    continuous = {
        (curve, n, m, round(1.0 / ratio))
        for curve, n, m in product(SOURCES, STATIONS, LOBES)
        if curve == "epicycloid" or 2 * (m + 1) < n
        for ratio in lobe_ratios(n, m, curve)
        if ratio < 1.0 and abs(1.0 / ratio - round(1.0 / ratio)) < 1e-9
    }
    assert continuous == {("epicycloid", 12, 5, 6), ("hypocycloid", 24, 5, 2)}
    for curve, n, m, pins in continuous:
        for name in (curve, COGNATES[curve]):
            wheel = GearDriven(n, m, name, pins=pins)
            assert wheel.continuous
            assert wheel.motion_ratio == 1.0
            assert wheel.cell_angle == pytest.approx(wheel.alpha, rel=1e-15)
            assert not GearDriven(n, m, name, pins=pins - 1).continuous


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
