"""Equation (8) of gear-driven wheels: no root is missed, and each is a mechanism."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from escapement import GearDriven
from escapement.mechanisms.gear_equation import COGNATES, gear_ratio, lobe_ratios
from gear_chart import LOBES, SOURCES, STATIONS, chart


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
    missing, found = 0, 0
    for curve in SOURCES:
        for n in STATIONS:
            for m in LOBES:
                if curve == "hypocycloid" and 2 * (m + 1) >= n:
                    continue
                ratios = [v for v in lobe_ratios(n, m, curve) if v < 1.0]
                expected, step = scan(n, float(gear_ratio(n, m, curve)))
                assert len(ratios) == expected.size, (n, m, curve)
                assert np.all((ratios >= expected - 1e-12) & (ratios <= expected + step + 1e-12))
                found += len(ratios)
                missing += not ratios
    assert found > 4000
    assert missing > 100


def test_at_most_one_mechanism_and_where_there_is_none():
    """Beside one through the wheel's centre there is never a second mechanism."""
    for curve in SOURCES:
        for n in STATIONS:
            for m in LOBES:
                if curve == "epicycloid" or 2 * (m + 1) < n:
                    ratios = lobe_ratios(n, m, curve)
                    central = (m + 1) / n == Fraction(1, 2) - Fraction(1, n)
                    assert (ratios[-1:] == [1.0]) == central
                    assert len(ratios) <= 1 + (central and curve == "epicycloid")
                    # hypocycloids exist up to the one through the centre
                    beyond = curve == "hypocycloid" and m + 1 > Fraction(n, 2) - 1
                    assert (not ratios) == beyond


def test_follower_turns_by_a_station_and_starts_and_ends_at_rest():
    assert len(chart()) > 4000
    for wheel in (*chart(), *(wheel.cognate for wheel in chart()[::3])):
        ends = np.array([wheel.breaks[0], wheel.breaks[-1]])
        assert 0.0 <= wheel.transmission(ends).g.min() <= wheel.transmission(ends).g.max() < 1e-13
        turned = np.diff(wheel.follower_angle(ends))[0]
        assert turned == pytest.approx(2.0 * math.pi / wheel.stations, abs=1e-13)
        if wheel.curve in SOURCES:
            assert 0.0 < wheel.alpha <= math.pi - 2.0 * math.pi / wheel.stations
        assert 0.0 < wheel.motion_ratio < 1.0


def test_no_wheel_turns_back():
    """g is positive inside the engagement and monotone from dead centre to the exit."""
    inside = np.linspace(0.0, 1.0, 33)[:-1]
    for wheel in chart()[::7]:
        found = wheel.transmission(inside * wheel.breaks[-1])
        assert found.g.min() > 0.0
        assert (np.diff(found.g) < 0.0).all()
        assert (found.dg[1:] < 0.0).all()


def test_arm_of_equation_15():
    """MC/R = k sin(alpha + gamma)/(2 sin(k alpha/2)), and M0C = R0 cos((alpha + gamma)/2)."""
    for n, m, curve in [(12, 3, "hypocycloid"), (12, 5, "epicycloid"), (4, 1, "epicycloid")]:
        wheel = GearDriven(n, m, curve)
        k, end = float(wheel.gear_ratio), wheel.alpha + 2.0 * math.pi / n
        arm = math.sin(end) / (2.0 * math.sin(0.5 * k * wheel.alpha))
        assert wheel.arms.second == pytest.approx(arm, rel=1e-13)
        assert wheel.entry_radius_over_fixed == pytest.approx(math.cos(0.5 * end), rel=1e-13)


def test_roots_against_many_digits():
    mpmath.mp.dps = 40
    for n, m, curve in [(12, 3, "hypocycloid"), (3, 29, "epicycloid"), (24, "1/5", "epicycloid")]:
        wheel = GearDriven(n, m, curve)
        k, gamma = mpmath.mpf(wheel.gear_ratio.numerator) / wheel.gear_ratio.denominator, 0
        gamma = 2 * mpmath.pi / n
        alpha = mpmath.findroot(
            lambda a, k=k, gamma=gamma: (
                (2 / k - 1) * mpmath.sin(k * a / 2) - mpmath.sin(a * (1 - k / 2) + gamma)
            ),
            wheel.alpha,
        )
        assert wheel.alpha == pytest.approx(float(alpha), rel=4e-15)


def test_two_wheels_are_always_engaged():
    """p V0 = 1: six pins on an epicycloid for 12 stations, two on a hypocycloid for 24.

    V0 = 1/p and a rational c make the ratio of two sines of rational angles rational,
    which leaves c = 2 and c = -1/2 only.
    """
    continuous = {
        (curve, n, m, round(1.0 / ratio))
        for curve in SOURCES
        for n in STATIONS
        for m in LOBES
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
