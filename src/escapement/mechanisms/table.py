"""A transmission as piecewise Chebyshev series: for mechanisms without a slot.

The follower of such a mechanism never leaves the driver; what is lost is a share of
the power that passes the mesh. The numbers of the path are

    [pieces, order, edges..., coefficients of g, piece after piece]
"""

from collections.abc import Callable, Sequence

import numpy as np

from escapement.chebyshev import Series, fit, interpolate, nodes
from escapement.jit import inner_jit
from escapement.model import FloatArray
from escapement.scene import Path

ORDER = 17
_DECAYED = 1e-15  # of the largest g: what rounding leaves of the last two coefficients


@inner_jit
def ratio_at(numbers, theta):
    """g and g' of a table at one driver angle; beyond its ends the last piece goes on."""
    pieces, order = int(numbers[0]), int(numbers[1])
    low, high = 0, pieces
    while high - low > 1:
        middle = (low + high) // 2
        if theta >= numbers[2 + middle]:
            low = middle
        else:
            high = middle
    left, right = numbers[2 + low], numbers[3 + low]
    scale = 2.0 / (right - left)
    x = (theta - left) * scale - 1.0
    first = 3 + pieces + low * order
    # Clenshaw's recurrence, and its derivative
    b1, b2, d1, d2 = 0.0, 0.0, 0.0, 0.0
    for k in range(order - 1, 0, -1):
        d1, d2 = 2.0 * (b1 + x * d1) - d2, d1
        b1, b2 = numbers[first + k] + 2.0 * x * b1 - b2, b1
    return numbers[first] + x * b1 - b2, scale * (b1 + x * d1 - d2)


def table_path(edges: FloatArray, series: FloatArray) -> Path:
    """Path of a transmission given as Chebyshev series.

    Parameters
    ----------
    edges : ndarray, shape (pieces + 1,)
        Driver angles between which the pieces lie [rad], ascending.
    series : ndarray, shape (pieces, order)
        Coefficients of g in each piece.
    """
    numbers = np.concatenate([series.shape, edges, series.reshape(-1)])
    return Path(True, numbers, _corners(edges, series))


def read_table(path: Path) -> tuple[FloatArray, FloatArray]:
    """Edges and series of a table, as `table_path` takes them."""
    pieces, order = int(path.numbers[0]), int(path.numbers[1])
    series = path.numbers[3 + pieces :].reshape(pieces, order)
    return path.numbers[2 : 3 + pieces], series


def _corners(edges: FloatArray, series: FloatArray) -> FloatArray:
    """Driver angles at which a table is not smooth [rad].

    They are the knots of a spline; series of full order are cut for accuracy alone. Besides, the
    loss goes with the size of g, so it bends where the follower turns back and g changes its sign.
    """
    knots = edges[1:-1] if series.shape[1] < ORDER else edges[:0]
    return np.concatenate([knots, Series(edges, series).roots()[0]])


def chebyshev_table(
    function: Callable[[FloatArray], FloatArray], edges: Sequence[float], order: int = ORDER
) -> Path:
    """Path of a transmission function g(theta).

    Parameters
    ----------
    function : callable
        g at an array of driver angles [rad], analytic between neighbouring edges.
    edges : sequence of float
        First and last driver angle, and every corner between them, ascending.
    order : int
        Coefficients of a piece. With fewer than `ORDER` the function is a spline with a knot at
        each edge, whose degree k needs k of them; otherwise a piece is halved until they suffice.

    Returns
    -------
    Path
        A table whose numbers `ratio_at` reads; accurate to rounding of the largest g.

    Raises
    ------
    InvalidValue
        Where the function is not smooth enough between two edges.
    """
    if order >= ORDER:
        return table_path(*fit(function, edges, order, tail=2, decayed=_DECAYED, kinks=0))
    knots = np.array(edges, dtype=float)
    low, high = knots[:-1], knots[1:]
    # The pieces of a spline are all but even. Rounding of their sums would be a slope of one
    # sign, and add up to a step over the cell, so each is fitted to what differs from its middle.
    middle, x = function(0.5 * (low + high)), nodes(low, high, order)
    series = interpolate(function(x.reshape(-1)).reshape(x.shape) - middle[:, None])
    series[:, 0] += middle
    return table_path(knots, series)
