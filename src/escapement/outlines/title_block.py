"""The title block of a drawing: dimensions, allowances and the general tolerance."""

from collections.abc import Sequence
from typing import Any

from escapement.base.text import show, words
from escapement.mechanisms import Geneva
from escapement.model.inputs import inputs_of_mechanism, inputs_of_settings
from escapement.outlines.fits import Fits
from escapement.outlines.geneva import sizes
from escapement.outlines.interference import Nearest
from escapement.outlines.part import Part

_RADII = "crank_radius", "fixed_radius", "locking_radius", "closest_radius"
"""Of these a drawing gives the radius, of all others the diameter."""


def title_block(
    title: str,
    tolerance: float,
    mechanism: Any,
    fits: Fits,
    parts: Sequence[Part],
    gaps: Sequence[Nearest],
    unit: tuple[float, str],
) -> list[tuple[str, str]]:
    """Names and values of all dimensions, below the title.

    tolerance : general tolerance of dimensions [m], 0 to leave it open. unit : of the drawing [m],
    and its name.
    """
    size, name = unit
    rows = [*inputs_of_mechanism(mechanism)]
    if isinstance(mechanism, Geneva) and (crank := mechanism.crank_radius):
        width = 2.0 * mechanism.contact_radius * crank + mechanism.clearance
        derived = {"centre_distance": mechanism.centre_distance * crank, "slot_width": width}
        derived |= {name: crank * length for name, length in sizes(mechanism).items()}
        rows += [(name, length, "length") for name, length in derived.items()]
    rows += inputs_of_settings(fits, mechanism.meshed)
    # what the workshop chose stands in place of what suits the wheel
    told = {}
    for key, value, kind in (row for row in rows if row[1]):
        round_one = key.endswith("_radius") and key not in _RADII
        label = words(key.replace("radius", "diameter") if round_one else key)
        length = kind == "length"
        told[label] = show(value * (1 + round_one) / size, 5) if length else show(value)
    told["thinnest wall"] = show(min(part.wall.width for part in parts) / size)
    told["least gap"] = show(gaps[0].gap / size)
    told |= {"general tolerance": f"±{show(tolerance / size)}"} if tolerance else {}
    return [(" ".join(title.split()), ""), *told.items(), ("scale", "1:1"), ("unit", name)]
