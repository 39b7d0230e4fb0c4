"""What Dijksman's equations and text must read, with the size of the error each slip makes.

A slip that is a formula is evaluated as printed and as corrected over the mechanisms
of the design charts, so that a correction proves itself. Signs, primes and brackets
may be those of the scan.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np

from escapement.mechanisms import GearDriven, Geneva
from escapement.mechanisms.gear_equation import lobe_ratios
from escapement.model import FloatArray
from escapement.sources.printed import EquationErratum, FormulaErratum
from escapement.synthesis import motion_peaks

STATIONS = range(3, 25)
LOBES = tuple(Fraction(i, 2) for i in range(25))

Deviation = Callable[["_Chart"], FloatArray]
"""What a formula leaves over for each mechanism: 0 where it is right."""


@dataclass(frozen=True)
class _Chart:
    """Numbers of every mechanism of the charts; arrays of one shape."""

    k: FloatArray
    gamma: FloatArray
    ratio: FloatArray
    alpha: FloatArray
    carrier: FloatArray
    entry: FloatArray
    cognate_k: FloatArray


def _chart() -> _Chart:
    rows = [
        (
            float(wheel.gear_ratio),
            2.0 * math.pi / wheel.stations,
            wheel.motion_ratio,
            wheel.alpha,
            wheel.arms.first,
            wheel.entry_radius_over_fixed,
            float(wheel.cognate.gear_ratio),
        )
        for wheel in chart_mechanisms()
    ]
    return _Chart(*np.array(rows).T)


@cache
def chart_mechanisms() -> tuple[GearDriven, ...]:
    """Hypocycloids and epicycloids of 3 to 24 stations and up to 12 lobes, with V < 1."""
    return tuple(
        GearDriven(n, m, curve)
        for curve in ("hypocycloid", "epicycloid")
        for n in STATIONS
        for m in LOBES
        if (curve == "epicycloid" or 2 * (m + 1) < n)
        and any(ratio < 1.0 for ratio in lobe_ratios(n, m, curve))
    )


def equations() -> list[EquationErratum]:
    """Every erratum of equations and text, the formulas tried out over the charts."""
    chart = _chart()
    return [slip.tried(lambda formula: float(np.abs(formula(chart)).max())) for slip in _SLIPS]


def start_ratios(per_cycle: bool) -> tuple[float, float]:
    """Least and greatest acceleration at the start, over an ordinary wheel's [-].

    Parameters
    ----------
    per_cycle : bool
        Whether the cycles take the same time, else the motions. Epicycloids are held
        against external wheels, hypocycloids against internal ones.
    """
    ratios = []
    for wheel in chart_mechanisms():
        plain = Geneva(wheel.stations, pins=1, internal=wheel.curve == "hypocycloid")
        own, other = motion_peaks(wheel), motion_peaks(plain)
        if per_cycle:
            own, other = own.per_cycle(), other.per_cycle()
        ratios.append(own.acceleration_start / other.acceleration_start)
    return min(ratios), max(ratios)


def _equation_10(brackets: bool) -> Deviation:
    def left_over(chart: _Chart) -> FloatArray:
        factor, x = 2.0 / chart.k - 1.0, math.pi * chart.k * chart.alpha / (2.0 * math.pi)
        second = np.sin(factor * x + chart.gamma) if brackets else np.sin(factor * x) - chart.gamma
        return factor * np.sin(x) - second

    return left_over


def _equation_14(signed: bool) -> Deviation:
    def left_over(chart: _Chart) -> FloatArray:
        factor = 2.0 / chart.k - 1.0
        x = math.pi * chart.ratio * (np.sign(chart.k) if signed else 1.0)
        return factor * np.sin(x) - np.sin(factor * x + chart.gamma)

    return left_over


_SLIPS = (
    FormulaErratum(
        "condition of existence",
        "alpha + gamma/2 <= pi/2",
        "(alpha + gamma)/2 <= pi/2, as his alpha <= pi - gamma says",
    ),
    FormulaErratum(
        "(9)",
        "V0 = k alpha/(2 pi)",
        "V0 = |k| alpha/(2 pi): k is negative for epicycloids",
        lambda chart: chart.k * chart.alpha / (2.0 * math.pi) / chart.ratio - 1.0,
        lambda chart: np.abs(chart.k) * chart.alpha / (2.0 * math.pi) / chart.ratio - 1.0,
    ),
    FormulaErratum(
        "(10)",
        "... - sin pi V0 (2/k - 1) + 2 pi/n = 0",
        "... - sin[pi V0 (2/k - 1) + 2 pi/n] = 0, V0 with the sign of k",
        _equation_10(brackets=False),
        _equation_10(brackets=True),
    ),
    FormulaErratum(
        "(14), lower sign",
        "V0 > 0",
        "V0 < 0 for epicycloids, as (9) has it; with V0 > 0 it is no mechanism's equation",
        _equation_14(signed=False),
        _equation_14(signed=True),
    ),
    FormulaErratum(
        "cognates",
        "k = R/R0, k' = R'/R0'",
        "k = R0/R, k' = R0'/R', and 1/k' = 1 - 1/k",
    ),
    FormulaErratum(
        "cognates",
        "R'/MC = M0C/R = k/k'",
        "R'/MC = M0M/R = k/k'; M0M too in the relation before it",
        lambda chart: chart.entry * chart.k / (chart.k / chart.cognate_k) - 1.0,
        lambda chart: chart.carrier * chart.k / (chart.k / chart.cognate_k) - 1.0,
    ),
    FormulaErratum(
        "before (16)",
        "at least n(m + 2) slots",
        "n/(m + 2) slots",
    ),
    FormulaErratum(
        "after (16)",
        "g = n/gcd(n, 2m + 3), n/gcd(n, 3m + 4), ... for unused lobes",
        "only where no unused lobe passes over one of these slots: n = 4, m = 1 with one unused "
        "lobe needs all 4 slots, and then uses every lobe",
    ),
    FormulaErratum(
        "figure 8",
        "slot gives instantaneous dwell",
        "the wheel turns uniformly, g = 1 - k/2 = -1: no dwell at all, and a singular position "
        "where the pin crosses the centre",
    ),
    FormulaErratum(
        "introduction",
        "output angles of 360 and 180 degrees are a merit",
        "alpha <= pi - gamma leaves none for n = 1 and 2 either",
    ),
    FormulaErratum(
        "introduction",
        "the jerk at start and end is a fault of ordinary wheels alone",
        "gear-driven wheels start with an acceleration at once as well, and with a greater one "
        "than the ordinary wheel of as many stations",
    ),
)
