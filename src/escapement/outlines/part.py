"""A flat part: its edge, its holes, its mass and inertia."""

from typing import NamedTuple

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.spoken import as_spoken
from escapement.outlines.curves import Curve, Moments, stadium
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
    """

    name: str
    edge: Curve
    holes: tuple[Curve, ...] = ()
    marks: tuple[Curve, ...] = ()
    axes: tuple[complex, ...] = (0.0,)
    toothed: bool = False

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
        """Its thinnest wall [m], of a gear up to its pitch curve; see `thinnest_wall`."""
        return thinnest_wall((self.edge, *self.holes))

    def mass(self, thickness: float, density: float) -> float:
        """Mass [kg] at a thickness [m] and a density [kg/m^3]."""
        return self.moments.area * thickness * density

    def inertia(self, thickness: float, density: float) -> float:
        """Moment of inertia about its axis [kg m^2]; arguments as in `mass`."""
        return self.moments.second * thickness * density

    def check(self) -> None:
        """Raise InvalidValue if a hole leaves no wall to the edge or to another hole."""
        for k, hole in enumerate(self.holes):
            others = segments_of([self.edge, *self.holes[:k], *self.holes[k + 1 :]])
            centre = complex(hole.corners.mean())
            deep, point = outside(others, np.array([centre]))
            room, radius = -float(deep[0]), abs(complex(hole.corners[0]) - centre)
            if len(hole.corners) == 2 and not radius < room:
                x, y = (as_spoken(size, "length") for size in (point[0].real, point[0].imag))
                raise InvalidValue(
                    f"a hole of the {self.name} must have a radius of less than "
                    f"{as_spoken(room, 'length')}, got {as_spoken(radius, 'length')}: it "
                    "reaches what is cut "
                    f"at ({x}, {y}); choose a thinner shaft or pin, or a larger wheel"
                )


def hole(radius: float, at: complex, fit: float, what: str) -> Curve:
    """A hole for a pin or shaft of this radius, clockwise."""
    wide = radius + 0.5 * fit
    if not wide > 0.0:
        raise validate.fail(
            f"{what}_fit",
            f"greater than {as_spoken(-2.0 * radius, 'length')}",
            as_spoken(fit, "length"),
            "add to it",
        )
    return Curve.circle(wide, at).reversed()


def link(name: str, apart: float, first: float, second: float, fits: Fits) -> Part:
    """A plate that keeps two shafts at their distance."""
    ends = (first, 0.0), (second, apart)
    holes = tuple(hole(radius, centre, fits.shaft_fit, "shaft") for radius, centre in ends)
    wide = 2.0 * max(first, second) + max(0.5 * fits.shaft_fit, 0.0)
    return Part(name, stadium(wide, apart), holes, axes=(0.0, apart))
