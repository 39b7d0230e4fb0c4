"""The least and greatest value of a figure when every number stays within its tolerance."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np

from escapement.mechanisms.protocol import FloatArray

Evaluate = Callable[[FloatArray], float]
"""A figure at values of the numbers; NaN where it has none."""
FEW = 6
"""Every vertex of a box of so many numbers is tried."""
NARROW, EACH = 1e-4, 30
"""A search ends within this share of each tolerance, or after so many cases for each number."""


class Worst(NamedTuple):
    """The ends of a figure.

    low, high : least and greatest value; NaN if the figure has none there.
    searched : whether they were searched for; otherwise derivatives of constant sign show that
        they lie at a vertex.
    """

    low: float
    high: float
    searched: bool


def worst_case(
    evaluate: Evaluate,
    slopes: Callable[[FloatArray], FloatArray],
    bounds: FloatArray,
    nominal: FloatArray,
    tried: FloatArray,
) -> Worst:
    """The ends of a figure over a box.

    If each derivative has the same sign at the nominal point and at the two vertices to which the
    signs point, the ends are at these vertices. Otherwise vertices are tried, all of them if the
    numbers are few, and the search starts from the best of them and from the extreme cases of a
    sample. The ends are the extremes of all that was evaluated within the box, the nominal point
    included. A vertex to which derivatives point, and where the figure has no value, is an end
    without a value: beyond some point the mechanism jams or stops.

    Parameters
    ----------
    evaluate, slopes : callable
        The figure, and its derivatives by each number; NaN where there are none.
    bounds : ndarray, shape (n, 2)
        Ends of the numbers.
    nominal : ndarray, shape (n,)
        The nominal point.
    tried : ndarray, shape (2, n)
        Cases of a sample with the least and greatest value.
    """
    known: dict[bytes, float] = {}

    def value(point: FloatArray) -> float:
        key = point.tobytes()
        if key not in known:
            known[key] = evaluate(point)
        return known[key]

    first = slopes(nominal)
    vertices = [np.where(sign * first > 0.0, bounds[:, 1], bounds[:, 0]) for sign in (-1.0, 1.0)]
    alike = bool(np.isfinite(first).all())
    for vertex in vertices:
        alike = alike and bool((np.sign(slopes(vertex)) * np.sign(first) >= 0.0).all())
    open_ends = [not np.isfinite(value(v)) and np.isfinite(first).all() for v in vertices]
    if (np.clip(nominal, *bounds.T) == nominal).all():
        value(nominal)
    if not alike:
        for sign, vertex, case in zip((-1.0, 1.0), vertices, tried, strict=True):
            inside = np.clip(case, bounds[:, 0], bounds[:, 1])
            starts = [_best_vertex(value, sign, bounds, start) for start in (vertex, inside)]
            for start in (max(starts, key=lambda point: _height(value, sign, point)), inside):
                if np.isfinite(value(start)):
                    _climb(value, sign, bounds, start)
    found = [x for x in known.values() if np.isfinite(x)] or [np.nan]
    low, high = (
        np.nan if is_open else end
        for is_open, end in zip(open_ends, (min(found), max(found)), strict=True)
    )
    return Worst(low, high, not alike)


def _height(value: Evaluate, sign: float, point: FloatArray) -> float:
    """A figure or its negative; infinitely low where it has no value."""
    height = sign * value(point)
    return height if np.isfinite(height) else -np.inf


def _best_vertex(value: Evaluate, sign: float, bounds: FloatArray, start: FloatArray) -> FloatArray:
    """The vertex where a figure or its negative is greatest.

    If the numbers are many, it is one that the change of no single number improves, reached from
    that next to a start.
    """
    if len(bounds) <= FEW:
        every = [np.array(point) for point in product(*bounds)]
        return max(every, key=lambda point: _height(value, sign, point))
    best = np.where(start > bounds.mean(axis=1), bounds[:, 1], bounds[:, 0])
    improved = True
    while improved:
        improved = False
        for i, ends in enumerate(bounds):
            other = best.copy()
            other[i] = ends.sum() - best[i]
            if _height(value, sign, other) > _height(value, sign, best):
                best, improved = other, True
    return best


def _climb(value: Evaluate, sign: float, bounds: FloatArray, start: FloatArray) -> None:
    """Evaluate a figure ever nearer to a point where it or its negative is greatest."""
    from scipy.optimize import minimize

    low, wide = bounds[:, 0], bounds[:, 1] - bounds[:, 0]
    worse = 1e3 * abs(value(start))

    def cost(shares: FloatArray) -> float:
        found = value(low + shares * wide)
        return -sign * found if np.isfinite(found) else worse

    # a figure may have kinks, so a method without derivatives is used; it may jump as well, and
    # then hundreds of further cases would find the jump more exactly, and no other end
    begin, limits = np.clip((start - low) / wide, 0.0, 1.0), [(0.0, 1.0)] * len(start)
    most = {"xtol": NARROW, "maxfev": EACH * len(start)}
    minimize(cost, begin, method="Powell", bounds=limits, options=most)
