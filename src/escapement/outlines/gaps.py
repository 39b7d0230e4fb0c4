"""The gap between two bodies, exact for lines and arcs; negative where they overlap."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.outlines.curves import ComplexArray, Curve, FloatArray

_STRAIGHT = 1e-9  # an arc that turns by less counts as a line [rad]
_TIE = 1e-9


class Segments(NamedTuple):
    """Lines and arcs of the edges of a body, one after the other; arrays of shape (n,)."""

    start: ComplexArray
    end: ComplexArray
    turn: FloatArray
    centre: ComplexArray
    radius: FloatArray

    def moved(self, turn: complex, by: complex) -> "Segments":
        """The same, turned by a unit vector about the origin, then shifted."""
        ends = self.start * turn + by, self.end * turn + by
        return Segments(*ends, self.turn, self.centre * turn + by, self.radius)

    def along(self, points: ComplexArray) -> ComplexArray:
        """Directions of lines and arcs at points of theirs."""
        sense = np.where(self.turn < 0.0, -1.0, 1.0)
        straight, bent = self.end - self.start, 1j * sense * (points - self.centre)
        return np.where(self.turn == 0.0, straight, bent)

    def only(self, chosen: NDArray[np.bool_]) -> "Segments":
        """Those that are chosen."""
        return Segments._make(column[chosen] for column in self)


def segments_of(edges: Sequence[Curve]) -> Segments:
    """The lines and arcs of some edges; a line has the radius 0, and its middle as centre."""
    start = np.concatenate([edge.corners for edge in edges])
    end = np.concatenate([edge.ends for edge in edges])
    turn = np.concatenate([edge.turns for edge in edges])
    arc = np.abs(turn) > _STRAIGHT
    half = np.where(arc, 0.5 * turn, 1.0)
    # the centre lies beside the middle of the chord, to the left of an arc to the left
    aside = 0.5j * (end - start) * np.cos(half) / np.sin(half)
    centre = 0.5 * (start + end) + np.where(arc, aside, 0.0)
    radius = np.where(arc, np.abs(end - start) / (2.0 * np.abs(np.sin(half))), 0.0)
    return Segments(start, end, np.where(arc, turn, 0.0), centre, radius)


def nearest_on(segments: Segments, points: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """The nearest point of each line or arc, and the direction in which it runs there.

    points : shape (..., n) or (..., 1), those that are compared with each of the n segments.
    """
    line, chord = segments.turn == 0.0, segments.end - segments.start
    share = np.real((points - segments.start) * chord.conj()) / np.abs(chord) ** 2
    # ends are exact, so that lines that meet there are equally far
    on_line = np.where(share < 1.0, segments.start + np.maximum(share, 0.0) * chord, segments.end)
    away = points - segments.centre
    off = np.abs(away)
    # an arc's point in this direction, or else the nearer one of its ends
    sense = np.where(segments.turn < 0.0, -1.0, 1.0)
    passed = np.angle(away * (segments.start - segments.centre).conj()) * sense % (2.0 * np.pi)
    first = np.abs(points - segments.start) <= np.abs(points - segments.end)
    nearer = np.where(first, segments.start, segments.end)
    on_arc = segments.centre + segments.radius * away / np.where(off == 0.0, 1.0, off)
    # at the centre of an arc, every point of the arc is as near as its ends
    on_arc = np.where((passed <= np.abs(segments.turn)) & (off > 0.0), on_arc, nearer)
    nearest = np.where(line, on_line, on_arc)
    return nearest, segments.along(nearest)


def outside(segments: Segments, points: ComplexArray) -> tuple[FloatArray, ComplexArray]:
    """How far points lie outside a body, and the nearest point of its edges; both of one shape.

    The distance is negative inside. The nearest line or arc tells the side; at a corner it is
    that of the two segments from which the point is further to the side.
    """
    p = points[:, None]
    nearest, along = nearest_on(segments, p)
    distance = np.abs(p - nearest)
    aside = -np.imag(along.conj() * (p - nearest)) / np.abs(along)
    least = distance.min(axis=1)
    tied = distance <= least[:, None] * (1.0 + _TIE)
    chosen = np.argmax(np.where(tied, np.abs(aside), -1.0), axis=1)
    rows = np.arange(points.size)
    return np.copysign(least, aside[rows, chosen]), nearest[rows, chosen]


def gap(one: Segments, other: Segments) -> tuple[float, complex]:
    """Least distance of two bodies [L] and the point of one of them that has it.

    Two lines or arcs are nearest at an end of one, or where the line through an arc's centre
    stands upright on the other one. Where bodies overlap it is by how much, negative: the
    greatest depth of these points. Bodies that lie right across each other, like the bars of a
    cross, may have none of these points inside: follow a motion from where they are apart.
    """
    found = []
    one, other = _closest(one, other)
    for body, segments in ((other, one), (one, other)):
        points = np.concatenate([segments.start, _facing(segments, body)])
        distance, _ = outside(body, points)
        k = int(np.argmin(distance))
        found.append((float(distance[k]), complex(points[k])))
    return min(found, key=lambda pair: pair[0])


def _closest(one: Segments, other: Segments) -> tuple[Segments, Segments]:
    """Those lines and arcs of two bodies that may be the nearest to each other."""
    apart = np.abs(middle_of(one)[:, None] - middle_of(other))
    sizes = reach_of(one)[:, None] + reach_of(other)
    kept = apart - sizes <= np.min(apart + sizes)
    return one.only(np.any(kept, axis=1)), other.only(np.any(kept, axis=0))


def middle_of(segments: Segments) -> ComplexArray:
    return 0.5 * (segments.start + segments.end)


def reach_of(segments: Segments) -> FloatArray:
    """No point of a line or arc is further from the middle of its chord."""
    chord = np.abs(segments.end - segments.start)
    return np.where(np.abs(segments.turn) > np.pi, 2.0 * segments.radius, 0.5 * chord)


def square_points(one: Segments, other: Segments) -> tuple[ComplexArray, NDArray[np.bool_]]:
    """Points of the circles of arcs that lie square to other lines and arcs, two for each pair.

    Both results have the shape (segments of one, of the other, 2). The second tells which points
    exist and lie on their arc.
    """
    to_centre = other.centre - one.centre[:, None]
    across = np.broadcast_to(1j * (other.end - other.start), to_centre.shape)
    square = np.where(other.turn == 0.0, across, to_centre)
    size = np.abs(square)
    unit = square / np.where(size == 0.0, 1.0, size)
    points = one.centre[:, None, None] + one.radius[:, None, None] * np.stack([unit, -unit], 2)
    start, turn = (one.start - one.centre)[:, None, None], one.turn[:, None, None]
    passed = np.angle((points - one.centre[:, None, None]) / start) * np.sign(turn) % (2.0 * np.pi)
    return points, (passed <= np.abs(turn)) & (turn != 0.0) & (size > 0.0)[:, :, None]


def _facing(one: Segments, other: Segments) -> ComplexArray:
    """Points of arcs of one body that lie square to lines and arcs of the other."""
    points, on_arc = square_points(one.only(one.turn != 0.0), other)
    return points[on_arc]
