"""Functions that are analytic in pieces, as Chebyshev series: fit, slopes and zeros.

A function is interpolated in Chebyshev points, halving the interval until the
coefficients have decayed. Its zeros are those of the series, polished on the
function itself; its derivative is exact for the series.
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

_MOST_PIECES = 5000
_DEEPEST = 24  # halvings, after which what is rough is a kink
_NOISE = 4.0 * np.finfo(float).eps  # times slope and x, the error of a value due to rounding of x
_RIPPLE = 1e-6  # tails below this share of the largest value are rounding errors
_JUMP = 1e-9  # share of the largest value by which series and function differ beside a kink
_VANISHING = 1e-30  # share of a piece's length; a zero closer to its end is the end


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
    noise: float = _NOISE,
) -> Series:
    """Series of a function to rounding.

    Parameters
    ----------
    function : callable
        Array of x to array of values of the same shape.
    points : iterable of float
        Between neighbours the function is analytic.
    order : int
        Coefficients of a series.
    decayed : float
        The last eighth of them must be this share of the largest value: values carry a few
        rounding errors.
    noise : float
        Error of a value over its slope times x; 0 if values are resolved only relative to the
        greatest, as those of a kernel's table.

    Raises
    ------
    InvalidValue
        When the function is not analytic between the points.
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
        floor = np.maximum(decayed * scale, noise * _steepness(values, low, high))
        # no point detects a kink close to an end, but the value at the end does
        misses = np.abs(Series(edges, rows).limits() - ends).max(axis=1)
        rough = (tails > floor) | (misses > np.maximum(_JUMP * scale, 4.0 * floor))
        if rough.sum() > _MOST_PIECES:
            # ripples of the size of rounding are not resolved further
            rough = np.maximum(misses, tails) > _RIPPLE * scale
        if rough.sum() > (0 if depth == _DEEPEST else _MOST_PIECES):
            raise InvalidValue(
                "a transmission must be smooth between its corners, got a kink near "
                f"{low[rough][0]:.9g} rad; smooth it, or name the corners"
            )
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


def _steepness(values: Array, low: Array, high: Array) -> Array:
    """Greatest slope between the values of `interpolate`, times x."""
    steps = np.diff(_nodes_and_transform(values.shape[1])[0])
    steepest = np.abs(np.diff(values) / steps).max(axis=1) / (0.5 * (high - low))
    return np.asarray(steepest * np.maximum(np.abs(low), np.abs(high)))


def zeros(function: Function, points: Iterable[float]) -> Array:
    """Where a function is zero, ascending; touching zeros included.

    Parameters as for `fit`.
    """
    series = fit(function, points)
    return np.unique(_polish(function, series, *series.roots()))


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
