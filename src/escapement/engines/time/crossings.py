"""Every root of a smooth function that is sampled at the steps of a solver and between them.

solve_ivp compares the signs of an event function at the ends of a step, so that it misses
two roots inside one step. With a load an engagement may have two pin reversals, as close
to each other as one likes (PHYSICS.md 2).
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from escapement.model import FloatArray

_PER_STEP = 8
"""Samples of each solver step."""
_FINEST = 1e-18
"""Absolute error of a root, for a piece whose time is of order one."""
ROUNDING = 1e-9
"""Of the greatest value: less than this at the end of a piece may be rounding."""

RealFunction = Callable[[float], float]


def sample_times(steps: FloatArray) -> FloatArray:
    """The ends of a solver's steps, with evenly spaced times inside each."""
    inner = np.arange(_PER_STEP) / _PER_STEP
    times = steps[:-1, None] + np.diff(steps)[:, None] * inner
    return np.append(times.reshape(-1), steps[-1])


def find_roots(function: RealFunction, x: FloatArray, f: FloatArray) -> list[float]:
    """All roots of `function`, ascending, given its values `f` at `x`.

    Where |f| has a minimum between values of one sign, that minimum is computed, so that
    a pair of close roots is found. At the ends the sign of `f` counts, whatever the sign
    of the function, which may be rounding there.
    """
    x, f = _add_dips(function, x, f)
    sides = np.sign(f)
    changes = np.nonzero(sides[:-1] * sides[1:] < 0.0)[0]
    return [_root_between(function, float(x[i]), float(x[i + 1])) for i in changes]


def _root_between(function: RealFunction, low: float, high: float) -> float:
    at_low, at_high = function(low), function(high)
    if np.sign(at_low) * np.sign(at_high) < 0.0:
        return float(brentq(function, low, high, xtol=_FINEST, rtol=1e-15, maxiter=500))
    # one end is a root up to rounding, which hides the change of sign
    return low if abs(at_low) < abs(at_high) else high


def _add_dips(
    function: RealFunction, x: FloatArray, f: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Samples, with the minimum of |f| added wherever f may cross zero twice between two."""
    size, sides = np.abs(f), np.sign(f)
    inner = np.nonzero(
        (size[1:-1] <= size[:-2])
        & (size[1:-1] <= size[2:])
        & (sides[:-2] * sides[1:-1] > 0.0)
        & (sides[1:-1] * sides[2:] > 0.0)
        & (size[1:-1] < 0.1 * size.max(initial=0.0))
    )[0]
    # index of each least sample, and how far beyond zero its minimum has to reach
    dips = {int(i): 0.0 for i in inner[::-1] + 1}
    # no sample follows the last one, so that the minimum may lie before it, or be that sample
    if size.size > 1 and sides[-2] * sides[-1] > 0.0 and size[-1] < min(size[-2], 0.1 * size.max()):
        dips = {size.size - 1: ROUNDING * float(size.max())} | dips
    # from the last to the first, so that an insertion moves no index that is still to come
    for i, depth in dips.items():
        side, low, high = sides[i], x[i - 1], x[min(i + 1, size.size - 1)]
        dip = minimize_scalar(
            lambda at, side=side: side * function(at),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-12 * (high - low)},
        )
        if dip.fun < -depth:
            place = np.searchsorted(x, dip.x)
            x, f = np.insert(x, place, dip.x), np.insert(f, place, side * dip.fun)
    return x, f
