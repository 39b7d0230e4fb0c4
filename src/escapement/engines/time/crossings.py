"""Every zero of a smooth function given a look at it now and then."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from escapement.model import FloatArray

_PER_STEP = 8  # looks per solver step
_FINEST = 1e-18  # of a piece that takes a time of order one
NOTHING = 1e-9  # of the greatest value: so much at an end is rounding

Function = Callable[[float], float]


def refine(times: FloatArray) -> FloatArray:
    """Solver steps with evenly spaced looks inside each."""
    inner = np.arange(_PER_STEP) / _PER_STEP
    looks = times[:-1, None] + np.diff(times)[:, None] * inner
    return np.append(looks.reshape(-1), times[-1])


def crossings(function: Function, x: FloatArray, f: FloatArray) -> list[float]:
    """All roots of `function`, ascending, given what it is at x.

    Where |f| has a local minimum without a change of sign the minimum itself is
    looked up, so that a pair of close roots is not lost. The sign in `f` counts
    at the ends, where rounding may say otherwise.
    """
    x, f = _with_dips(function, x, f)
    sides = np.sign(f)
    changes = np.nonzero(sides[:-1] * sides[1:] < 0.0)[0]
    return [_root(function, float(x[i]), float(x[i + 1])) for i in changes]


def _root(function: Function, low: float, high: float) -> float:
    at_low, at_high = function(low), function(high)
    if np.sign(at_low) * np.sign(at_high) < 0.0:
        return float(brentq(function, low, high, xtol=_FINEST, rtol=1e-15, maxiter=500))
    return low if abs(at_low) < abs(at_high) else high


def _with_dips(function: Function, x: FloatArray, f: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Samples, with the minimum of |f| added wherever f nearly turns back at zero."""
    size, sides = np.abs(f), np.sign(f)
    inner = np.nonzero(
        (size[1:-1] <= size[:-2])
        & (size[1:-1] <= size[2:])
        & (sides[:-2] * sides[1:-1] > 0.0)
        & (sides[1:-1] * sides[2:] > 0.0)
        & (size[1:-1] < 0.1 * size.max(initial=0.0))
    )[0]
    # at an end that nothing follows the least may be before it, or the end itself
    least = {int(i): 0.0 for i in inner[::-1] + 1}
    if size.size > 1 and sides[-2] * sides[-1] > 0.0 and size[-1] < min(size[-2], 0.1 * size.max()):
        least = {size.size - 1: NOTHING * float(size.max())} | least
    for i, nothing in least.items():
        sense, low, high = sides[i], x[i - 1], x[min(i + 1, size.size - 1)]
        dip = minimize_scalar(
            lambda s, sense=sense: sense * function(s),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-12 * (high - low)},
        )
        if dip.fun < -nothing:
            at = np.searchsorted(x, dip.x)
            x, f = np.insert(x, at, dip.x), np.insert(f, at, sense * dip.fun)
    return x, f
