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

from escapement.model import FloatArray

Function = Callable[[FloatArray], FloatArray]

_POINTS = 33
_NODES = chebyshev.chebpts1(_POINTS)
_TRANSFORM = 2.0 / _POINTS * chebyshev.chebvander(_NODES, _POINTS - 1).T
_TRANSFORM[0] /= 2.0
_TAIL = 4  # coefficients that must have decayed
_DECAYED = 2e-15  # of the largest value: values carry a few rounding errors
_NOISE = 4.0 * np.finfo(float).eps  # what rounding an x does to a value, times slope and x
_CLOSE = 1e-9  # a stationary point this close to a piece's end, of its length, is the end
_DEEPEST = 24  # halvings around a kink: it is located to 6e-8 of the interval
_VANISHING = 1e-30  # a zero this close to a piece's end, of its length, is the end
_MOST = 4000  # pieces; a function without any smoothness is left at that


class Piece(NamedTuple):
    """Chebyshev series over low <= x <= high."""

    low: float
    high: float
    coefficients: FloatArray

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
    """
    waiting = [(low, high, 0) for low, high in pairwise(points) if high > low]
    waiting.reverse()
    scale = 0.0
    pieces: list[Piece] = []
    while waiting:
        low, high, depth = waiting.pop()
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        values = function(middle + half * _NODES)
        scale = max(scale, float(np.abs(values).max()))
        coefficients = _TRANSFORM @ values
        steepest = float(np.abs(np.diff(values) / np.diff(_NODES)).max()) / half
        floor = max(_DECAYED * scale, _NOISE * steepest * max(abs(low), abs(high)))
        resolved = np.abs(coefficients[-_TAIL:]).max() <= floor
        if resolved or depth == _DEEPEST or len(pieces) + len(waiting) >= _MOST:
            pieces.append(Piece(low, high, coefficients))
        else:
            waiting += [(middle, high, depth + 1), (low, middle, depth + 1)]
    return pieces


def zeros(function: Function, points: Iterable[float]) -> FloatArray:
    """Where a function is zero, ascending; touching zeros included.

    Parameters as for `interpolate`.
    """
    found = [np.empty(0)]
    for piece in interpolate(function, points):
        roots = piece.zeros()
        if roots.size:
            found.append(_polish(function, piece, roots))
    return np.unique(np.concatenate(found))


def extremes(function: Function, pieces: list[Piece]) -> tuple[float, float, float, float]:
    """Greatest and least value of a function, each with the first place that has it.

    Returns
    -------
    greatest, place, least, place : float
    """
    places = np.array([piece.low for piece in pieces] + [pieces[-1].high])
    for piece in pieces:
        margin = _CLOSE * (piece.high - piece.low)
        inside = piece.derivative().zeros()
        inside = inside[(inside > piece.low + margin) & (inside < piece.high - margin)]
        places = np.concatenate([places, inside])
    places.sort()
    values = function(places)
    equal = 4.0 * np.finfo(float).eps * np.abs(values).max()
    top = int(np.flatnonzero(values >= values.max() - equal)[0])
    bottom = int(np.flatnonzero(values <= values.min() + equal)[0])
    return float(values[top]), float(places[top]), float(values[bottom]), float(places[bottom])


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
