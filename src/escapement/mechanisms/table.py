"""A transmission as piecewise Chebyshev series: for mechanisms without a slot.

The follower of such a mechanism never leaves the driver; what is lost is a share of
the power that passes the mesh. The numbers of the path are

    [pieces, order, edges..., coefficients of g, piece after piece]
"""

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from escapement.jit import inner_jit
from escapement.model import FloatArray
from escapement.scene import Path

ORDER = 17
_RESOLVED = 1e-15  # last coefficients over the largest: rounding
_MOST = 4096


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

    The knots of a spline; series of full order are cut for accuracy alone. And where
    the follower turns back, g changing its sign: the loss goes with its size.
    """
    found = [edges[1:-1]] if series.shape[1] < ORDER else []
    # the values of a series lie within the sum of its coefficients about the first
    for k in np.nonzero(series[:, 0] <= np.abs(series[:, 1:]).sum(axis=1))[0]:
        x = np.polynomial.chebyshev.chebroots(np.trim_zeros(series[k], "b"))
        x = x.real[(np.abs(x.imag) < 1e-6) & (np.abs(x.real) < 1.0)]
        found.append(edges[k] + 0.5 * (edges[k + 1] - edges[k]) * (1.0 + x))
    return np.concatenate(found) if found else edges[:0]


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
        Coefficients of a piece; a piece is halved until they suffice. A spline of
        degree k needs k of them.

    Returns
    -------
    Path
        A table whose numbers `ratio_at` reads; accurate to rounding of the largest g.

    Raises
    ------
    ValueError
        Where the function is not smooth enough between two edges.
    """
    angles = np.pi * (np.arange(order) + 0.5) / order
    points = np.cos(angles)
    transform = np.cos(np.outer(np.arange(order), angles)) * (2.0 / order)
    transform[0] /= 2.0
    done: list[tuple[float, FloatArray]] = []
    waiting = [(float(a), float(b)) for a, b in itertools.pairwise(edges)][::-1]
    largest = max(
        float(np.abs(function(0.5 * (a + b + (b - a) * points))).max()) for a, b in waiting
    )
    while waiting:
        left, right = waiting.pop()
        half = 0.5 * (right - left)
        values = np.asarray(function(left + half * (1.0 + points)), dtype=float)
        # a spline's many pieces are all but even: rounding of their sums would be a slope of
        # one sign, and add up to a step over the cell
        even = values[order // 2] if order < ORDER else 0.0
        series = transform @ (values - even)
        series[0] += even
        rough = np.abs(series[-2:]).max() > _RESOLVED * largest
        if rough and order >= ORDER:
            if half < 1e-9 or len(done) + len(waiting) >= _MOST:
                raise ValueError(f"the transmission is not smooth near {left:.9g} rad")
            middle = left + half
            waiting += [(middle, right), (left, middle)]
            continue
        done.append((left, series))
    starts = [left for left, _ in done]
    return table_path(np.array([*starts, float(edges[-1])]), np.array([row for _, row in done]))
