"""The mechanism's part of every panel, evaluated once per mechanism.

Panels come from halving the intervals between breaks, so most of those any scene
asks for are known beforehand: cell 1 is the whole interval, cells 2k and 2k + 1
are the halves of cell k.
"""

from typing import Any

import numpy as np

from escapement._jit import jit
from escapement.engines._gauss import POINTS, N
from escapement.mechanisms._slotted import transmission_at, transmission_on
from escapement.mechanisms._table import smooth_intervals
from escapement.model import FloatArray

AT_G, AT_ENDS = np.int64(0), np.int64(3 * N)
_COLUMNS = AT_ENDS + 6


@jit(allocates=True)
def tabulate_cells(path, breaks, levels):
    """Transmission at the points and ends of the first cells of every interval.

    Returns
    -------
    ndarray, shape (intervals, 2**levels, 54)
        g, |u| and g' at the 16 points, then the three at either end; row 0 is empty.
    """
    most = 2**levels
    table = np.empty((breaks.size - 1, most, _COLUMNS))
    edges = np.empty((most, 2))
    line = np.empty(5 * N)  # its size has the bit N set, as transmission_on expects
    for i in range(N):
        line[_COLUMNS + i] = POINTS[i]
    for interval in range(breaks.size - 1):
        edges[1, 0], edges[1, 1] = breaks[interval], breaks[interval + 1]
        for cell in range(1, most):
            left, right = edges[cell, 0], edges[cell, 1]
            half = 0.5 * (right - left)
            if 2 * cell < most:
                edges[2 * cell, 0], edges[2 * cell, 1] = left, left + half
                edges[2 * cell + 1, 0], edges[2 * cell + 1, 1] = left + half, right
            transmission_on(path, left, half, line, _COLUMNS, AT_G)
            for end in range(2):
                g, u, dg = transmission_at(path, edges[cell, end])
                line[AT_ENDS + 3 * end] = g
                line[AT_ENDS + 3 * end + 1] = abs(u)
                line[AT_ENDS + 3 * end + 2] = dg
            for i in range(_COLUMNS):
                table[interval, cell, i] = line[i]
    return table


_known: dict[tuple[int, bytes], tuple[FloatArray, FloatArray, FloatArray]] = {}
_MOST_KNOWN = 64
_last: tuple[Any, tuple[Any, ...]] = None, ()  # scene and numbers of the last call


def with_cells(scene: tuple[Any, ...]) -> tuple[Any, ...]:
    """A scene's numbers for the kernels: cells, path, edges, and what follows.

    `scene` begins with path and breaks; the edges are those of its smooth intervals.
    Mechanisms keep their path, so those last used are known by that array. An
    escapement keeps its scene.
    """
    global _last
    before, numbers = _last
    if scene is before:
        return numbers
    path, breaks, *rest = scene
    key = id(path), breaks.tobytes()
    known = _known.get(key)
    if known is None or known[0] is not path:
        edges = smooth_intervals(path, breaks)
        if len(_known) >= _MOST_KNOWN:
            _known.clear()
        known = _known[key] = path, edges, tabulate_cells(path, edges, _levels(edges))
    numbers = known[2], path, known[1], *rest
    _last = scene, numbers
    return numbers


def _levels(edges: FloatArray) -> int:
    """How often an interval's cells are halved, the whole one included."""
    return 6 if edges.size < 8 else 2
