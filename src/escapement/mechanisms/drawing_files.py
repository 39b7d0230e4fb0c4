"""Two outlines from a DXF file: layers DRIVER and FOLLOWER, and a point at each axis."""

from __future__ import annotations

import math
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from escapement.base import validate
from escapement.base.errors import InputFileError
from escapement.base.files import check_input
from escapement.mechanisms.chains import Chain, ComplexArray, sampled, segments_of

LAYERS = ("DRIVER", "FOLLOWER")
_UNITS = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 8: 25.4e-9, 9: 25.4e-6, 13: 1e-6}
"""Lengths of the units of a DXF file in m, by the code of $INSUNITS."""
_SAMPLES = 32  # points of each line and arc that tell which chain lies within another
_JOINED = 1e-6  # ends closer than this share of the body's size are one

Row = tuple[float, float, float]
Chains = tuple[tuple[Row, ...], ...]
_Segment = tuple[complex, complex, float]


class Drawing(NamedTuple):
    """Two outlines, as `Outlines` takes them.

    driver, follower : chains of rows x, y and bulge [m], each about its own axis; of a body with
        equal sectors one of them.
    centre_distance : distance of the axes [m].
    driver_fold, follower_fold : equal sectors of each.
    """

    driver: Chains
    follower: Chains
    centre_distance: float
    driver_fold: int
    follower_fold: int


def read_outlines(path: str | PathLike[str]) -> Drawing:
    """The outlines of two bodies from a DXF file.

    The layers DRIVER and FOLLOWER have closed chains of lines and arcs, circles and polylines
    among them, and one point each, which is the axis of the body. Bulges are taken over exactly.

    Parameters
    ----------
    path : path
        The file, in the unit that it names ($INSUNITS).

    Raises
    ------
    MissingInput, InputFileError
        When the file does not exist, or is not such a drawing; the message says what is wrong.
    MissingPackage
        Where ezdxf is not installed.
    """
    check_input(path, "drawing")
    ezdxf = validate.package("ezdxf", "a DXF file", "cad")
    try:
        document = ezdxf.readfile(path)
    except (OSError, ezdxf.DXFError, UnicodeError) as error:
        raise InputFileError(f"drawing {path} must be a DXF file, got: {error}") from None
    if (unit := _UNITS.get(document.units)) is None:
        raise InputFileError(
            f"drawing {path} must name its unit, mm, cm, m, inches or feet, got $INSUNITS = "
            f"{document.units}; set the drawing units and save it again"
        )
    bodies = [_body(document.modelspace(), layer, f"drawing {path}") for layer in LAYERS]
    (driver, driver_axis), (follower, follower_axis) = bodies
    apart = follower_axis - driver_axis
    if apart == 0.0:
        raise InputFileError(f"drawing {path} must have two axes, got both points at one place")
    turn = unit * abs(apart) / apart
    outlines = [
        [chain._replace(points=turn * (chain.points - axis)) for chain in chains]
        for chains, axis in ((driver, driver_axis), (follower, follower_axis))
    ]
    (one, fold), (other, follower_fold) = map(_sector, outlines)
    return Drawing(one, other, unit * abs(apart), fold, follower_fold)


def _body(space: Any, layer: str, where: str) -> tuple[list[Chain], complex]:
    """The closed chains of a layer, counterclockwise outside, and the axis of the body."""
    where = f"{where}, layer {layer}"
    loose, closed, axes = list[_Segment](), list[list[_Segment]](), list[complex]()
    for entity in space:
        if entity.dxf.layer.upper() != layer:
            continue
        kind = entity.dxftype()
        if entity.dxf.hasattr("extrusion") and entity.dxf.extrusion.z < 1.0 - 1e-9:
            raise InputFileError(f"{where} must lie in the xy plane, got a tilted {kind}")
        if kind == "POINT":
            axes.append(_point(entity.dxf.location))
        elif kind in _READERS:
            segments, whole = _READERS[kind](entity)
            (closed.append(segments) if whole else loose.extend(segments))
        else:
            raise InputFileError(
                f"{where} must have lines, arcs, circles, polylines and a point, got a {kind}; "
                "explode it, or move it to another layer"
            )
    if len(axes) != 1:
        raise InputFileError(f"{where} must have one point, the axis of the body, got {len(axes)}")
    closed += _joined(loose, where)
    if not closed:
        raise InputFileError(f"{where} must have a closed chain, got none; draw the body on it")
    chains = [Chain.of(*list(zip(*segments, strict=True))[::2]) for segments in closed]
    return _turned(chains), axes[0]


def _point(vector: Any) -> complex:
    return complex(vector.x, vector.y)


def _line(entity: Any) -> tuple[list[_Segment], bool]:
    ends = _point(entity.dxf.start), _point(entity.dxf.end)
    return [(*ends, 0.0)], False


def _arc(entity: Any) -> tuple[list[_Segment], bool]:
    centre, radius = _point(entity.dxf.center), entity.dxf.radius
    angles = entity.dxf.start_angle, entity.dxf.end_angle
    start, end = (centre + radius * np.exp(1j * math.radians(angle)) for angle in angles)
    turn = math.radians((angles[1] - angles[0]) % 360.0)
    return [(complex(start), complex(end), math.tan(0.25 * turn))], False


def _circle(entity: Any) -> tuple[list[_Segment], bool]:
    centre, radius = _point(entity.dxf.center), entity.dxf.radius
    return [(centre + r, centre - r, 1.0) for r in (radius, -radius)], True


def _polyline(entity: Any) -> tuple[list[_Segment], bool]:
    if entity.dxftype() == "LWPOLYLINE":
        rows, whole = entity.get_points("xyb"), bool(entity.closed)
    else:
        rows = [(v.dxf.location.x, v.dxf.location.y, v.dxf.bulge) for v in entity.vertices]
        whole = bool(entity.is_closed)
    points = [complex(x, y) for x, y, _ in rows]
    ends = [*points[1:], points[0]]
    segments = [(a, b, row[2]) for a, b, row in zip(points, ends, rows, strict=True) if a != b]
    if not whole and points[0] != points[-1]:
        segments = segments[:-1]
    return segments, whole or points[0] == points[-1]


_READERS = {
    "LINE": _line, "ARC": _arc, "CIRCLE": _circle, "LWPOLYLINE": _polyline, "POLYLINE": _polyline,
}  # fmt: skip


def _joined(loose: list[_Segment], where: str) -> list[list[_Segment]]:
    """Closed chains of segments in any order and direction."""
    if not loose:
        return []
    ends = np.array([segment[:2] for segment in loose])
    near = _JOINED * max(np.ptp(ends.real), np.ptp(ends.imag))
    found, left = [], set(range(len(loose)))
    while left:
        chain = [loose[left.pop()]]
        while abs(chain[-1][1] - chain[0][0]) > near or (len(chain) == 1 and chain[0][2] == 0.0):
            rows = np.array(sorted(left), dtype=int)
            away = np.abs(ends[rows] - chain[-1][1]) if rows.size else np.full((1, 2), np.inf)
            row, side = np.unravel_index(int(np.argmin(away)), away.shape)
            back = abs(chain[-1][1] - chain[0][0])
            if away[row, side] > near:
                point = chain[-1][1]
                gap = min(float(away[row, side]), back)
                raise InputFileError(
                    f"{where} must have closed chains, got an end at ({point.real:.6g}, "
                    f"{point.imag:.6g}), {gap:.3g} from the next; join the lines and arcs there"
                )
            left.remove(int(rows[row]))
            start, end, bulge = loose[int(rows[row])]
            chain.append((start, end, bulge) if side == 0 else (end, start, -bulge))
        found.append(chain)
    return found


def _turned(chains: list[Chain]) -> list[Chain]:
    """Closed chains with the material on their left; one within another is a hole."""
    loops, found = [sampled(segments_of(chain), _SAMPLES) for chain in chains], []
    for chain, loop in zip(chains, loops, strict=True):
        outside = (loop.conj() * np.roll(loop, -1)).imag.sum() > 0.0
        inside = sum(_within(loop[0], other) for other in loops if other is not loop)
        found.append(chain if outside == (inside % 2 == 0) else chain.reversed())
    return found


def _within(point: complex, loop: ComplexArray) -> bool:
    """Whether a point lies inside a loop of points, by how often the loop winds about it."""
    return bool(abs(np.angle((np.roll(loop, -1) - point) / (loop - point)).sum()) > math.pi)


def _sector(chains: list[Chain]) -> tuple[Chains, int]:
    """The rows of a body's chains, of one sector if it has equal ones, and how many it has."""
    if len(chains) == 1:
        points, bulges = chains[0]
        near = _JOINED * np.abs(points).max()
        for fold in range(points.size, 1, -1):
            step, rest = divmod(points.size, fold)
            if rest:
                continue
            ahead = np.roll(points, -step) - points * np.exp(2j * np.pi / fold)
            alike = np.abs(np.roll(bulges, -step) - bulges).max() <= _JOINED
            if np.abs(ahead).max() <= near and alike:
                rows = [*zip(points[:step], bulges[:step], strict=True)]
                end = points[0] * np.exp(2j * np.pi / fold)
                return (_rows([*rows, (end, 0.0)]),), fold
    return tuple(_rows([*zip(z, b, strict=True), (z[0], 0.0)]) for z, b in chains), 1


def _rows(pairs: list[tuple[Any, Any]]) -> tuple[Row, ...]:
    return tuple((float(z.real), float(z.imag), float(b)) for z, b in pairs)
