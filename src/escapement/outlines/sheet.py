"""The sheet that a file shows: parts side by side, their lines by layer."""

from typing import NamedTuple

import numpy as np

from escapement.outlines.curves import Curve
from escapement.outlines.part import Part

LAYERS = {
    "CUT_OUTER": (1, "#d00000"),
    "CUT_INNER": (5, "#0000d0"),
    "ENGRAVE": (3, "#008000"),
    "CENTRE": (8, "#808080"),
}
"""Layers of a drawing, and the colour of each: in the palette of DXF, and in SVG."""
_CHORDS = 5e-6  # distance of chords from the arcs in whose place they stand [m]
_ROOM = 5e-3  # between parts, and around them [m]
_HEIGHT = 2.5e-3  # height of the letters in names of parts [m]


class Sheet(NamedTuple):
    """What a file shows, in its unit: closed curves, lines and names by layer."""

    curves: list[tuple[str, Curve]]
    lines: list[tuple[complex, complex]]
    names: list[tuple[complex, str]]
    size: complex
    height: float


def lay_out(parts: tuple[Part, ...], kerf: float, scale: float, segments: bool) -> Sheet:
    """Parts side by side; `scale` is how many of the file's units are a metre."""
    curves: list[tuple[str, Curve]] = []
    lines, names, corner, top = [], [], _ROOM * (1.0 + 1.0j), 0.0
    for part in parts:
        edge = "ENGRAVE" if part.toothed else "CUT_OUTER"
        layers = [(edge, part.edge if part.toothed else part.edge.grown(0.5 * kerf))]
        layers += [("CUT_INNER", hole.grown(0.5 * kerf)) for hole in part.holes]
        layers += [("ENGRAVE", mark) for mark in part.marks]
        if segments:
            layers = [(layer, _polygon(curve)) for layer, curve in layers]
        # all else lies within the edge
        low, high = layers[0][1].box
        size = high - low
        shift = corner + 1j * (2.0 * _HEIGHT) - low
        curves += [(layer, curve.moved(by=shift).moved(scale)) for layer, curve in layers]
        for axis in part.axes:
            at, arm = axis + shift, 0.3 * _ROOM
            lines += [
                ((at - direction * arm) * scale, (at + direction * arm) * scale)
                for direction in (1.0, 1.0j)
            ]
        names.append((corner * scale, part.name))
        top = max(top, size.imag)
        corner += max(size.real, 0.7 * _HEIGHT * len(part.name)) + _ROOM
    whole = complex(corner.real, top + 2.0 * (_ROOM + _HEIGHT))
    return Sheet(curves, lines, names, whole * scale, _HEIGHT * scale)


def _polygon(curve: Curve) -> Curve:
    """Chords in the place of arcs."""
    half = np.maximum(np.abs(0.5 * curve.turns), 1e-12)
    radius = np.abs(curve.ends - curve.corners) / (2.0 * np.sin(half))
    points = curve.drawn(2.0 * np.arccos(1.0 - np.minimum(_CHORDS / radius, 0.3)))[:-1]
    return Curve(points, np.zeros(points.size))
