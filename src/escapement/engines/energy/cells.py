"""g, u, g' and R on the panels that most scenes need, evaluated once per escapement or study.

Panels come from halving the intervals between the edges of a scene, so the first of them are
known before any motion is. Cell 1 is a whole interval, and cells 2k and 2k + 1 are the halves
of cell k.
"""

from functools import lru_cache

import numpy as np

from escapement.engines.energy.panels import END, ROW, WORKSPACE, fill_end
from escapement.mechanisms.path import Path
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import transmission_on
from escapement.numerics.gauss import POINTS, N
from escapement.numerics.jit import jit
from escapement.numerics.records import record_dtype

CELL = record_dtype({"g": ROW, "u": ROW, "dg": ROW, "radius": ROW, "entry": END, "exit": END})
"""g, u, g' and R at the Gauss points, and at the two ends of a cell."""
NO_CELLS = np.empty((1, 0), CELL)
"""Cells of a mechanism without tabulated values."""


@jit
def tabulate_cells(path, edges, work, ends, cells):
    """Fill `cells` with the transmission on the first cells of every interval between edges.

    Parameters
    ----------
    path, edges : of a `Scene`.
    work : array with one `panels.WORKSPACE`.
    ends : array of shape (cells, 2), for driver angles.
    cells : array of `CELL` of shape (intervals, cells); column 0 stays empty.
    """
    most = cells.shape[1]
    # the 16 Gauss points, in a row of the workspace as `transmission_on` needs them
    row, count = work[0].scratch, work[0].points & N
    for i in range(N):
        row[i] = POINTS[i]
    for interval in range(edges.size - 1):
        ends[1, 0], ends[1, 1] = edges[interval], edges[interval + 1]
        # a cell comes before its halves, so that its ends are known when they are needed
        for k in range(1, most):
            cell = cells[interval, k]
            left, right = ends[k, 0], ends[k, 1]
            half = 0.5 * (right - left)
            if 2 * k < most:
                ends[2 * k, 0], ends[2 * k, 1] = left, left + half
                ends[2 * k + 1, 0], ends[2 * k + 1, 1] = left + half, right
            g, u, dg, radius = cell.g, cell.u, cell.dg, cell.radius
            transmission_on(path, left, half, row, count, g, u, dg, radius)
            fill_end(cell.entry, path, left, False)
            fill_end(cell.exit, path, right, False)


def cells_of(path: Path, edges: FloatArray) -> FloatArray:
    """The first cells of every interval between the edges of a mechanism."""
    return _cells_of(path.table, path.numbers.tobytes(), edges.tobytes())


# a study asks for those of the same mechanism again and again
@lru_cache(32)
def _cells_of(table: bool, numbers: bytes, angles: bytes) -> FloatArray:
    path, edges = Path(table, np.frombuffer(numbers).copy()), np.frombuffer(angles).copy()
    # a table has many intervals, which are short and need few halvings
    most = 2**5 if edges.size < 8 else 2**2
    cells = np.empty((edges.size - 1, most), CELL)
    work = np.zeros(1, WORKSPACE)
    work["points"] = N
    tabulate_cells(path, edges, work, np.empty((most, 2)), cells)
    return cells
