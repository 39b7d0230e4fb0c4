"""Parts as solids of one thickness, for printing."""

from typing import Any

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.outlines.curves import Curve
from escapement.outlines.sheet import Sheet


def stl(sheet: Sheet, thickness: float) -> bytes:
    """The parts on a sheet of chords, extruded, as a binary STL file in the sheet's unit.

    Raises
    ------
    MissingPackage
        Where trimesh, shapely or mapbox-earcut is not installed.
    """
    what, extra = "an STL file", "print"
    trimesh, shapely, _ = (
        validate.package(name, what, extra) for name in ("trimesh", "shapely", "mapbox_earcut")
    )
    # the edge of a part comes before its holes
    parts = list[tuple[Any, list[Any]]]()
    for layer, curve in sheet.curves:
        if layer == "CUT_OUTER":
            parts.append((_points(curve), []))
        elif layer == "CUT_INNER" and parts:
            parts[-1][1].append(_points(curve))
    shapes = [shapely.Polygon(edge, holes) for edge, holes in parts]
    solids = [trimesh.creation.extrude_polygon(shape, thickness) for shape in shapes]
    return bytes(trimesh.util.concatenate(solids).export(file_type="stl"))


def check_solid(parts: Any) -> None:
    """Raise InvalidValue for a gear whose teeth are not drawn."""
    if bare := [part.name for part in parts if part.toothed]:
        raise InvalidValue(
            f"an STL file must have parts with all their edges, got {', '.join(bare)} without "
            "teeth; write a drawing, FILE.dxf"
        )


def _points(curve: Curve) -> Any:
    return np.column_stack([curve.corners.real, curve.corners.imag])
