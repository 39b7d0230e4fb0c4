"""The mechanism's part of every panel, evaluated once per mechanism.

Panels come from halving the intervals between breaks, so most of those any scene
asks for are known beforehand: cell 1 is the whole interval, cells 2k and 2k + 1
are the halves of cell k.
"""

import numpy as np

from escapement.engines.energy.gauss import POINTS, N
from escapement.jit import jit
from escapement.mechanisms.slotted import transmission_at, transmission_on

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
