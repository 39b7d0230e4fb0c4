"""The sheet that a file shows: parts in rows, a title block, their lines by layer."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.base.spoken import on_drawing
from escapement.outlines.curves import Curve
from escapement.outlines.part import Part

LAYERS = {
    "CUT_OUTER": (1, "#d00000"),
    "CUT_INNER": (5, "#0000d0"),
    "ENGRAVE": (3, "#008000"),
    "CENTRE": (8, "#808080"),
    "TITLE": (7, "#000000"),
    "DRIVER": (4, "#008080"),
    "FOLLOWER": (6, "#800080"),
}
"""Layers of a drawing, and the colour of each: in the palette of DXF, and in SVG."""
_CHORDS = 5e-6  # distance of chords from the arcs in whose place they stand [m]
_ROOM = 5e-3  # between parts, and around them [m]
_HEIGHT = 2.5e-3  # height of the letters in names of parts [m]
_LETTER = 0.7 * _HEIGHT  # width of a letter [m]


class Sheet(NamedTuple):
    """What a file shows, in its unit: curves, lines, texts and points, each with its layer."""

    curves: list[tuple[str, Curve]]
    lines: list[tuple[str, complex, complex]]
    texts: list[tuple[str, complex, str]]
    size: complex
    height: float
    points: tuple[tuple[str, complex], ...] = ()

    def scaled(self, scale: float) -> "Sheet":
        """The same in another unit."""
        return Sheet(
            [(layer, curve.moved(scale)) for layer, curve in self.curves],
            [(layer, a * scale, b * scale) for layer, a, b in self.lines],
            [(layer, at * scale, text) for layer, at, text in self.texts],
            *(self.size * scale, self.height * scale),
        )


def lay_out(
    parts: Sequence[Part],
    kerf: float,
    scale: float,
    segments: bool = False,
    *,
    stock: complex | None = None,
    crosses: bool = True,
    block: Sequence[tuple[str, str]] = (),
) -> Sheet:
    """Parts side by side, or in rows on a given sheet.

    Parameters
    ----------
    parts : sequence of Part
        What is cut.
    kerf : float
        Width of the cut [m].
    scale : float
        How many of the file's units are a metre.
    segments : bool
        Whether chords stand in place of arcs.
    stock : complex, optional
        Width and height of the sheet [m].
    crosses : bool
        Whether axes and centres of holes have a cross.
    block : sequence of tuple of str
        Names and values in the title block, which stands beside the sheet.

    Raises
    ------
    InvalidValue
        If the parts do not fit on the sheet, or the cut is too wide for one.
    """
    drawn = [_curves(part, kerf, segments) for part in parts]
    # all else of a part lies within its edge, which comes first
    boxes = [curves[0][1].box for curves in drawn]
    rooms = [
        complex(max((high - low).real, _LETTER * len(part.name)), (high - low).imag + 2.0 * _HEIGHT)
        for part, (low, high) in zip(parts, boxes, strict=True)
    ]
    places, size = _in_rows(rooms, stock)
    sheet = Sheet([], [], [], size, _HEIGHT)
    for part, curves, (low, _), place in zip(parts, drawn, boxes, places, strict=True):
        shift, arm = place + 2j * _HEIGHT - low, 0.3 * _ROOM
        sheet.curves.extend((layer, curve.moved(by=shift)) for layer, curve in curves)
        for axis in (axis + shift for axis in part.axes * crosses):
            sheet.lines.extend(("CENTRE", axis - z, axis + z) for z in (arm, 1j * arm))
        sheet.texts.append(("CENTRE", place, part.name))
        sheet.texts.extend(
            ("ENGRAVE", at + shift, f"{length * scale:.4g}") for at, length in part.notes
        )
    return (_with_block(sheet, block) if block else sheet).scaled(scale)


def _curves(part: Part, kerf: float, segments: bool) -> list[tuple[str, Curve]]:
    """The curves of a part with their layers: as the cutter runs, or as they are engraved."""
    cut = [("ENGRAVE" if part.toothed else "CUT_OUTER", part.edge)]
    cut += [("CUT_INNER", hole) for hole in part.holes]
    found = [(layer, c if layer == "ENGRAVE" else c.grown(0.5 * kerf)) for layer, c in cut]
    found += [("ENGRAVE", mark) for mark in part.marks]
    return [(layer, _polygon(curve)) for layer, curve in found] if segments else found


def _in_rows(rooms: list[complex], stock: complex | None) -> tuple[list[complex], complex]:
    """Lower left corners of boxes, and the size of all: in one row, or in several on a sheet.

    On a sheet the tallest comes first, and each box goes to the first row with room for it.
    """
    wide, order = np.inf, list(range(len(rooms)))
    if stock is not None:
        wide = stock.real - _ROOM
        order.sort(key=lambda k: -rooms[k].imag)
    ends, places, top = list[complex](), [0j] * len(rooms), _ROOM
    for k in order:
        row = next((i for i, end in enumerate(ends) if end.real + rooms[k].real <= wide), len(ends))
        if row == len(ends):
            ends.append(complex(_ROOM, top))
            top += rooms[k].imag + _ROOM
        places[k] = ends[row]
        ends[row] += rooms[k].real + _ROOM
    tops = [place.imag + room.imag for place, room in zip(places, rooms, strict=True)]
    size = complex(max(end.real for end in ends), max(tops) + _ROOM)
    if stock is not None and (size.real > stock.real + 1e-9 or size.imag > stock.imag + 1e-9):
        taken, given = (f"{on_drawing(z.real)} by {on_drawing(z.imag)}" for z in (size, stock))
        raise InvalidValue(
            f"sheet must be large enough for rows of all parts, {taken}, got {given}; "
            "give a larger one, or leave it out"
        )
    return places, stock or size


def _with_block(sheet: Sheet, block: Sequence[tuple[str, str]]) -> Sheet:
    """The sheet with a title block on its right, which is not on the material."""
    names, values = zip(*(row for row in block if row[1]), strict=True)
    aside = _LETTER * max(map(len, names)) + _HEIGHT
    longest = max(aside + _LETTER * max(map(len, values)), _LETTER * len(block[0][0]))
    pitch, corner = 2.0 * _HEIGHT, sheet.size.real + _ROOM * (1.0 + 1.0j)
    room = complex(longest + 2.0 * _HEIGHT, pitch * len(block))
    frame = [corner, corner + room.real, corner + room, corner + 1j * room.imag]
    sheet.lines.extend(("TITLE", a, b) for a, b in zip(frame, frame[1:] + frame[:1], strict=True))
    for k, row in enumerate(reversed(block)):
        at = corner + complex(_HEIGHT, k * pitch + 0.5 * _HEIGHT)
        for text, shift in zip(row, (0.0, aside), strict=True):
            sheet.texts.extend([("TITLE", at + shift, text)] * (text != ""))
    whole = corner + room + _ROOM * (1.0 + 1.0j)
    return sheet._replace(size=complex(whole.real, max(sheet.size.imag, whole.imag)))


def _polygon(curve: Curve) -> Curve:
    """Chords in the place of arcs."""
    half = np.maximum(np.abs(0.5 * curve.turns), 1e-12)
    radius = np.abs(curve.ends - curve.corners) / (2.0 * np.sin(half))
    points = curve.drawn(4.0 * np.arcsin(np.sqrt(np.minimum(0.5 * _CHORDS / radius, 0.15))))[:-1]
    return Curve(points, np.zeros(points.size))
