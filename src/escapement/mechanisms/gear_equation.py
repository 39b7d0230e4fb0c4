"""Dijksman's equation for the design position of a gear-driven Geneva wheel.

The driving pin must enter along a slot. With k = R0/R, gamma = 2 pi/n and the
carrier angle alpha over which one pin drives, that is his equation (8); in terms of
x = |k| alpha/2 = pi V0 it is his (10) and (14),

    c sin(x) = sin(c x + gamma),    c = 2/k - 1 for k > 2, 1 - 2/k for k < 0.

c + 1 is positive for either, and c lies in (-1, 0) for hypocycloids, above 1 for
epicycloids. The derivative c (cos x - cos(c x + gamma)) vanishes where
c x + gamma = +-x + 2 pi j: the extrema are known in closed form, so between
neighbours the function is monotone and no root can be missed. A double root would
need c = +-1 or sin x = 0 and does not occur.
"""

import math
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise

from escapement import validate

CURVES = ("hypocycloid", "epicycloid", "contracted-hypocycloid", "pericycloid")
"""Protracted hypocycloid and epicycloid, and the curve cognate of each (12a-d)."""
COGNATES = dict(zip(CURVES, (*CURVES[2:], *CURVES[:2]), strict=True))
"""The other pair of gears that traces the same curve."""
MOST_LOBES = 100_000
"""Most unreal lobes, and most unused ones; the search for a mechanism takes a second of them."""

_EDGE = 1e-12
"""A root this close to x = pi is V0 = 1: there the equation is c + 1 = 2 j - 2/n exactly."""


def gear_ratio(stations: int, lobes: Fraction, curve: str) -> Fraction:
    """k = R0/R from stations, lobes and curve (12a-d) [-]; raises InvalidValue."""
    share = (lobes + 1) / stations
    if curve == "epicycloid":
        return -1 / share
    if curve == "pericycloid":
        return 1 / (1 + share)
    if not share < Fraction(1, 2):
        rule = f"below stations/2 - 1 = {float(Fraction(stations, 2) - 1):g} for a {curve}"
        remedy = "fewer lobes, more stations, or an epicycloid"
        raise validate.fail("lobes", rule, str(lobes), remedy)
    return 1 / share if curve == "hypocycloid" else 1 / (1 - share)


def lobe_ratios(stations: int, lobes: Fraction, curve: str) -> list[float]:
    """V0 of every mechanism there is, in order of alpha; empty where there is none [-].

    Roots of (10) with alpha <= pi - gamma and V0 <= 1. Cognates share them.
    """
    source = curve if curve in CURVES[:2] else COGNATES[curve]
    k = gear_ratio(stations, lobes, source)
    limit = existence_limit(k, stations)
    return [v for v in design_position(k, stations) if v <= float(limit) * (1.0 + 1e-14)]


def design_position(k: Fraction, stations: int) -> list[float]:
    """All V0 in (0, 1] that solve (10), ascending.

    Parameters
    ----------
    k : Fraction
        Gear ratio R0/R [-], > 2 or < 0.
    stations : int
        Stations n of the wheel.

    Returns
    -------
    list of float
        Ratios of times V0 = |k| alpha/(2 pi), whether alpha keeps to its limit
        pi - gamma or not.
    """
    c = float(_coefficient(k))
    gamma = 2.0 * math.pi / stations

    def value(x: float) -> float:
        return c * math.sin(x) - math.sin(c * x + gamma)

    through_centre = (_coefficient(k) + Fraction(2, stations)).denominator == 1
    end = math.pi * (1.0 - _EDGE) if through_centre else math.pi
    marks = [0.0, *sorted(x for x in _extrema(c, gamma) if 0.0 < x < end), end]
    roots = [
        _root(value, low, high) for low, high in pairwise(marks) if value(low) * value(high) < 0.0
    ]
    return [_exact(x / math.pi) for x in roots] + ([1.0] if through_centre else [])


def _exact(ratio: float) -> float:
    """1/6 and 1/2 without their rounding error, so that 6 and 2 pins engage without a gap.

    The sines of two rational parts of a turn have a rational ratio only if it is 0,
    1/2, 1, 2 or its negative, so no other rational V0 below 1 solves (10).
    """
    return next((v for v in (1.0 / 6.0, 0.5) if abs(ratio - v) < 4e-16), ratio)


def existence_limit(k: Fraction, stations: int) -> Fraction:
    """Largest V0 that leaves a mechanism, from alpha <= pi - gamma [-]."""
    return abs(k) * (Fraction(1, 2) - Fraction(1, stations))


def _coefficient(k: Fraction) -> Fraction:
    return 2 / k - 1 if k > 0 else 1 - 2 / k


def _extrema(c: float, gamma: float) -> list[float]:
    """Where c x + gamma = x + 2 pi j or -x + 2 pi j, around 0 <= x <= pi."""
    turn = 2.0 * math.pi
    most = math.ceil((abs(c) + 1.0) / 2.0) + 2
    return [
        x
        for j in range(-most, most + 1)
        for x in ((turn * j - gamma) / (c - 1.0), (turn * j - gamma) / (c + 1.0))
    ]


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """The root of a monotone function between two points of different sign, by halving."""
    rising = function(high) > 0.0
    while low < (middle := 0.5 * (low + high)) < high:
        if (function(middle) > 0.0) == rising:
            high = middle
        else:
            low = middle
    return min(low, high, key=lambda x: abs(function(x)))


def arm_length(k: float, alpha: float, gamma: float) -> float:
    """MC/R0, negative where the pin points inwards at dead centre (k < 0) [-].

    Dijksman's (15) divides zero by zero where V0 = 1; the projection of
    M0C - M0M on the arm does not.
    """
    entry = math.cos(0.5 * (alpha + gamma))
    half, turned = 0.5 * (alpha + gamma), 0.5 * k * alpha
    return entry * math.cos(half - turned) - (1.0 - 1.0 / k) * math.cos(turned)
