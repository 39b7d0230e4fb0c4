"""Dijksman's equation for the design position of a gear-driven Geneva wheel.

The driving pin must enter along a slot. With k = R0/R, gamma = 2 pi/n and the
carrier angle alpha over which one pin drives, that is his equation (8); in terms of
x = |k| alpha/2 = pi V0 it is his (10) and (14),

    c sin(x) = sin(c x + gamma),    c = 2/k - 1 for k > 2, 1 - 2/k for k < 0.

The derivative c (cos x - cos(c x + gamma)) vanishes where c x + gamma = +-x + 2 pi j.
An epicycloid, c > 1, has its first extremum at (2 pi - gamma)/(c + 1), and between 0 and
there one root; the next lies beyond alpha = pi - gamma. A hypocycloid, -1 < c < 0, has one
extremum below pi, a minimum at gamma/(1 - c), and a root after it for m < n/2 - 2. At m = n/2 - 2
both curves have the root x = pi as well, and the pin passes through the wheel's centre.
"""

import math
from fractions import Fraction

from escapement.base import validate

CURVES = ("hypocycloid", "epicycloid", "contracted-hypocycloid", "pericycloid")
"""Protracted hypocycloid and epicycloid, and the curve cognate of each (12a-d)."""
COGNATES = dict(zip(CURVES, (*CURVES[2:], *CURVES[:2]), strict=True))
"""The other pair of gears that traces the same curve."""
MOST_LOBES = 100_000
"""Greatest number of lobes, and of unused ones; the search for a mechanism then takes a
second."""


def gear_ratio(stations: int, lobes: Fraction, curve: str) -> Fraction:
    """k = R0/R from stations, lobes and curve (12a-d) [-]; raises InvalidValue."""
    share = (lobes + 1) / stations
    if curve in CURVES[::2] and share >= Fraction(1, 2):
        rule = f"below stations/2 - 1 = {float(Fraction(stations, 2) - 1):g} for a {curve}"
        remedy = "fewer lobes, more stations, or an epicycloid"
        raise validate.fail("lobes", rule, str(lobes), remedy)
    return 1 / dict(zip(CURVES, (share, -share, 1 - share, 1 + share), strict=True))[curve]


def lobe_ratios(stations: int, lobes: Fraction, curve: str) -> list[float]:
    """V0 of every mechanism, in order of alpha; empty if there is none [-].

    Roots of (10) with alpha <= pi - gamma and V0 <= 1. Cognates share them.
    """
    outside = curve in CURVES[1::2]
    c = float(2 * (lobes + 1) / stations + (1 if outside else -1))
    gamma, central = 2.0 * math.pi / stations, 2 * (lobes + 2) == stations

    def value(x: float) -> float:
        return c * math.sin(x) - math.sin(c * x + gamma)

    found = [1.0] if central else []
    if not outside and 2 * (lobes + 2) >= stations:
        return found
    low, high = gamma / (1.0 - c), math.pi
    if outside:
        low, high = 0.0, (2.0 * math.pi - gamma) / (c + 1.0)
    # bisection ends at the doubles around the root, and needs no SciPy
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (low, middle) if value(middle) > 0.0 else (middle, high)
    ratio = min(low, high, key=lambda x: abs(value(x))) / math.pi
    # 1/6 and 1/2 lose their rounding error, so that 6 and 2 pins engage without a gap. The sines
    # of two rational parts of a turn have a rational ratio only if it is 0, 1/2, 1, 2 or its
    # negative, so no other rational V0 below 1 solves (10).
    return [next((v for v in (1.0 / 6.0, 0.5) if abs(ratio - v) < 4e-16), ratio), *found]


def arm_length(k: float, alpha: float, gamma: float) -> float:
    """MC/R0, negative where the pin points inwards at dead centre (k < 0) [-].

    Dijksman's (15) divides zero by zero where V0 = 1; the projection of
    M0C - M0M on the arm does not.
    """
    entry = math.cos(0.5 * (alpha + gamma))
    half, half_turn = 0.5 * (alpha + gamma), 0.5 * k * alpha
    return entry * math.cos(half - half_turn) - (1.0 - 1.0 / k) * math.cos(half_turn)
