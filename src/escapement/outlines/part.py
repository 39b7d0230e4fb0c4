"""A flat part: its edge, its holes, its mass and inertia."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.base.spoken import spoken_length
from escapement.outlines.bores import hole
from escapement.outlines.curves import ComplexArray, Curve, Moments, stadium
from escapement.outlines.fits import Fits
from escapement.outlines.gaps import outside, segments_of
from escapement.outlines.thin_walls import Wall, thinnest_wall


class Part(NamedTuple):
    """A flat part, relative to its own axis [m].

    Attributes
    ----------
    name : str
        Its name.
    edge : Curve
        Its edge; of a gear without teeth its pitch curve.
    holes : tuple of Curve
        What is cut out of it, clockwise.
    marks : tuple of Curve
        What is engraved: where the locking disc sits on the driver.
    axes : tuple of complex
        Centres of its holes and its axis of rotation.
    toothed : bool
        Whether it is a gear, whose teeth are not drawn but cut separately along its pitch curve.
    notes : tuple of tuple
        Points and lengths [m] that are engraved there as numbers.
    """

    name: str
    edge: Curve
    holes: tuple[Curve, ...] = ()
    marks: tuple[Curve, ...] = ()
    axes: tuple[complex, ...] = (0.0,)
    toothed: bool = False
    notes: tuple[tuple[complex, float], ...] = ()

    @property
    def moments(self) -> Moments:
        """Area [m^2] and its moments [m^3, m^4] about the part's axis, without the holes."""
        rows = [curve.moments for curve in (self.edge, *self.holes)]
        return Moments._make(sum(column) for column in zip(*rows, strict=True))

    @property
    def size(self) -> complex:
        """Its width and height [m]."""
        low, high = self.edge.box
        return high - low

    @property
    def wall(self) -> Wall:
        """Its thinnest wall [m], of a gear up to its pitch curve; see `thinnest_wall`.

        Where no two edges face each other, as in a disc without a hole, it is the least side.
        """
        found, size = thinnest_wall((self.edge, *self.holes)), self.size
        whole = Wall(min(size.real, size.imag), 0.5 * sum(self.edge.box))
        return found if found.width < whole.width else whole

    def mass(self, thickness: float, density: float) -> float:
        """Mass [kg] at a thickness [m] and a density [kg/m^3]."""
        return self.moments.area * thickness * density

    def inertia(self, thickness: float, density: float) -> float:
        """Moment of inertia about its axis [kg m^2]; arguments as in `mass`."""
        return self.moments.second * thickness * density

    def check(self) -> None:
        """Raise InvalidValue if a hole leaves no wall to the edge or to another hole."""
        for k, cut in enumerate(self.holes):
            rest = [self.edge, *self.holes[:k], *self.holes[k + 1 :]]
            others, round_one = segments_of(rest), len(cut.corners) == 2
            # of a round hole the centre tells enough
            points, radius = _points([cut]), 0.0
            if round_one:
                points = cut.corners.mean(keepdims=True)
                radius = abs(complex(cut.corners[0] - points[0]))
            deep, nearest = outside(others, points)
            if not round_one:
                within = _points(rest)
                deep = np.append(deep, outside(segments_of([cut]), within)[0])
                nearest = np.append(nearest, within)
            room, point = -float(deep.max()), complex(nearest[np.argmax(deep)])
            if not radius < room:
                x, y, most, got = (
                    spoken_length(size) for size in (point.real, point.imag, room, radius)
                )
                rule = f"have a radius of less than {most}, got {got}" if radius else "leave a wall"
                raise InvalidValue(
                    f"a hole of the {self.name} must {rule}: it reaches what is cut at "
                    f"({x}, {y}); choose a thinner shaft or pin, or a larger wheel"
                )


def _points(curves: Sequence[Curve]) -> ComplexArray:
    """Corners of curves, and the middles of their lines and arcs."""
    return np.concatenate([curve.at([0.0, 0.5]).ravel() for curve in curves])


def link(name: str, apart: float, first: float, second: float, fits: Fits) -> Part:
    """A plate that keeps two shafts at their distance."""
    ends = (first, 0.0), (second, apart)
    holes = tuple(hole(radius, centre, fits.shaft_fit, "shaft") for radius, centre in ends)
    wide = 2.0 * max(first, second) + max(0.5 * fits.shaft_fit, 0.0)
    return Part(name, stadium(wide, apart), holes, axes=(0.0, apart))
