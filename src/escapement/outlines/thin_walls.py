"""The thinnest wall of a part: the least distance of two edges that face each other across it.

Two lines or arcs face each other where both stand nearly upright on the straight line between
them, and this line lies within the part. The tip of a corner in which they meet is no wall, however
thin it is; away from the corner they count where this line is square to both.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from escapement.outlines.curves import ComplexArray, Curve, FloatArray
from escapement.outlines.gaps import (
    Segments,
    middle_of,
    nearest_on,
    outside,
    reach_of,
    segments_of,
    square_points,
)

_UPRIGHT = 0.5  # cosine of the greatest angle between the line across and an edge's normal
_NEAR = 1e-9  # share of a part's size below which two points are the same
_BLOCK = 32  # lines and arcs that are compared with all others at once
_TRIED = 64  # lines across that are tried at once


class Wall(NamedTuple):
    """A wall of a part.

    Attributes
    ----------
    width : float
        Its least width [L].
    point : complex
        The point in the middle where it is narrowest.
    """

    width: float
    point: complex


def thinnest_wall(edges: Sequence[Curve]) -> Wall:
    """The thinnest wall between the edges of a body, exact for lines and arcs.

    Parameters
    ----------
    edges : sequence of Curve
        All edges of the body, which is on their left.

    Returns
    -------
    Wall
        Infinitely wide if no two edges face each other.
    """
    segments, best = segments_of(edges), Wall(np.inf, 0.0)
    rounding = _NEAR * float(np.abs(segments.start - segments.start.mean()).max())
    middles, reaches = middle_of(segments), reach_of(segments)
    for k in range(0, segments.turn.size, _BLOCK):
        some = slice(k, k + _BLOCK)
        apart = np.abs(middles[some, None] - middles) - reaches[some, None] - reaches
        near = segments.only(np.any(apart < best.width, axis=0))
        some_segments = Segments._make(column[some] for column in segments)
        best = _thinner(segments, best, _across(some_segments, near, rounding), rounding)
    return best


def _thinner(segments: Segments, best: Wall, across: ComplexArray, rounding: float) -> Wall:
    """The shortest line across that lies within the part, or `best` if none is shorter."""
    starts, ends = across
    width = np.abs(ends - starts)
    order = np.argsort(width, kind="stable")
    order = order[width[order] < best.width]
    for some in np.split(order, range(_TRIED, order.size, _TRIED)):
        a, b = starts[some], ends[some]
        within = np.ones(some.size, dtype=bool)
        for share in (0.25, 0.5, 0.75):
            within &= outside(segments, a + share * (b - a))[0] < rounding
        for k in np.flatnonzero(within)[:1]:
            return Wall(float(abs(b[k] - a[k])), complex(0.5 * (a[k] + b[k])))
    return best


def _across(some_segments: Segments, segments: Segments, rounding: float) -> ComplexArray:
    """Both ends of the lines from some lines and arcs to others that face them, shape (2, n)."""
    # a distance is least at an end of a line or arc, or where an arc lies square to the other
    shape = 2, some_segments.turn.size, segments.turn.size
    fixed = np.broadcast_to(np.stack([some_segments.start, some_segments.end])[:, :, None], shape)
    square, on_arc = square_points(some_segments, segments)
    points = np.concatenate([fixed, np.moveaxis(square, 2, 0)])
    known = np.concatenate([np.ones(fixed.shape, dtype=bool), np.moveaxis(on_arc, 2, 0)])
    along = Segments._make(column[:, None] for column in some_segments).along(points)
    reached, other = nearest_on(segments, points)
    crossing = reached - points
    width = np.abs(crossing)
    known &= width > rounding
    unit = crossing / np.where(known, width, 1.0)
    facing = _cosine(1j * along, unit) > _UPRIGHT
    facing &= _cosine(1j * other, -unit) > _UPRIGHT
    facing &= _cosine(along, other) < -_UPRIGHT
    return np.stack([points[known & facing], reached[known & facing]])


def _cosine(one: ComplexArray, other: ComplexArray) -> FloatArray:
    """Cosine of the angle between two vectors."""
    size = np.abs(one) * np.abs(other)
    return np.asarray(np.real(one * other.conj()) / np.where(size == 0.0, 1.0, size))
