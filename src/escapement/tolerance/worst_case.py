"""The least and greatest value of a figure when every number stays within its tolerance."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from escapement.mechanism import FloatArray

Evaluate = Callable[[FloatArray], float]
"""A figure at values of the numbers; NaN where it has none."""


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
    signs point, the ends are at these vertices. Otherwise the search starts from these vertices
    and from the extreme cases of a sample. A vertex to which derivatives point, and where the
    figure has no value, is an end without a value: beyond some place the mechanism jams or stops.

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
    first = slopes(nominal)
    vertices = [np.where(sign * first > 0.0, bounds[:, 1], bounds[:, 0]) for sign in (-1.0, 1.0)]
    alike = bool(np.isfinite(first).all())
    for vertex in vertices:
        alike = alike and bool((np.sign(slopes(vertex)) * np.sign(first) >= 0.0).all())
    at_vertices = [evaluate(vertex) for vertex in vertices]
    if alike:
        return Worst(at_vertices[0], at_vertices[1], False)
    ends = []
    for sign, vertex, value, case in zip((-1.0, 1.0), vertices, at_vertices, tried, strict=True):
        starts = [vertex, case] if np.isfinite(value) else [case]
        open_end = np.isfinite(first).all() and not np.isfinite(value)
        climbed = (_climb(evaluate, sign, bounds, start) for start in starts)
        ends.append(np.nan if open_end else sign * max(climbed))
    return Worst(ends[0], ends[1], True)


def _climb(evaluate: Evaluate, sign: float, bounds: FloatArray, start: FloatArray) -> float:
    """The greatest value of a figure, or of its negative, near a start within bounds."""
    from scipy.optimize import minimize

    low, wide = bounds[:, 0], bounds[:, 1] - bounds[:, 0]

    begin = np.clip((start - low) / wide, 0.0, 1.0)
    worse = 1e3 * abs(evaluate(low + begin * wide))

    def cost(shares: FloatArray) -> float:
        value = evaluate(low + shares * wide)
        return -sign * value if np.isfinite(value) else worse

    # a figure may have kinks, so a method without derivatives is used
    found = minimize(
        cost, begin, method="Powell", bounds=[(0.0, 1.0)] * len(begin), options={"xtol": 1e-6}
    )
    return max(-float(found.fun), -cost(begin))
