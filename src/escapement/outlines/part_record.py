"""What is told of parts: their sizes, the gaps between them, their masses and inertias."""

import math
from typing import Any

from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.spoken import spoken_length
from escapement.mechanisms.geneva import Geneva
from escapement.outlines.fits import Fits
from escapement.outlines.geneva import sizes
from escapement.outlines.interference import Nearest
from escapement.outlines.part import Part
from escapement.outlines.parts import disc_inertia

RESULTS = dict.fromkeys(
    ("width", "height", "wall", "thinnest_wall", "least_gap", "gap", "x", "y"), Result("length")
) | {
    **dict.fromkeys(("driver_inertia", "follower_inertia"), Result("inertia")),
    "mass": Result("mass"),
}


def record_of(
    mechanism: Any,
    fits: Fits,
    parts: tuple[Part, ...],
    gaps: list[Nearest],
    discs: dict[str, float],
) -> Record:
    """The parts of a mechanism and the least gaps between them.

    discs : thickness [m] and density [kg/m^3], with which masses and inertias are told; or none.
    """
    thinnest = min(part.wall.width for part in parts)
    found: dict[str, Any] = {"kind": mechanism.kind, "thinnest_wall": thinnest}
    found["least_gap"] = gaps[0].gap
    if discs and isinstance(mechanism, Geneva):
        inertia = disc_inertia(mechanism, **discs, fits=fits)
        found |= {"driver_inertia": inertia.driver, "follower_inertia": inertia.follower}
    found["parts"] = [_part(part, discs) for part in parts]
    found["least_gaps"] = [_gap(pair) for pair in gaps]
    return Record(found, RESULTS)


def _part(part: Part, discs: dict[str, float]) -> dict[str, Any]:
    found = {
        "part": part.name, "width": part.size.real, "height": part.size.imag,
        "wall": part.wall.width, "holes": len(part.holes),
    }  # fmt: skip
    return found | ({"mass": part.mass(**discs)} if discs else {})


def _gap(pair: Nearest) -> dict[str, Any]:
    return {
        "bodies": " and ".join(pair.names), "gap": pair.gap, "angle_deg": math.degrees(pair.theta),
        "x": pair.point.real, "y": pair.point.imag,
    }  # fmt: skip


def record_of_sizes(wheel: Geneva, shaft: float | None) -> tuple[Record, str]:
    """Sizes of a Geneva wheel's follower, and what is wrong with its shaft.

    shaft : radius of the follower's shaft [m], None where it is not known.
    """
    found, unit = sizes(wheel), wheel.crank_radius
    if unit is None:
        return Record({f"{name}_over_crank_radius": size for name, size in found.items()}), ""
    lengths, warning = {name: unit * size for name, size in found.items()}, ""
    if shaft is not None:
        closest = lengths["closest_radius"]
        lengths["slot_to_shaft"] = closest - shaft
        if shaft >= closest:
            warning = (
                f"a slot reaches the shaft of radius {spoken_length(shaft)}: it ends "
                f"{spoken_length(closest)} from the axis; choose a thinner shaft or a larger "
                "wheel"
            )
    return Record(lengths, dict.fromkeys(lengths, Result("length"))), warning
