"""Design charts: the ratio of times over the number of unreal lobes."""

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.errors import InvalidValue
from escapement.mechanisms.gear_equation import CURVES, MOST_LOBES, lobe_ratios
from escapement.model import FloatArray

_EDGE = 1e-12
_GRID = 501  # two roots closer than a step of this grid are one for a designer


def motion_ratio_chart(stations: int, lobes: ArrayLike, curve: str = CURVES[0]) -> FloatArray:
    """V0 of one pin over the number of lobes, a line of Dijksman's charts.

    Parameters
    ----------
    stations : int
        Stations n, >= 3.
    lobes : array_like
        Unreal lobes m [-], from 0 to 100 000, of any real value.
    curve : str
        "hypocycloid", "epicycloid" or a cognate of theirs.

    Returns
    -------
    ndarray of the shape of `lobes`
        V0 [-]; NaN where no mechanism corresponds. A hypocycloid needs
        m <= n/2 - 2, where V0 reaches 1.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.

    Source: Dijksman (1974), eq. 14 with V0 counted negative for the epicycloid, as
    his (9) does.
    """
    n = validate.integer("stations", stations, 3, "the wheel needs 3 stations or more")
    name = validate.choice("curve", curve, CURVES)
    values = validate.numbers("lobes", lobes, "give numbers of lobes")
    if not np.all((values >= 0.0) & (values <= MOST_LOBES)):
        rule = f"at least 0 and at most {MOST_LOBES}"
        raise validate.fail("lobes", rule, lobes, "give numbers of lobes")
    found = [_ratio(n, Fraction(float(m)), name) for m in values.reshape(-1)]
    return np.array(found).reshape(values.shape)


def lobes_for(stations: int, motion_ratio: float, curve: str = CURVES[0]) -> list[float]:
    """Numbers of lobes that give a ratio of times with one pin, ascending.

    The chart read the other way round, up to 100 000 lobes. They are real numbers: take a
    rational one near by.

    Parameters
    ----------
    stations : int
        Stations n, >= 3.
    motion_ratio : float
        Wanted V0 [-], in (0, 1).
    curve : str
        "hypocycloid", "epicycloid" or a cognate of theirs.

    Returns
    -------
    list of float
        Empty where the chart does not reach this ratio; two near a hypocycloid's
        least one.
    """
    n = validate.integer("stations", stations, 3, "the wheel needs 3 stations or more")
    name = validate.choice("curve", curve, CURVES)
    wanted = validate.positive("motion_ratio", motion_ratio, "give V0 between 0 and 1")
    if wanted >= 1.0:
        raise validate.fail("motion_ratio", "below 1", motion_ratio, "give V0 between 0 and 1")
    # with x = pi V0 and c = +-2/k - 1 the equation is c sin x = sin(c x + gamma); c goes
    # from m = 0 to alpha = pi - gamma, or to the hypocycloid through the wheel's centre
    gamma, x = 2.0 * math.pi / n, math.pi * wanted
    outside = name in CURVES[1::2]
    start = 1.0 if outside else -1.0
    low, high = start + 2.0 / n, 1.0 + (math.pi - gamma) / x if outside else -2.0 / n

    def value(c: float) -> float:
        return c * math.sin(x) - math.sin(c * x + gamma)

    if high < low - _EDGE:
        return []
    grid = np.linspace(low - _EDGE, high + _EDGE, _GRID)  # so that m = 0 is on the chart
    found = [max((c - start) * n / 2.0 - 1.0, 0.0) for c in _roots(value, grid)]
    return [m for m in found if m <= MOST_LOBES]


def _ratio(stations: int, lobes: Fraction, curve: str) -> float:
    try:
        found = lobe_ratios(stations, lobes, curve)
    except InvalidValue:  # no hypocycloid has so many lobes
        found = []
    return found[0] if found else math.nan


def _roots(function: Callable[[float], float], grid: FloatArray) -> list[float]:
    """One root between every two neighbours of different sign."""
    from scipy.optimize import brentq

    values = np.array([function(c) for c in grid])
    places = np.flatnonzero(np.sign(values[1:]) * np.sign(values[:-1]) < 0.0)
    return [float(brentq(function, grid[i], grid[i + 1], xtol=1e-15)) for i in places]
