"""The mechanism's part of every panel, evaluated once per mechanism.

Panels come from halving the intervals between breaks, so most of those any scene
asks for are known beforehand: cell 1 is the whole interval, cells 2k and 2k + 1
are the halves of cell k.
"""

from escapement.engines.energy.gauss import POINTS, N
from escapement.engines.energy.records import END, ROW, put_end, record
from escapement.jit import jit
from escapement.mechanisms.slotted import transmission_on

CELL = record({"g": ROW, "u": ROW, "dg": ROW, "entry": END, "exit": END})
"""g, |u| and g' at the Gauss points, and at the two ends of a cell."""


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
    row, count = work[0].series, work[0].points & N
    for i in range(N):
        row[i] = POINTS[i]
    for interval in range(edges.size - 1):
        ends[1, 0], ends[1, 1] = edges[interval], edges[interval + 1]
        for k in range(1, most):
            cell = cells[interval, k]
            left, right = ends[k, 0], ends[k, 1]
            half = 0.5 * (right - left)
            if 2 * k < most:
                ends[2 * k, 0], ends[2 * k, 1] = left, left + half
                ends[2 * k + 1, 0], ends[2 * k + 1, 1] = left + half, right
            transmission_on(path, left, half, row, count, cell.g, cell.u, cell.dg)
            put_end(cell.entry, path, left)
            put_end(cell.exit, path, right)
