"""Files of parts for cutting and printing: DXF, SVG and STL at 1:1, after a check of the motion."""

import math
from collections.abc import Callable, Sequence
from html import escape
from io import StringIO
from typing import Any

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.files import CUTS, AnyPath, file_format, write_file
from escapement.base.spoken import Spoken, on_drawing, spoken_length
from escapement.mechanisms.two_bodies import TwoBodies
from escapement.outlines.curves import Curve, svg_point
from escapement.outlines.fits import Fits
from escapement.outlines.interference import Nearest, least_gaps
from escapement.outlines.parts import outline_of, parts_of
from escapement.outlines.sheet import LAYERS, Sheet, lay_out
from escapement.outlines.solids import check_solid, stl
from escapement.outlines.title_block import title_block
from escapement.outlines.touching import bodies
from escapement.outlines.touching import least_gaps as touching_gaps

_ROUNDING = 1e-12  # gaps of so many units of the outline are 0 except for rounding
_TOUCH = 1e-6  # bodies that overlap by less count as touching [m]
_INCH, _MILLIMETRE = 0.0254, 1e-3


def motion_check(mechanism: Any, fits: Fits | None = None) -> list[Nearest]:
    """The least gap of each pair of bodies that move in one plane, over a turn of the driver.

    Parameters
    ----------
    mechanism : Mechanism
        As for `parts_of`.
    fits : Fits, optional
        As for `parts_of`.

    Returns
    -------
    list of Nearest
        Gaps and points in m, the smallest gap first. Negative gaps are overlaps. The parts have
        their nominal positions: the pin in the middle of its slot, the locked wheel in the middle
        of its clearance. Of two pallets it is the gap of each while the wheel pushes the other.
    """
    parts_of(mechanism, fits)  # this refuses a mechanism without parts
    touching = isinstance(mechanism, TwoBodies)
    pairs = (
        touching_gaps(mechanism) if touching else least_gaps(outline_of(mechanism, fits or Fits()))
    )
    # the outlines of elliptical gears are in mm
    unit = mechanism.crank_radius or 1e-3
    return [
        pair._replace(gap=unit * gap, point=unit * pair.point)
        for pair in pairs
        for gap in (pair.gap if abs(pair.gap) > _ROUNDING else 0.0,)
    ]


def export(
    mechanism: Any,
    path: AnyPath,
    fits: Fits | None = None,
    *,
    inches: bool = False,
    segments: bool = False,
    r12: bool = False,
    force: bool = False,
    sheet: Sequence[float] | None = None,
    crosses: bool = True,
    title: str = "",
    tolerance: float = 0.0,
    thickness: float | None = None,
) -> list[Nearest]:
    """Write the parts of a mechanism to a DXF, SVG or STL file at 1:1.

    Parameters
    ----------
    mechanism : Mechanism
        As for `parts_of`.
    path : path
        FILE.dxf, which needs the extra `cad`; FILE.svg; or FILE.stl, which needs the extra
        `print`, and has solids without engravings.
    fits : Fits, optional
        Allowances of holes, shafts, and the kerf.
    inches : bool
        Whether the file's unit is the inch. Default: the millimetre.
    segments : bool
        Whether arcs are replaced by chords at most 5 um from them, for machines that can only cut
        lines.
    r12 : bool
        Whether to write DXF release 12, which old programs read. It has no units.
    force : bool
        Whether an existing file may be replaced.
    sheet : sequence of float, optional
        Width and height of the material [m], on which the parts lie in rows.
    crosses : bool
        Whether axes and centres of holes have crosses.
    title : str
        Title of a block with all dimensions, in the layer TITLE beside the sheet.
    tolerance : float
        General tolerance of the dimensions [m], for this block, which it makes, too.
    thickness : float, optional
        Thickness of the parts in FILE.stl [m].

    Returns
    -------
    list of Nearest
        As `motion_check`.

    Raises
    ------
    InvalidValue
        If the mechanism has no size, a hole leaves no wall, the parts do not fit on the sheet, or
        two bodies overlap by more than 1 um anywhere in a turn.
    MissingPackage
        Where the extra is not installed.
    CannotCreate, StorageError
        As `escapement.base.files.write_file`.
    """
    data, gaps = drawn(
        mechanism, file_format(path, CUTS), fits or Fits(), inches, r12, sheet, title, tolerance,
        thickness, segments=segments, crosses=crosses,
    )  # fmt: skip
    write_file(path, [data], force)
    return gaps


def drawn(
    mechanism: Any,
    suffix: str,
    fits: Fits,
    inches: bool = False,
    r12: bool = False,
    sheet: Sequence[float] | None = None,
    title: str = "",
    tolerance: float = 0.0,
    thickness: float | None = None,
    **how: bool,
) -> tuple[bytes, list[Nearest]]:
    """The content of a file of this suffix, and the least gaps; arguments as of `export`."""
    stock = None if sheet is None else _stock(sheet)
    tolerance = validate.non_negative("tolerance", tolerance, "give it in m")
    gaps = motion_check(mechanism, fits)
    for pair in gaps[:1]:
        if pair.gap < -_TOUCH:
            raise InvalidValue(
                f"{pair.names[0]} and {pair.names[1]} must not overlap, got "
                f"{on_drawing(-pair.gap)} at a driver angle of {math.degrees(pair.theta):.3f} "
                f"degrees, at ({on_drawing(pair.point.real)}, {on_drawing(pair.point.imag)}) from "
                "the follower's axis; choose another clearance, thinner pins or thinner shafts"
            )
    unit = (_INCH, "in") if inches else (_MILLIMETRE, "mm")
    parts, block = parts_of(mechanism, fits), list[tuple[str, str]]()
    if suffix == ".stl":
        thick = validate.positive("thickness", thickness, "give it in m for solids")
        check_solid(parts)
        return stl(
            lay_out(parts, fits.kerf, 1.0 / unit[0], True, stock=stock), thick / unit[0]
        ), gaps
    if title or tolerance:
        block = title_block(title, tolerance, mechanism, fits, parts, gaps, unit)
    laid = lay_out(parts, fits.kerf, 1.0 / unit[0], stock=stock, block=block, **how)
    if isinstance(mechanism, TwoBodies) and suffix == ".dxf":
        laid = _with_bodies(laid, mechanism, mechanism.crank_radius / unit[0])
    return _WRITERS[suffix](laid, inches, r12), gaps


def _stock(sheet: Sequence[float]) -> complex:
    """Width and height of a sheet as one number; raises InvalidValue if it is none."""
    sizes = validate.numbers("sheet", sheet, "give width and height in m")
    if sizes.shape != (2,) or not np.all(sizes > 0.0):
        got = Spoken(", ".join(spoken_length(size) for size in sizes.ravel().tolist()))
        raise validate.fail("sheet", "a width and a height", got, "give two lengths")
    return complex(*sizes.tolist())


def _with_bodies(sheet: Sheet, mechanism: TwoBodies, scale: float) -> Sheet:
    """The sheet with both bodies beside it, for `read_outlines`: the driver as at the start of a
    motion, and the follower at 0, where a pendulum hangs."""
    shown: Any = {body.name: body for body in bodies(mechanism, mechanism.start[0], 0.0)}
    left = min(edge.box[0].real for edge in shown["driver"].edges)
    axis = sheet.size.real - scale * left + 0.5j * sheet.size.imag
    axes = ("DRIVER", axis), ("FOLLOWER", axis + scale * mechanism.axes_distance)
    for layer, _ in axes:
        edges = [edge.moved(scale, axis) for edge in shown[layer.lower()].edges]
        sheet.curves.extend((layer, edge) for edge in edges)
    return sheet._replace(points=axes)


def _dxf(sheet: Sheet, inches: bool, r12: bool) -> bytes:
    """The sheet as DXF."""
    ezdxf = validate.package("ezdxf", "a DXF file", "cad")
    drawing = ezdxf.document.Drawing.new("AC1009" if r12 else "AC1024")
    if not r12:
        drawing.header["$MEASUREMENT"] = 0 if inches else 1
        drawing.units = 1 if inches else 4  # the codes of $INSUNITS
    for name, (colour, _) in LAYERS.items():
        drawing.layers.add(name, color=colour)
    space = drawing.modelspace()
    add: Callable[..., Any] = space.add_polyline2d if r12 else space.add_lwpolyline
    for layer, curve in sheet.curves:
        if (circle := _circle(curve)) is not None:
            centre, radius = circle
            space.add_circle((centre.real, centre.imag), radius, dxfattribs={"layer": layer})
            continue
        z = curve.corners
        points = np.column_stack([z.real, z.imag, curve.bulges]).tolist()
        add(points, format="xyb", close=True, dxfattribs={"layer": layer})
    for layer, a, b in sheet.lines:
        space.add_line((a.real, a.imag), (b.real, b.imag), dxfattribs={"layer": layer})
    for layer, at in sheet.points:
        space.add_point((at.real, at.imag), dxfattribs={"layer": layer})
    for layer, at, text in sheet.texts:
        look = {"layer": layer, "insert": (at.real, at.imag)}
        space.add_text(text, height=sheet.height, dxfattribs=look)
    stream = StringIO()
    drawing.write(stream)
    return stream.getvalue().encode(drawing.output_encoding, errors="dxfreplace")


def _circle(curve: Curve) -> tuple[complex, float] | None:
    """Centre and radius of a whole circle made of two halves."""
    if curve.corners.size != 2 or not np.all(np.abs(curve.bulges) == 1.0):
        return None
    a, b = curve.corners.tolist()
    return 0.5 * (a + b), 0.5 * abs(a - b)


def _svg(sheet: Sheet, inches: bool, _r12: bool) -> bytes:
    """The sheet as SVG, of which the y axis points down."""
    unit, (wide, high) = "in" if inches else "mm", (sheet.size.real, sheet.size.imag)

    def at(point: complex) -> str:
        return svg_point(complex(point.real, high - point.imag), ".9f")

    def path(curve: Curve) -> str:
        below = Curve(curve.corners.conj() + 1j * high, -curve.bulges)
        return f'<path d="{below.svg(".9f")}"/>'

    style = f'fill="none" stroke-width="{0.04 * sheet.height:.4f}"'
    rows = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide:.9f}{unit}" '
        f'height="{high:.9f}{unit}" viewBox="0 0 {wide:.9f} {high:.9f}">',
    ]
    for layer, (_, colour) in LAYERS.items():
        rows.append(f'<g id="{layer}" stroke="{colour}" {style}>')
        rows += [path(curve) for name, curve in sheet.curves if name == layer]
        rows += [f'<path d="M {at(a)} L {at(b)}"/>' for name, a, b in sheet.lines if name == layer]
        size = f'font-size="{sheet.height:.4f}" stroke="none" fill="{colour}"'
        for point, text in (row[1:] for row in sheet.texts if row[0] == layer):
            x, y = at(point).split()
            rows.append(f'<text x="{x}" y="{y}" {size}>{escape(text)}</text>')
        rows.append("</g>")
    return "\n".join([*rows, "</svg>\n"]).encode()


_WRITERS = {".dxf": _dxf, ".svg": _svg}
