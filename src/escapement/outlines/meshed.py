"""The toothed gears of the planetary drive."""

import math
from fractions import Fraction
from functools import lru_cache

from escapement.base import validate
from escapement.mechanisms import EllipticalPlanetary
from escapement.mechanisms.elliptical_teeth import (
    ADDENDUM,
    PRESSURE_ANGLE,
    PitchEllipse,
    fewest_teeth,
)
from escapement.outlines.curves import Curve
from escapement.outlines.teeth import rack_cut

MOST_TEETH = 500
"""Teeth up to which gears are drawn with them."""
_FEWEST = math.ceil(2.0 * ADDENDUM / math.sin(PRESSURE_ANGLE) ** 2)  # of a spur gear


def elliptical_teeth(mechanism: EllipticalPlanetary, teeth: int = 0) -> int | None:
    """Teeth of each elliptical gear; None where they would be too many to draw.

    Parameters
    ----------
    mechanism : EllipticalPlanetary
        The drive.
    teeth : int
        The wanted number; 0 for the fewest odd number that a rack does not undercut, with which
        both gears are equal.
    """
    least = fewest_teeth(mechanism)
    if teeth and teeth < least:
        rule = f"at least {least}, or 0 for the fewest odd number"
        raise validate.fail("teeth", rule, teeth, "with fewer a rack undercuts the flanks")
    count = teeth or least + 1 - least % 2
    return count if count <= MOST_TEETH else None


def spur_teeth(mechanism: EllipticalPlanetary) -> tuple[int, int] | None:
    """Fewest teeth of sun and planet that have exactly their ratio and no undercut.

    None where there are none, or too many to draw.
    """
    share = mechanism.planet_radius / mechanism.sun_radius
    whole = Fraction(share).limit_denominator(MOST_TEETH)
    if not whole or abs(share - whole) > 1e-12:
        return None
    times = math.ceil(_FEWEST / whole.numerator)
    sun = times * whole.denominator
    return (sun, times * whole.numerator) if sun <= MOST_TEETH else None


@lru_cache(maxsize=8)
def toothed_gears(
    mechanism: EllipticalPlanetary, teeth: int, backlash: float
) -> dict[str, Curve | None]:
    """Edges of the gears about their own axes [m], by name; None for gears without teeth.

    The vertices of both ellipses that touch at the driver angle 0 lie on the positive real axis.
    """
    driving, driven = mechanism.pitch_ellipses
    count, spurs = elliptical_teeth(mechanism, teeth), spur_teeth(mechanism)
    found: dict[str, Curve | None] = dict.fromkeys(("driven", "driving", "sun", "planet"))
    if count is not None:
        found["driven"] = rack_cut(driven, count, False, backlash)
        found["driving"] = rack_cut(driving, count, True, backlash)
    if spurs is not None:
        sun, planet = mechanism.sun_radius, mechanism.planet_radius
        found["sun"] = rack_cut(PitchEllipse(sun, 0.0), spurs[0], False, backlash)
        found["planet"] = rack_cut(PitchEllipse(planet, 0.0), spurs[1], True, backlash)
    return found
