"""Closed curves of lines and circular arcs, of which bodies, drawings and cutter paths consist.

A curve is kept as DXF keeps one: its corners, and for the segment from each corner to the next its
bulge, the tangent of a quarter of the angle by which the segment turns: 0 for a line, positive for
an arc to the left, 1 for half a circle. Points are complex numbers x + iy. A curve runs so that the
body is on its left: counter-clockwise around it, clockwise around a hole.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from escapement.base.errors import InvalidValue

ComplexArray = NDArray[np.complex128]
FloatArray = NDArray[np.float64]

_STRAIGHT = 1e-12  # an arc that turns by less is a line except for rounding [rad]
_CORNER = 1e-7  # segments that meet at a smaller angle go on without a corner [rad]
_CHORD = math.radians(4.0)
# the integrands turn by four times an arc's angle at most, for which 24 points are exact
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_NODES_ON, _SHARES = 0.5 * (1.0 + _NODES), 0.5 * _WEIGHTS


class Moments(NamedTuple):
    """Area [L^2], its first moment [L^3], and its second one about the origin [L^4]."""

    area: float
    first: complex
    second: float


class Curve(NamedTuple):
    """A closed curve of lines and arcs.

    Attributes
    ----------
    corners : ndarray of complex, shape (n,)
        Points at which a line or arc ends and the next begins. The last leads back to the first.
    bulges : ndarray, shape (n,)
        Bulge of the line or arc from each corner to the next.
    """

    corners: ComplexArray
    bulges: FloatArray

    def __repr__(self) -> str:
        return f"Curve({self.corners.size} corners)"

    @classmethod
    def circle(cls, radius: float, centre: complex = 0.0) -> Self:
        """A whole circle, counter-clockwise: two halves."""
        return cls(np.array([centre + radius, centre - radius], dtype=complex), np.ones(2))

    @property
    def ends(self) -> ComplexArray:
        """The corner to which each segment leads."""
        return np.roll(self.corners, -1)

    @property
    def turns(self) -> FloatArray:
        """Angle by which each segment turns [rad]."""
        return 4.0 * np.arctan(self.bulges)

    def moved(self, turn: complex = 1.0, by: complex = 0.0) -> "Curve":
        """The curve turned and stretched by a complex factor about the origin, then shifted."""
        return Curve(self.corners * turn + by, self.bulges)

    def reversed(self) -> "Curve":
        """The same curve the other way round."""
        return Curve(self.corners[::-1], -np.roll(self.bulges[::-1], -1))

    def mirrored(self) -> "Curve":
        """The curve on the other side of the real axis, with the body still on its left."""
        return Curve(self.corners.conj(), -self.bulges).reversed()

    def at(self, shares: ArrayLike) -> ComplexArray:
        """Points at shares from 0 to 1 of every segment, or of each its own; shape (n, shares)."""
        share, turn = np.asarray(shares, dtype=float), self.turns[:, None]
        # a ratio of sines, which is the share itself for a line
        straight = np.abs(turn) < _STRAIGHT
        half = np.where(straight, 1.0, 0.5 * turn)
        ratio = np.exp(1j * half * (share - 1.0)) * np.sin(half * share) / np.sin(half)
        start = self.corners[:, None]
        return np.asarray(start + (self.ends[:, None] - start) * np.where(straight, share, ratio))

    def drawn(self, chord: ArrayLike = _CHORD) -> ComplexArray:
        """Points of a polygon that ends where it starts, its chords as long as `chord` [rad]."""
        counts = np.maximum(1, np.ceil(np.abs(self.turns) / np.asarray(chord) - 1e-9)).astype(int)
        found = []
        for count in np.unique(counts):
            rows = np.flatnonzero(counts == count)
            points = self.at(np.arange(count) / count)[rows]
            positions = rows[:, None] + np.arange(count) / count
            found.append((positions.ravel(), points.ravel()))
        order = np.argsort(np.concatenate([positions for positions, _ in found]))
        points = np.concatenate([points for _, points in found])[order]
        return np.append(points, points[0])

    @property
    def box(self) -> tuple[complex, complex]:
        """Corners of the box that holds it: lower left, upper right."""
        # a segment is extreme at its ends, or where it runs along an axis
        turn = np.where(np.abs(self.turns) < _STRAIGHT, 1.0, self.turns)[:, None]
        chord = np.angle(self.ends - self.corners)[:, None]
        shares = (0.5 * np.pi * np.arange(-6, 7) - chord) / turn + 0.5
        points = self.at(np.clip(shares, 0.0, 1.0))
        low = complex(points.real.min(), points.imag.min())
        return low, complex(points.real.max(), points.imag.max())

    def svg(self, digits: str) -> str:
        """The curve as a path of SVG, with numbers in a format such as ".9f"."""
        radii = 0.5 * np.abs(self.ends - self.corners) / np.sin(0.5 * np.abs(self.turns) + 1e-300)
        # readers widen a radius that is too small for half a circle, and so find its centre
        radii *= np.where(np.abs(self.turns) > 3.14, 1.0 - 1e-9, 1.0)
        words = [f"M {svg_point(complex(self.corners[0]), digits)}"]
        for end, turn, radius in zip(self.ends.tolist(), self.turns, radii, strict=True):
            flags = f"{int(abs(turn) > math.pi)} {int(turn > 0.0)}"
            arc = f"A {radius:{digits}} {radius:{digits}} 0 {flags}"
            words.append(f"{arc if abs(turn) > _STRAIGHT else 'L'} {svg_point(end, digits)}")
        return " ".join([*words, "Z"])

    @property
    def length(self) -> float:
        """Length of the curve."""
        half = 0.5 * self.turns
        chords = np.abs(self.ends - self.corners)
        return float(np.sum(chords / np.sinc(half / np.pi)))

    @property
    def moments(self) -> Moments:
        """Area and its moments, negative for a hole: Green's theorem, exact to rounding."""
        z = self.at(_NODES_ON)
        turn = self.turns[:, None]
        chord = (self.ends - self.corners)[:, None]
        # dz along the segment: the chord, turned, longer by the ratio of arc and chord
        step = chord * np.exp(1j * turn * (_NODES_ON - 0.5)) / np.sinc(0.5 * turn / np.pi)
        swept = np.imag(z.conj() * step) * _SHARES
        second = 0.25 * float(np.sum(np.abs(z) ** 2 * swept))
        return Moments(0.5 * float(np.sum(swept)), complex(np.sum(z * swept)) / 3.0, second)

    def grown(self, width: float) -> "Curve":
        """The curve beside this one, outside the body: the path of a cutter of twice that width.

        Around the corners of the body it runs in arcs, so that they stay sharp.

        Raises
        ------
        InvalidValue
            When an arc is too narrow for it, or a corner points into the body.
        """
        if width == 0.0:
            return self
        a, b, half = self.corners, self.ends, 0.5 * self.turns
        straight = (b - a) / np.abs(b - a)
        before, after = straight * np.exp(-1j * half), straight * np.exp(1j * half)
        # an arc to the left has its centre there and grows, one to the right shrinks
        radius = np.abs(b - a) / (2.0 * np.maximum(np.abs(np.sin(half)), _STRAIGHT))
        if np.any(radius + np.sign(half) * width <= 0.0):
            least = float(radius[half * width < 0.0].min())
            raise InvalidValue(
                f"a cutter that runs {abs(width):.6g} beside the line must fit into every arc, "
                f"got an arc of radius {least:.6g}; choose a narrower kerf"
            )
        corner = np.angle(np.roll(before, -1) / after)
        if np.any(corner * math.copysign(1.0, width) < -_CORNER):
            point = complex(b[np.argmin(corner * math.copysign(1.0, width))])
            raise InvalidValue(
                f"a cutter with a width must reach every corner, got one at {point:.6g} that "
                "points into the body; cut it with a kerf of 0"
            )
        corners, bulges = [], []
        for i in range(a.size):
            corners.append(a[i] - 1j * width * before[i])
            bulges.append(self.bulges[i])
            if abs(corner[i]) > _CORNER:
                corners.append(b[i] - 1j * width * after[i])
                bulges.append(math.tan(0.25 * corner[i]))
        return Curve(np.array(corners), np.array(bulges))


def svg_point(z: complex, digits: str) -> str:
    """A point in SVG's words."""
    return f"{z.real:{digits}} {z.imag:{digits}}"


def chain(corners: Iterable[complex], turns: Iterable[float]) -> Curve:
    """A curve from its corners and the angles by which the segments between them turn [rad]."""
    turning = np.fromiter(turns, float)
    return Curve(np.fromiter(corners, complex), np.tan(0.25 * turning))


def stadium(radius: float, length: float) -> Curve:
    """Outline of the points within a radius of the real axis from 0 to a length."""
    side = radius * 1j
    return chain([-side, length - side, length + side, side], [0.0, math.pi, 0.0, math.pi])


def biarcs(
    points: ComplexArray, tangents: ComplexArray, arriving: ComplexArray | None = None
) -> Curve:
    """A closed curve of two arcs from each point to the next.

    Parameters
    ----------
    points : ndarray of complex, shape (n,)
        Points of a closed curve, without the first at the end.
    tangents : ndarray of complex, shape (n,)
        Unit vectors along it there, of the segment that begins.
    arriving : ndarray of complex, shape (n,), optional
        Those of the segment that ends there, where the curve has corners. Default: it is smooth.

    The arcs meet in between with a tangent in common, at equal control lengths.
    """
    ends = tangents if arriving is None else arriving
    chord, next_ends = np.roll(points, -1) - points, np.roll(ends, -1)
    along = np.real(chord.conj() * (tangents + next_ends))
    apart = 1.0 - np.real(tangents.conj() * next_ends)
    # the positive root of 2 apart d^2 + 2 along d = |chord|^2, in a form without cancellation
    square = np.abs(chord) ** 2
    reach = square / (along + np.sqrt(along**2 + 2.0 * apart * square))
    middle = 0.5 * (points + np.roll(points, -1) + reach * (tangents - next_ends))
    first = 2.0 * np.angle((middle - points) / tangents)
    second = 2.0 * np.angle(next_ends / (np.roll(points, -1) - middle))
    return chain(
        np.column_stack([points, middle]).ravel(), np.column_stack([first, second]).ravel()
    )
