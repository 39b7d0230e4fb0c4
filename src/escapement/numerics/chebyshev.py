"""Functions that are analytic in pieces, as Chebyshev series: fit, slopes, zeros and extremes.

A function is interpolated in Chebyshev points, halving the interval until the
coefficients have decayed. Its zeros are those of the series, polished on the
function itself; its derivative and its integral are exact for the series.
Only values of the function are needed.

Source: L. N. Trefethen, Approximation Theory and Approximation Practice (2013),
chapters 3, 18 and 19.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from escapement.base.errors import InvalidValue

Array = NDArray[np.float64]
Function = Callable[[Array], Array]

MOST_KINKS = 5000
_DEEPEST = 24  # halvings around a kink, which locate it to 6e-8 of the interval
_NOISE = 4.0 * np.finfo(float).eps  # times slope and x, the error of a value due to rounding of x
_RIPPLE = 1e-6  # tails below this share of the largest value are rounding errors
_JUMP = 1e-9  # share of the largest value by which series and function differ at a jump
_CLOSE = 1e-9  # share of a piece's length; a stationary point closer to its end is the end
_VANISHING = 1e-30  # share of a piece's length; a zero closer to its end is the end


class Extremum(NamedTuple):
    """A value and the angle that has it; of a transmission [-] and from dead centre [rad]."""

    value: float
    angle: float


class Series(NamedTuple):
    """A function as Chebyshev series, one from edge to edge.

    edges : ascending, shape (n + 1,).
    rows : coefficients, a row for each pair of neighbouring edges, shape (n, order).
    """

    edges: Array
    rows: Array

    def __call__(self, x: ArrayLike) -> Array:
        """Values at x; beyond the ends the outermost series go on."""
        points = np.asarray(x, dtype=float)
        piece = np.searchsorted(self.edges[1:-1], points, side="right")
        inside = 2.0 * (points - self.edges[piece]) / np.diff(self.edges)[piece] - 1.0
        columns = np.moveaxis(self.rows[piece], -1, 0)
        return np.asarray(chebyshev.chebval(inside, columns, tensor=False))

    def derivative(self) -> Series:
        """Series of the derivative by x."""
        slopes = self.rows @ _slope_matrix(self.rows.shape[1])
        return Series(self.edges, slopes * (2.0 / np.diff(self.edges))[:, None])

    def integrals(self) -> Array:
        """Integral from each edge to the next."""
        orders = np.arange(0, self.rows.shape[1], 2)  # the integral of odd polynomials is zero
        return np.asarray(np.diff(self.edges) * (self.rows[:, ::2] @ (1.0 / (1.0 - orders**2))))

    def limits(self) -> Array:
        """Values of each series at both of its ends, shape (n, 2)."""
        signs = (-1.0) ** np.arange(self.rows.shape[1])
        return np.array([self.rows @ signs, self.rows.sum(axis=1)]).T

    def roots(self) -> tuple[Array, NDArray[np.intp]]:
        """Real zeros, those at the ends of a piece included, and the piece that each is of."""
        sizes = np.abs(self.rows)
        # where the first coefficient outweighs the others there is no zero
        may = (sizes[:, 0] <= 1.001 * sizes[:, 1:].sum(axis=1)) & sizes.any(axis=1)
        found, pieces = [np.empty(0)], [np.empty(0, dtype=np.intp)]
        for k in np.flatnonzero(may):
            roots = chebyshev.chebroots(chebyshev.chebtrim(self.rows[k], 1e-16 * sizes[k].max()))
            # a double zero may come out as a complex pair this close to the axis
            near = (np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) < 1.0 + 1e-6)
            inside = np.clip(roots[near].real, -1.0, 1.0)
            half = 0.5 * (self.edges[k + 1] - self.edges[k])
            found.append(np.minimum(self.edges[k] + half * (1.0 + inside), self.edges[k + 1]))
            pieces.append(np.full(inside.size, k))
        return np.concatenate(found), np.concatenate(pieces)


@lru_cache
def _slope_matrix(order: int) -> Array:
    """Coefficients of the derivative of each Chebyshev polynomial, a row each."""
    return np.asarray(chebyshev.chebder(np.eye(order), axis=1))


@lru_cache
def _nodes_and_transform(order: int) -> tuple[Array, Array]:
    """Chebyshev points from 1 down to -1, and the matrix from values there to coefficients."""
    angles = np.pi * (np.arange(order) + 0.5) / order
    transform = np.cos(np.outer(np.arange(order), angles)) * (2.0 / order)
    transform[0] /= 2.0
    return np.cos(angles), transform


def nodes(low: Array, high: Array, order: int) -> Array:
    """Chebyshev points between each `low` and `high`, from `high` down, a row a pair."""
    return low[:, None] + 0.5 * (high - low)[:, None] * (1.0 + _nodes_and_transform(order)[0])


def interpolate(values: Array) -> Array:
    """Coefficients of the series that go through values at `nodes`, of the same shape."""
    transform = _nodes_and_transform(values.shape[1])[1]
    return np.asarray(np.matmul(transform, values[:, :, None])[:, :, 0])


def fit(
    function: Function,
    points: Iterable[float],
    order: int = 33,
    decayed: float = 4e-15,
    kinks: int = MOST_KINKS,
) -> Series:
    """Series of a function to rounding.

    Parameters
    ----------
    function : callable
        Array of x to array of values of the same shape.
    points : iterable of float
        Between neighbours the function is analytic. A kink elsewhere costs pieces and is
        located to 6e-8 of its interval, where the series is a straight line.
    order : int
        Coefficients of a series.
    decayed : float
        The last eighth of them must be this share of the largest value: values carry a few
        rounding errors.
    kinks : int
        How many the function may have.

    Raises
    ------
    InvalidValue
        When the function has more kinks.
    """
    edges, tail = np.unique(np.fromiter(points, dtype=float)), order // 8
    low, high, scale = edges[:-1], edges[1:], 0.0
    starts, done = [], []
    for depth in range(_DEEPEST + 1):
        x = np.column_stack([nodes(low, high, order), low, high])
        known = np.asarray(function(x.reshape(-1)), dtype=float).reshape(x.shape)
        values, ends = known[:, :order], known[:, order:]
        rows = interpolate(values)
        scale = max(scale, float(np.abs(values).max()))
        tails = np.abs(rows[:, -tail:]).max(axis=1)
        # a kernel's table, which has no kinks, is resolved only relative to the greatest value
        floor = np.maximum(decayed * scale, _rounding(values, low, high) if kinks else 0.0)
        # no point detects a kink close to an end, but the value at the end does
        misses = np.abs(Series(edges, rows).limits() - ends).max(axis=1)
        rough = (tails > floor) | (misses > np.maximum(_JUMP * scale, 4.0 * floor))
        if rough.sum() > MOST_KINKS:
            # ripples of the size of rounding are not resolved further
            rough = np.maximum(misses, tails) > _RIPPLE * scale
        if rough.sum() > (kinks if depth == _DEEPEST else MOST_KINKS):
            raise InvalidValue(
                f"a load torque or transmission must be smooth except for at most {kinks} kinks, "
                f"got more, one of them near {low[rough][0]:.9g} rad; smooth it, give fewer points "
                "of a load, or name the corners of a transmission"
            )
        if depth == _DEEPEST:
            rows[rough] = 0.0
            rows[rough, :2] = 0.5 * ends[rough] @ np.array([[1.0, -1.0], [1.0, 1.0]])
            rough[:] = False
        starts.append(low[~rough])
        done.append(rows[~rough])
        if not rough.any():
            break
        low, high = low[rough], high[rough]
        middle = low + 0.5 * (high - low)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    left = np.concatenate(starts)
    along = np.argsort(left)
    return Series(np.append(left[along], edges[-1]), np.concatenate(done)[along])


def _rounding(values: Array, low: Array, high: Array) -> Array:
    """Error of the values of `interpolate` due to the rounding of x."""
    steps = np.diff(_nodes_and_transform(values.shape[1])[0])
    steepest = np.abs(np.diff(values) / steps).max(axis=1) / (0.5 * (high - low))
    return np.asarray(_NOISE * steepest * np.maximum(np.abs(low), np.abs(high)))


def zeros(function: Function, points: Iterable[float]) -> Array:
    """Where a function is zero or jumps over it, ascending; touching zeros included.

    Parameters as for `fit`.
    """
    series = fit(function, points)
    limits = series.limits()
    jumps = series.edges[1:-1][limits[:-1, 1] * limits[1:, 0] < 0.0]
    return np.unique(np.concatenate([jumps, _polish(function, series, *series.roots())]))


def _polish(function: Function, series: Series, roots: Array, piece: NDArray[np.intp]) -> Array:
    """Newton's steps with the series' slope, as long as they lessen the value."""
    if roots.size == 0:
        return roots
    slope, low, high = series.derivative(), series.edges[piece], series.edges[piece + 1]
    values = function(roots)
    for _ in range(4):
        with np.errstate(divide="ignore", invalid="ignore"):
            steps = values / slope(roots)
        trial = np.clip(np.where(np.isfinite(steps), roots - steps, roots), low, high)
        tried = function(trial)
        better = np.abs(tried) < np.abs(values)
        if not better.any():
            break
        roots, values = np.where(better, trial, roots), np.where(better, tried, values)
    for end in (low, high):
        roots = np.where(np.abs(roots - end) < _VANISHING * (high - low), end, roots)
    return roots


def extremes(function: Function | Series, series: Series) -> tuple[Extremum, Extremum]:
    """Greatest and least value of a function, each with the first point that has it.

    At a jump the limits from both sides count.
    """
    edges, rows = series.edges, series.rows
    at_edges, limits = function(edges), series.limits()
    # the value on the other side of a jump is not among the values
    beside, both = (np.column_stack([x[:-1], x[1:]]) for x in (at_edges, edges))
    jump = np.abs(limits - beside) > _JUMP * np.abs(at_edges).max()
    # between its ends a series stays within its coefficients' sum
    span = np.abs(rows[:, 1:]).sum(axis=1)
    worth = (rows[:, 0] + span >= at_edges.max()) | (rows[:, 0] - span <= at_edges.min())
    slope = series.derivative()
    slope.rows[~worth] = 0.0
    inside, piece = slope.roots()
    margin = _CLOSE * np.diff(edges)[piece]
    inside = inside[(inside > edges[piece] + margin) & (inside < edges[piece + 1] - margin)]
    values = np.concatenate([at_edges, limits[jump], function(inside)])
    points = np.concatenate([edges, both[jump], inside])
    order = np.argsort(points, kind="stable")
    points, values = points[order], values[order]
    equal = _NOISE * np.abs(values).max()
    firsts = np.argmax([values >= values.max() - equal, values <= values.min() + equal], axis=1)
    top, bottom = (Extremum(float(values[k]), float(points[k])) for k in firsts)
    return top, bottom
