"""Chains of lines and arcs, and the features with which a body of such chains touches another."""

import cmath
import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from escapement.mechanisms.features import CONVEX, HOLLOW, LINE, Features

ComplexArray = NDArray[np.complex128]
FloatArray = NDArray[np.float64]

_TANGENT = 1e-7  # segments that meet at a smaller angle go on without a corner [rad]
_SAME = 1e-9  # points closer than this share of the chain's size are one


class Chain(NamedTuple):
    """Lines and arcs that follow each other, with the material on their left.

    points : shape (n,), complex x + iy.
    bulges : of the segment from each point to the next, as DXF has them: the tangent of a quarter
        of the angle by which it turns. A closed chain has n of them, an open one n - 1. An open
        chain of a body that repeats goes on where its next sector begins.
    """

    points: ComplexArray
    bulges: FloatArray

    @property
    def closed(self) -> bool:
        """Whether its last segment leads back to its first point."""
        return self.points.size == self.bulges.size

    @classmethod
    def of(cls, points: Sequence[complex], bulges: Sequence[float]) -> Self:
        """The chain of lists of its points and bulges."""
        return cls(np.array(points, dtype=complex), np.array(bulges, dtype=float))

    def reversed(self) -> "Chain":
        """A closed chain run through the other way, with the material still named on the left."""
        return Chain(self.points[::-1], -np.roll(self.bulges[::-1], -1))


class Segment(NamedTuple):
    """A line, or an arc about a centre; `turn` is the angle by which it turns to the left [rad]."""

    start: complex
    end: complex
    turn: float
    centre: complex = 0.0

    def direction(self, at_end: bool) -> float:
        """Direction in which it runs at one of its ends [rad]."""
        if self.turn == 0.0:
            return cmath.phase(self.end - self.start)
        radius = (self.end if at_end else self.start) - self.centre
        return cmath.phase(radius) + math.copysign(0.5 * math.pi, self.turn)

    def nearest(self, point: complex) -> complex:
        """The point of it that is nearest to another one."""
        if self.turn == 0.0:
            along = self.end - self.start
            share = ((point - self.start) * along.conjugate()).real / abs(along) ** 2
            return self.start + min(max(share, 0.0), 1.0) * along
        away, radius = point - self.centre, self.start - self.centre
        if away and cmath.phase(away / radius) * math.copysign(1.0, self.turn) % math.tau <= abs(
            self.turn
        ):
            return self.centre + abs(radius) * away / abs(away)
        return min(self.start, self.end, key=lambda one: abs(one - point))

    def at(self, shares: FloatArray) -> ComplexArray:
        """Points at shares of it."""
        if self.turn == 0.0:
            return np.asarray(self.start + shares * (self.end - self.start))
        turned = np.exp(1j * self.turn * shares)
        return np.asarray(self.centre + (self.start - self.centre) * turned)


def from_rows(rows: Sequence[Sequence[float]], unit: float) -> Chain:
    """The chain of rows x, y, bulge, in another unit; closed if it ends where it starts."""
    table = np.array(rows, dtype=float)
    points, bulges = (table[:, 0] + 1j * table[:, 1]) / unit, table[:, 2]
    if abs(points[-1] - points[0]) <= _SAME * max(np.ptp(points.real), np.ptp(points.imag)):
        return Chain(points[:-1], bulges[:-1])
    return Chain(points, bulges[:-1])


def polygon(points: Sequence[complex], radius: float = 0.0) -> Chain:
    """The closed chain through points, counterclockwise, its corners rounded with a radius."""
    corners = np.array(points, dtype=complex)
    if radius == 0.0:
        return Chain(corners, np.zeros(corners.size))
    before, after = (np.roll(corners, shift) - corners for shift in (1, -1))
    turn = np.angle(-after / before)
    cut = radius * np.tan(0.5 * turn)
    ends = [corners + cut * way / np.abs(way) for way in (before, after)]
    bulges = np.stack([np.tan(0.25 * turn), np.zeros(corners.size)], axis=1)
    return Chain(np.stack(ends, axis=1).ravel(), bulges.ravel())


def circle(centre: complex, radius: float) -> Chain:
    """A round body, counterclockwise."""
    return Chain(np.array([centre + radius, centre - radius]), np.ones(2))


def features_of(chains: Sequence[Chain], fold: int = 1) -> Features:
    """The lines, arcs and corners of a body, which stands for one sector of `fold` equal ones."""
    rows: list[tuple[float, ...]] = []
    for chain in chains:
        rows += _rows(chain, fold)
    columns = np.array(rows, dtype=float).reshape(-1, 6).T
    kind, x, y, direction, extent, radius = columns
    kinds = kind.astype(np.int64)
    return Features(kinds, x, y, direction=direction, extent=extent, radius=radius, fold=fold)


def nearest(segments: Sequence[Segment], point: complex) -> complex:
    """The point of a chain that is nearest to another one."""
    return min((one.nearest(point) for one in segments), key=lambda found: abs(found - point))


def sampled(segments: Sequence[Segment], count: int) -> ComplexArray:
    """Points along a chain, `count` of each segment, its start among them."""
    shares = np.arange(count) / count
    return np.concatenate([segment.at(shares) for segment in segments])


def segments_of(chain: Chain) -> list[Segment]:
    """The segments of a chain, without those that have no length."""
    starts = chain.points[: chain.bulges.size]
    along, turns = np.roll(chain.points, -1)[: starts.size] - starts, 4.0 * np.arctan(chain.bulges)
    with np.errstate(divide="ignore", invalid="ignore"):
        centres = starts + 0.5 * along * (1.0 + 1j / np.tan(0.5 * turns))
    lists = (values.tolist() for values in (starts, starts + along, turns, centres))
    near = _SAME * max(np.ptp(chain.points.real), np.ptp(chain.points.imag))
    return [
        Segment(*found)
        for found, size in zip(zip(*lists, strict=True), np.abs(along), strict=True)
        if size > near
    ]


def _rows(chain: Chain, fold: int) -> list[tuple[float, ...]]:
    """The features of one chain, each with the numbers of `Features`."""
    points, sector = chain.points, np.exp(2j * np.pi / fold)
    segments = _merged(segments_of(chain), chain.closed)
    # the joint after the last segment is that with the first, of the next sector in an open chain
    following = None
    if chain.closed:
        following = 1.0 + 0.0j
    elif fold > 1 and abs(points[-1] - points[0] * sector) <= _SAME * abs(points[0]):
        following = sector
    rows = [_row(segment) for segment in segments]
    pairs = [(one, two.direction(False)) for one, two in pairwise(segments)]
    if following is not None:
        pairs.append((segments[-1], segments[0].direction(False) + float(np.angle(following))))
    for segment, direction in pairs:
        turn = math.remainder(direction - segment.direction(True), 2.0 * math.pi)
        if turn > _TANGENT:
            middle = segment.direction(True) - 0.5 * math.pi + 0.5 * turn
            point = segment.end
            rows.append((CONVEX, point.real, point.imag, middle, 0.5 * turn, 0.0))
    return rows


def _row(segment: Segment) -> tuple[float, ...]:
    along, turn = segment.end - segment.start, segment.turn
    if turn == 0.0:
        start = segment.start
        return LINE, start.real, start.imag, segment.direction(False), abs(along), 0.0
    centre, kind = segment.centre, CONVEX if turn > 0.0 else HOLLOW
    radius = abs(segment.start - centre)
    if abs(turn) >= 2.0 * math.pi - _TANGENT:
        return kind, centre.real, centre.imag, 0.0, math.pi, radius
    middle = segment.direction(False) + 0.5 * turn - kind * 0.5 * math.pi
    return kind, centre.real, centre.imag, middle, 0.5 * abs(turn), radius


def _merged(segments: list[Segment], closed: bool) -> list[Segment]:
    """The segments, with neighbours that lie on one line or one circle made one."""
    found = segments[:1]
    for segment in segments[1:]:
        if (one := _joined(found[-1], segment)) is None:
            found.append(segment)
        else:
            found[-1] = one
    if closed and len(found) > 1 and (one := _joined(found[-1], found[0])) is not None:
        found = [one, *found[1:-1]]
    return found


def _joined(one: Segment, two: Segment) -> Segment | None:
    """Two segments as one, None where they do not lie on one line or circle."""
    turn = math.remainder(two.direction(False) - one.direction(True), 2.0 * math.pi)
    if abs(turn) > _TANGENT or (one.turn == 0.0) != (two.turn == 0.0) or one.turn * two.turn < 0.0:
        return None
    if one.turn != 0.0 and abs(one.centre - two.centre) > _SAME * abs(one.start - one.centre):
        return None
    return Segment(one.start, two.end, one.turn + two.turn, one.centre)
