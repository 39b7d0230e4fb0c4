"""The mechanism's part of every panel, evaluated once per mechanism.

Panels come from halving the intervals between breaks, so most of those any scene
asks for are known beforehand: cell 1 is the whole interval, cells 2k and 2k + 1
are the halves of cell k.
"""

import numpy as np

from escapement.engines.energy.gauss import POINTS, N
from escapement.jit import jit
from escapement.mechanisms.slotted import transmission_at, transmission_on

_f = np.float64
_ROW = (_f, (N,))

END = np.dtype([("g", _f), ("u", _f), ("dg", _f)], align=True)
"""g, |u| and g' at one driver angle."""
CELL = np.dtype(
    [
        *(("g", *_ROW), ("u", *_ROW), ("dg", *_ROW)),
        *(("entry", END), ("exit", END)),
    ],
    align=True,
)
"""Transmission at the Gauss points and the two ends of a cell."""


@jit(allocates=True)
def tabulate_cells(path, edges, levels):
    """Transmission on the first cells of every interval between edges.

    Returns
    -------
    ndarray of CELL, shape (intervals, 2**levels)
        Row 0 is empty.
    """
    most = 2**levels
    cells = np.empty((edges.size - 1, most), CELL)
    ends = np.empty((most, 2))
    points = POINTS.copy()
    for interval in range(edges.size - 1):
        ends[1, 0], ends[1, 1] = edges[interval], edges[interval + 1]
        for k in range(1, most):
            cell = cells[interval, k]
            left, right = ends[k, 0], ends[k, 1]
            half = 0.5 * (right - left)
            if 2 * k < most:
                ends[2 * k, 0], ends[2 * k, 1] = left, left + half
                ends[2 * k + 1, 0], ends[2 * k + 1, 1] = left + half, right
            transmission_on(path, left, half, points, points.size, cell.g, cell.u, cell.dg)
            put_end(cell.entry, path, left)
            put_end(cell.exit, path, right)
    return cells


@jit
def put_end(end, path, theta):
    """Transmission at an end of a cell or panel."""
    g, u, dg = transmission_at(path, theta)
    end.g, end.u, end.dg = g, abs(u), dg
