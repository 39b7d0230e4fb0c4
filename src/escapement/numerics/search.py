"""Peaks and zeros of functions that are known at points, for many intervals at once.

`peaks` finds the greatest value along each row of points, `zeros` a zero between each pair of
points at which a function has different signs, and `roots` all zeros along a row of points, those
included that lie in pairs between two of them.

Source of `zeros`: T. R. Chandrupatla (1997), Advances in Engineering Software 28, 145-149.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from escapement.base.lazy import Lazy

optimize: Any = Lazy("scipy.optimize")
Array = np.ndarray[Any, Any]
Function = Callable[[Array], Array]

ROUNDS, SIZE = 3, 33
"""Number of times that a search for peaks narrows its points, and their number then: the points
are closer by a factor of 4096 in the end, and a parabola goes through the last three."""
CLEAR = 0.25
"""Share of its neighbours above which the estimate of a minimum is clear of zero."""
_FINEST = 1e-18
"""Error of a zero, over the distance of the points, in addition to rounding."""
_CLOSE = 1e-12
"""Error of a minimum, over the distance of its neighbours."""


def peaks(function: Function, points: Array, values: Array) -> tuple[Array, Array]:
    """Greatest value along each row of points, and where it is.

    Parameters
    ----------
    function : callable
        Array of points of shape (rows, k) to the values there; each row may have its own function.
    points, values : ndarray, shape (rows, n)
        Ascending points, so close that the peak lies between the neighbours of the greatest of
        the values there.

    Returns
    -------
    value, point : ndarray, shape (rows,)
    """
    for size in [SIZE] * ROUNDS + [0]:
        best = values.argmax(axis=-1)[:, None]
        before, behind = np.maximum(best - 1, 0), np.minimum(best + 1, points.shape[-1] - 1)
        if size:
            low, high = (np.take_along_axis(points, k, axis=-1)[:, 0] for k in (before, behind))
            points = np.linspace(low, high, size, axis=-1)
            values = function(points)
    low, top, high = (np.take_along_axis(values, k, axis=-1)[:, 0] for k in (before, best, behind))
    # the height of the parabola through three even samples, the middle one the greatest
    bend = 2.0 * top - low - high
    inside = (before != best) & (best != behind)
    with np.errstate(all="ignore"):
        # rise^2/(8 bend), but the square of a great force would overflow
        more = (high - low) * ((high - low) / (8.0 * bend))
    more = np.where(inside[:, 0] & (bend > 0.0), more, 0.0)
    return top + more, np.take_along_axis(points, best, axis=-1)[:, 0]


def zeros(function: Function, low: Array, high: Array) -> Array:
    """The first point behind a zero between each pair of points, to rounding.

    Where the values at both points have one sign, one of them is zero up to rounding, and the
    result is the point that is nearer to zero, the second one if both are alike.

    Parameters
    ----------
    function : callable
        Array of points of shape (n,) to the values there; each place may have its own function.
    low, high : ndarray, shape (n,)
    """
    a, b, at_a, at_b = high, low, function(high), function(low)
    changes, share, last = at_a * at_b < 0.0, np.full(a.shape, 0.5), at_a
    finest, best = _FINEST * np.abs(high - low), a
    for _ in range(200):
        nearer = np.abs(at_a) <= np.abs(at_b)
        best = np.where(nearer, a, b)
        with np.errstate(all="ignore"):
            least = (np.finfo(float).eps * np.abs(best) + finest) / np.abs(b - a)
        going = changes & (least < 0.5) & (np.where(nearer, at_a, at_b) != 0.0)
        if not going.any():
            break
        with np.errstate(all="ignore"):
            x = np.where(going, a + np.clip(share, least, 1.0 - least) * (b - a), best)
        value = function(x)
        kept = ~going | (value * at_a > 0.0)
        c, at_c = np.where(kept, a, b), np.where(kept, at_a, at_b)
        b, at_b = np.where(kept, b, a), np.where(kept, at_b, at_a)
        a, at_a = np.where(going, x, a), np.where(going, value, at_a)
        # inverse quadratic interpolation where the three values are fit for it, else the middle
        with np.errstate(all="ignore"):
            xi, phi = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b)
            fit = (phi**2 < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
            share = at_a / (at_b - at_a) * at_c / (at_b - at_c)
            share += (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
        share = np.where(fit, share, 0.5)
    return np.where(changes & (at_a * last < 0.0), b, np.where(changes, a, best))


def roots(
    between: Callable[[float, float], Callable[[float], float]], x: Array, f: Array, beyond: float
) -> list[float]:
    """All zeros of a function along ascending points, given its values there.

    Where |f| has a minimum between values of one sign, that minimum is computed, so that a pair of
    close zeros is found. At the points the sign of `f` is used, because the sign of the function
    there may be rounding.

    Parameters
    ----------
    between : callable
        The function, as it is between two points.
    x, f : ndarray, shape (n,)
        Points and values.
    beyond : float
        Share of the greatest value by which the function must go beyond zero next to the last
        point, where it may be rounding.
    """
    if x.size < 2:
        return []
    for i, depth in _dips(f, beyond).items():
        side, low, high = np.sign(f[i]), x[i - 1], x[min(i + 1, x.size - 1)]
        at = between(low, high)
        dip = optimize.minimize_scalar(
            lambda point, side=side, at=at: side * at(point),
            bounds=(low, high),
            method="bounded",
            options={"xatol": _CLOSE * (high - low)},
        )
        if dip.fun < -depth:
            index = np.searchsorted(x, dip.x)
            x, f = np.insert(x, index, dip.x), np.insert(f, index, side * dip.fun)
    changes = np.nonzero(np.sign(f[:-1]) * np.sign(f[1:]) < 0.0)[0]
    each = [between(x[i], x[i + 1]) for i in changes]

    def values(points: Array) -> Array:
        return np.array([at(point) for at, point in zip(each, points.tolist(), strict=True)])

    found: list[float] = zeros(values, x[changes], x[changes + 1]).tolist()
    return found


def _dips(f: Array, beyond: float) -> dict[int, float]:
    """Samples beside which |f| may reach zero twice, and how far beyond it; the last come first.

    They are the minima of |f| between samples of one sign, except for those of which a parabola
    through three samples stays clear of zero.
    """
    size, side = np.abs(f), np.sign(f)
    greatest = size.max(initial=0.0)
    before, here, behind = size[:-2], size[1:-1], size[2:]
    rise, tilt = before + behind - 2.0 * here, behind - before
    with np.errstate(all="ignore"):
        clear = here - tilt**2 / (8.0 * rise) > CLEAR * np.maximum(before, behind)
    one_sided = (side[:-2] * side[1:-1] > 0.0) & (side[1:-1] * side[2:] > 0.0)
    least = (here <= before) & (here <= behind) & (here < 0.1 * greatest)
    found = np.nonzero(least & one_sided & ~clear)[0] + 1
    dips = {int(i): 0.0 for i in found[::-1]}
    # No sample follows the last one, so that the minimum may lie before it, or be that sample.
    # There is none where the parabola still falls at the end.
    last = size[-3:]
    falls = last @ (-0.5, 2.0, -1.5) > CLEAR * (last[1] - last[2]) if f.size > 2 else False
    lower = size[-1] < min(size[-2:][0], 0.1 * greatest)
    if lower and side[-2] * side[-1] > 0.0 and not falls:
        dips = {f.size - 1: beyond * float(greatest)} | dips
    return dips
