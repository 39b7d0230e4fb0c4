"""What Dijksman's equations must read, with the size of the error each slip makes.

A slip that is a formula is evaluated as printed and as corrected over the mechanisms
of the design charts, so that a correction proves itself. Signs, primes and brackets
may be those of the scan.
"""

from fractions import Fraction
from functools import cache

import numpy as np

from escapement.mechanisms import GearDriven, Geneva
from escapement.mechanisms.gear_equation import lobe_ratios
from escapement.sources.printed import Slip, read_slips
from escapement.synthesis import motion_peaks

STATIONS = range(3, 25)
LOBES = tuple(Fraction(i, 2) for i in range(25))


@cache
def chart_mechanisms() -> tuple[GearDriven, ...]:
    """Hypocycloids and epicycloids of 3 to 24 stations and up to 12 lobes, with V < 1."""
    return tuple(
        GearDriven(n, m, curve)
        for curve in ("hypocycloid", "epicycloid")
        for n in STATIONS
        for m in LOBES
        # a hypocycloid of so many lobes leaves the pin no dwell
        if (curve == "epicycloid" or 2 * (m + 1) < n)
        and any(ratio < 1.0 for ratio in lobe_ratios(n, m, curve))
    )


def equations() -> list[Slip]:
    """Every slip of equations and text, the formulas tried out over the charts."""
    rows = [
        (
            wheel.stations, float(wheel.gear_ratio), float(wheel.cognate.gear_ratio), wheel.alpha,
            wheel.motion_ratio, wheel.arms.first, wheel.entry_radius_over_fixed,
        )
        for wheel in chart_mechanisms()
    ]  # fmt: skip
    # one row a mechanism, one array a quantity
    n, k, cognate_k, alpha, ratio, carrier, entry = np.array(rows).T
    gamma, factor, turn = 2.0 * np.pi / n, 2.0 / k - 1.0, alpha / (2.0 * np.pi)
    # pi V0 in (10) and (14), with the sign of k and, as (14) has it, without
    signed, positive = np.pi * k * turn, np.pi * ratio
    # each is what the formula, all of it brought to one side, leaves over
    deviations = {
        "(9)": (k * turn / ratio - 1.0, np.abs(k) * turn / ratio - 1.0),
        "(10)": (
            factor * np.sin(signed) - (np.sin(factor * signed) - gamma),
            factor * np.sin(signed) - np.sin(factor * signed + gamma),
        ),
        "(14)": tuple(
            factor * np.sin(x) - np.sin(factor * x + gamma)
            for x in (positive, np.sign(k) * positive)
        ),
        "cognate": (entry * cognate_k - 1.0, carrier * cognate_k - 1.0),
    }
    return read_slips("dijksman", deviations)


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
