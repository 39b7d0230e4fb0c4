"""Holes: round ones for pins, and bores for shafts that turn with their part."""

import math
from collections.abc import Callable

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.spoken import spoken_length
from escapement.outlines.curves import Curve, chain
from escapement.outlines.fits import Fits


def hole(radius: float, at: complex, fit: float, what: str) -> Curve:
    """A hole for a pin or shaft of this radius, clockwise."""
    wide = radius + 0.5 * fit
    if not wide > 0.0:
        rule = f"greater than {spoken_length(-2.0 * radius)}"
        raise validate.fail(f"{what}_fit", rule, spoken_length(fit), "add to it")
    return Curve.circle(wide, at).reversed()


def bore(radius: float, fits: Fits) -> Curve:
    """The hole for a shaft that turns with its part, about the origin, clockwise.

    radius : of the shaft [m]; a square shaft has sides of twice that length.
    """
    round_one = hole(radius, 0.0, fits.shaft_fit, "shaft")
    return _CUT[fits.bore](round_one, radius, fits)


def _flat(round_one: Curve, radius: float, fits: Fits) -> Curve:
    """A D: a circle of which a flat is cut off."""
    depth = fits.bore_flat or radius / 3.0
    if not depth < radius:
        rule = f"less than {spoken_length(radius)}, the radius of a shaft"
        raise validate.fail("bore_flat", rule, spoken_length(depth), "choose less")
    wide = abs(complex(round_one.corners[0]))
    aside = math.acos((wide - depth) / wide)
    ends = wide * np.exp([1j * aside, -1j * aside])
    return _relieved(chain(ends, [2.0 * (math.pi - aside), 0.0]), fits.kerf).reversed()


def _square(round_one: Curve, _: float, fits: Fits) -> Curve:
    corners = abs(complex(round_one.corners[0])) * (1.0 + 1.0j) * 1j ** np.arange(4)
    return _relieved(chain(corners, np.zeros(4)), fits.kerf).reversed()


_CUT: dict[str, Callable[[Curve, float, Fits], Curve]] = {
    "round": lambda round_one, *_: round_one,
    "D": _flat,
    "square": _square,
}


def _relieved(curve: Curve, radius: float) -> Curve:
    """A bore with a recess of this radius about each corner, which a wide cutter cannot reach."""
    if radius == 0.0:
        return curve
    chord, half = np.abs(curve.ends - curve.corners), 0.5 * curve.turns
    if not 2.0 * radius < chord.min():
        raise InvalidValue(
            f"kerf must be less than half a side of the {'D' if half.any() else 'square'} bore, "
            f"{spoken_length(0.5 * chord.min())}, got {spoken_length(radius)}; choose "
            "a round bore or a thicker shaft"
        )
    # the share of a line or arc after which it leaves the recess at its start
    bent = np.where(half == 0.0, 1.0, half)
    on_arc = np.arcsin(radius * np.sin(bent) / chord) / bent
    share = np.where(half == 0.0, radius / chord, on_arc)
    begin, end = curve.at(np.column_stack([share, 1.0 - share])).T
    arrive = np.roll(end, 1)
    recess = np.angle((begin - curve.corners) / (arrive - curve.corners)) % (2.0 * np.pi)
    turns = np.column_stack([recess, curve.turns * (1.0 - 2.0 * share)])
    return chain(np.column_stack([arrive, begin]).ravel(), turns.ravel())
