"""Zeros, extrema and integrals of a function that is analytic in pieces.

A function is interpolated in Chebyshev points, halving the interval until the
coefficients have decayed. Its zeros are those of the interpolants, polished on
the function itself; its derivative and its integral are exact for the
interpolant. Nothing is asked of the function but values.

Source: L. N. Trefethen, Approximation Theory and Approximation Practice (2013),
chapters 3, 18 and 19.
"""

from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from escapement.errors import InvalidValue
from escapement.model import FloatArray

Function = Callable[[FloatArray], FloatArray]

_POINTS = 33
_NODES = chebyshev.chebpts1(_POINTS)
_TRANSFORM = 2.0 / _POINTS * chebyshev.chebvander(_NODES, _POINTS - 1).T
_TRANSFORM[0] /= 2.0
_ENDS = chebyshev.chebvander(np.array([-1.0, 1.0]), _POINTS - 1).T
_TAIL = 4  # coefficients that must have decayed
_DECAYED = 2e-15  # of the largest value: values carry a few rounding errors
_NOISE = 4.0 * np.finfo(float).eps  # what rounding an x does to a value, times slope and x
_CLOSE = 1e-9  # a stationary point this close to a piece's end, of its length, is the end
_DEEPEST = 24  # halvings around a kink: it is located to 6e-8 of the interval
_VANISHING = 1e-30  # a zero this close to a piece's end, of its length, is the end
_MOST = 10_000  # pieces at once: twice the kinks a function may have
_RIPPLE = 1e-6  # of the largest value: what is not resolved and less is rounding
_JUMP = 1e-9  # of the largest value: a series and its function differ by this, at a jump


class Piece(NamedTuple):
    """Chebyshev series over low <= x <= high, to rounding where `resolved`."""

    low: float
    high: float
    coefficients: FloatArray
    resolved: bool = True

    def derivative(self) -> "Piece":
        """Series of the derivative by x."""
        scale = 2.0 / (self.high - self.low)
        slopes = np.asarray(scale * chebyshev.chebder(self.coefficients), dtype=np.float64)
        return self._replace(coefficients=slopes)

    def integral(self) -> float:
        """Integral over the piece."""
        orders = np.arange(0, self.coefficients.size, 2)
        half = 0.5 * (self.high - self.low)
        return float(half * (self.coefficients[::2] * 2.0 / (1.0 - orders**2)).sum())

    def values(self, x: FloatArray) -> FloatArray:
        """The series at x."""
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low)
        return np.asarray(chebyshev.chebval((x - middle) / half, self.coefficients), dtype=float)

    def limits(self) -> tuple[float, float]:
        """The series at both ends, whatever the function has beyond them."""
        low, high = self.coefficients @ _ENDS[: self.coefficients.size]
        return float(low), float(high)

    def zeros(self) -> FloatArray:
        """Real zeros on the piece, its ends included, unpolished."""
        sizes = np.abs(self.coefficients)
        top = float(sizes.max())
        if sizes[0] > 1.001 * sizes[1:].sum() or top == 0.0:
            return np.empty(0)
        kept = int(np.flatnonzero(sizes > 1e-16 * top)[-1]) + 1
        roots = chebyshev.chebroots(self.coefficients[:kept])
        # a double zero may come out as a complex pair this close to the axis
        near = (np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) < 1.0 + 1e-6)
        real = np.asarray(roots[near].real, dtype=np.float64)
        half = 0.5 * (self.high - self.low)
        places: FloatArray = 0.5 * (self.low + self.high) + half * real
        return np.clip(places, self.low, self.high)


def interpolate(function: Function, points: Iterable[float]) -> list[Piece]:
    """Series of a function, piece by piece.

    Parameters
    ----------
    function : callable
        Array of x to array of values of the same shape.
    points : iterable of float
        Ascending; between neighbours the function is analytic. A kink elsewhere
        costs pieces and is located to 6e-8 of its interval.

    Returns
    -------
    list of Piece
        In ascending order.

    Raises
    ------
    InvalidValue
        When the function has too many kinks. Only a load can have them.
    """
    low, high = np.array([pair for pair in pairwise(points) if pair[1] > pair[0]]).T
    scale = 0.0
    pieces: list[Piece] = []
    for depth in range(_DEEPEST + 1):
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        x = np.column_stack([middle[:, None] + half[:, None] * _NODES, low, high])
        known = function(x.reshape(-1)).reshape(x.shape)
        values, ends = known[:, :_POINTS], known[:, _POINTS:]
        scale = max(scale, float(np.abs(values).max()))
        series = values @ _TRANSFORM.T
        steepest = np.abs(np.diff(values) / np.diff(_NODES)).max(axis=1) / half
        floor = np.maximum(_DECAYED * scale, _NOISE * steepest * np.maximum(abs(low), abs(high)))
        tails = np.abs(series[:, -_TAIL:]).max(axis=1)
        decayed = tails <= floor
        # no node sees a kink close to an end, but the value there does
        misses = np.abs(series @ _ENDS - ends).max(axis=1)
        rough = ~decayed | (misses > np.maximum(_JUMP * scale, 4.0 * floor))
        if 2 * rough.sum() > _MOST:
            # what ripples as rounding does is left at that
            rough = np.maximum(misses, tails) > _RIPPLE * scale
        if 2 * rough.sum() > _MOST:
            raise InvalidValue(
                f"load_torque must be smooth but for at most {_MOST // 2} kinks, got a rougher "
                "function; smooth it, or give fewer points"
            )
        last = depth == _DEEPEST
        for k in np.flatnonzero(last | ~rough):
            pieces.append(Piece(float(low[k]), float(high[k]), series[k], bool(decayed[k])))
        if last or not rough.any():
            break
        low, middle, high = low[rough], middle[rough], high[rough]
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    return sorted(pieces, key=lambda piece: piece.low)


def zeros(function: Function, points: Iterable[float]) -> FloatArray:
    """Where a function is zero or jumps over it, ascending; touching zeros included.

    Parameters as for `interpolate`.
    """
    found = [np.empty(0)]
    pieces = interpolate(function, points)
    for piece, following in pairwise(pieces):
        if piece.limits()[1] * following.limits()[0] < 0.0:
            found.append(np.array([following.low]))
    for piece in pieces:
        roots = piece.zeros()
        if roots.size:
            found.append(_polish(function, piece, roots))
    return np.unique(np.concatenate(found))


def extremes(function: Function, pieces: list[Piece]) -> tuple[float, float, float, float]:
    """Greatest and least value of a function, each with the first place that has it.

    At a jump the limits from both sides count.

    Returns
    -------
    greatest, place, least, place : float
    """
    places = np.array([end for piece in pieces for end in (piece.low, piece.high)])
    limits = np.array([limit for piece in pieces for limit in piece.limits()])
    values = function(places)
    # a jump's other side is not among the values
    jump = np.repeat([piece.resolved for piece in pieces], 2)
    jump &= np.abs(limits - values) > _JUMP * np.abs(values).max()
    # between its ends a piece stays within its coefficients' sum
    span = np.array([np.abs(piece.coefficients[1:]).sum() for piece in pieces])
    about = np.array([piece.coefficients[0] for piece in pieces])
    worth = (about + span >= values.max()) | (about - span <= values.min())
    stationary = (_stationary(pieces[k]) for k in np.flatnonzero(worth))
    inside = np.concatenate([np.empty(0), *stationary])
    values = np.concatenate([values, limits[jump], function(inside)])
    places = np.concatenate([places, places[jump], inside])
    order = np.argsort(places, kind="stable")
    places, values = places[order], values[order]
    equal = 4.0 * np.finfo(float).eps * np.abs(values).max()
    top = int(np.flatnonzero(values >= values.max() - equal)[0])
    bottom = int(np.flatnonzero(values <= values.min() + equal)[0])
    return float(values[top]), float(places[top]), float(values[bottom]), float(places[bottom])


def _stationary(piece: Piece) -> FloatArray:
    """Where a piece's slope is zero, its ends left out."""
    margin = _CLOSE * (piece.high - piece.low)
    found = piece.derivative().zeros()
    return found[(found > piece.low + margin) & (found < piece.high - margin)]


def _polish(function: Function, piece: Piece, roots: FloatArray) -> FloatArray:
    """Newton's steps with the series' slope, as long as they lessen the value."""
    slope = piece.derivative()
    values = function(roots)
    for _ in range(4):
        with np.errstate(divide="ignore", invalid="ignore"):
            steps = values / slope.values(roots)
        trial = np.clip(np.where(np.isfinite(steps), roots - steps, roots), piece.low, piece.high)
        tried = function(trial)
        better = np.abs(tried) < np.abs(values)
        roots, values = np.where(better, trial, roots), np.where(better, tried, values)
    for end in (piece.low, piece.high):
        roots = np.where(np.abs(roots - end) < _VANISHING * (piece.high - piece.low), end, roots)
    return roots
