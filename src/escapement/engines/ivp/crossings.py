"""Roots of a function of the state along the dense output of a solver, in the order of time.

solve_ivp compares the signs of an event function at the ends of a step, so that it misses two
roots inside one step. With a load an engagement may have two pin reversals, at any distance from
each other.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from escapement.mechanisms.protocol import FloatArray

_FINEST = 1e-18
"""Absolute error of a root, for a piece whose time is of order one."""
ROUNDING = 1e-9
"""A value at the end of a piece below this share of the greatest value may be rounding."""
_CLEAR = 0.25
"""Share of its neighbours above which the estimate of a minimum is clear of zero."""

RealFunction = Callable[[float], float]
Observable = Callable[[FloatArray], float]
"""A function of the state."""


def find_roots(function: Observable, dense: Any, x: FloatArray, f: FloatArray) -> list[float]:
    """All roots of a `function` of the state, ascending, given its values `f` at times `x`.

    Where |f| has a minimum between values of one sign, that minimum is computed, so that
    a pair of close roots is found. At the ends the sign of `f` is used, because the sign of the
    function there may be rounding.
    """
    for i, depth in _dips(f).items():
        side, low, high = np.sign(f[i]), x[i - 1], x[min(i + 1, x.size - 1)]
        at = _between(function, dense, low, high)
        dip = minimize_scalar(
            lambda time, side=side, at=at: side * at(time),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-12 * (high - low)},
        )
        if dip.fun < -depth:
            index = np.searchsorted(x, dip.x)
            x, f = np.insert(x, index, dip.x), np.insert(f, index, side * dip.fun)
    sides = np.sign(f)
    changes = np.nonzero(sides[:-1] * sides[1:] < 0.0)[0]
    return [_root_between(function, dense, float(x[i]), float(x[i + 1])) for i in changes]


def _between(function: Observable, dense: Any, low: float, high: float) -> RealFunction:
    """A function of the state as one of the time between two times of the same step."""
    inside = dense.ts[1:-1].searchsorted(0.5 * (low + high))
    step = dense.interpolants[inside]
    # around the end of a step the dense output chooses between two
    inner = dense.ts[inside] <= low and high <= dense.ts[inside + 1]
    return lambda time: function(step(time) if inner else dense(time))


def _root_between(function: Observable, dense: Any, low: float, high: float) -> float:
    at = _between(function, dense, low, high)
    try:
        return float(brentq(at, low, high, xtol=_FINEST, rtol=1e-15, maxiter=500))
    except ValueError:
        # one end is a root up to rounding, which hides the change of sign
        return low if abs(at(low)) < abs(at(high)) else high


def _dips(f: FloatArray) -> dict[int, float]:
    """Samples beside which |f| may reach zero twice, and how far beyond it; the last come first.

    They are the minima of |f| between samples of one sign, except for those of which a parabola
    through three samples stays clear of zero.
    """
    size, side = np.abs(f), np.sign(f)
    greatest = size.max(initial=0.0)
    before, here, behind = size[:-2], size[1:-1], size[2:]
    rise, tilt = before + behind - 2.0 * here, behind - before
    with np.errstate(all="ignore"):
        clear = here - tilt**2 / (8.0 * rise) > _CLEAR * np.maximum(before, behind)
    one_sided = (side[:-2] * side[1:-1] > 0.0) & (side[1:-1] * side[2:] > 0.0)
    least = (here <= before) & (here <= behind) & (here < 0.1 * greatest)
    found = np.nonzero(least & one_sided & ~clear)[0] + 1
    dips = {int(i): 0.0 for i in found[::-1]}
    # No sample follows the last one, so that the minimum may lie before it, or be that sample.
    # There is none where the parabola still falls at the end.
    last = size[-3:]
    falls = last @ (-0.5, 2.0, -1.5) > _CLEAR * (last[1] - last[2]) if f.size > 2 else False
    lower = size[-1] < min(size[-2:][0], 0.1 * greatest)
    if lower and side[-2] * side[-1] > 0.0 and not falls:
        dips = {f.size - 1: ROUNDING * float(greatest)} | dips
    return dips
