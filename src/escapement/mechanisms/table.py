"""A transmission as piecewise Chebyshev series: for mechanisms without a slot.

The follower of such a mechanism never leaves the driver; what is lost is a share of
the power that passes the mesh. The flat numbers are

    [0, pieces, order, edges..., coefficients of g, piece after piece]

A pin path never starts with 0 (its half angle turns), so the first number tells the
two forms apart.
"""

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from escapement.jit import jit
from escapement.model import FloatArray

ORDER = 17
_RESOLVED = 1e-15  # last coefficients over the largest: rounding
_MOST = 4096


@jit
def is_table(path):
    """Whether flat numbers describe a table rather than a pin path."""
    return path[0] == 0.0


@jit
def ratio_at(path, theta):
    """g and g' of a table at one driver angle; beyond its ends the last piece goes on."""
    pieces, order = int(path[1]), int(path[2])
    low, high = 0, pieces
    while high - low > 1:
        middle = (low + high) // 2
        if theta >= path[3 + middle]:
            low = middle
        else:
            high = middle
    left, right = path[3 + low], path[4 + low]
    scale = 2.0 / (right - left)
    x = (theta - left) * scale - 1.0
    first = 4 + pieces + low * order
    # Clenshaw's recurrence, and its derivative
    b1, b2, d1, d2 = 0.0, 0.0, 0.0, 0.0
    for k in range(order - 1, 0, -1):
        d1, d2 = 2.0 * (b1 + x * d1) - d2, d1
        b1, b2 = path[first + k] + 2.0 * x * b1 - b2, b1
    return path[first] + x * b1 - b2, scale * (b1 + x * d1 - d2)


def smooth_intervals(path: FloatArray, breaks: FloatArray) -> FloatArray:
    """Driver angles between which the motion is smooth but for reversals [rad], ascending.

    The breaks and, of a table, the corners between: over those no rule for smooth
    functions keeps its accuracy. An edge that rounding alone tells from the one before,
    or from the last, is left out.
    """
    edges = np.union1d(breaks, _corners(path)) if is_table(path) else np.asarray(breaks)
    gap = 1e-9 * (edges[-1] - edges[0])
    chosen = np.concatenate([[True], np.diff(edges) > gap])
    chosen[:-1] &= edges[-1] - edges[:-1] > gap
    chosen[-1] = True
    return edges[chosen]


def _corners(path: FloatArray) -> FloatArray:
    """Driver angles at which a table is not smooth [rad].

    The knots of a spline; series of full order are cut for accuracy alone. And where
    the follower turns back, g changing its sign: the loss goes with its size.
    """
    pieces, order = int(path[1]), int(path[2])
    edges = path[3 : 4 + pieces]
    series = path[4 + pieces :].reshape(pieces, order)
    found = [edges[1:-1]] if order < ORDER else []
    # the values of a series lie within the sum of its coefficients about the first
    for k in np.nonzero(series[:, 0] <= np.abs(series[:, 1:]).sum(axis=1))[0]:
        x = np.polynomial.chebyshev.chebroots(np.trim_zeros(series[k], "b"))
        x = x.real[(np.abs(x.imag) < 1e-6) & (np.abs(x.real) < 1.0)]
        found.append(edges[k] + 0.5 * (edges[k + 1] - edges[k]) * (1.0 + x))
    return np.concatenate(found) if found else path[:0]


def chebyshev_table(
    function: Callable[[FloatArray], FloatArray], edges: Sequence[float], order: int = ORDER
) -> FloatArray:
    """Flat numbers of a transmission function g(theta).

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
    ndarray
        As `ratio_at` expects; accurate to rounding of the largest g.

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
    coefficients = np.concatenate([series for _, series in done])
    return np.concatenate([[0.0, len(done), order], starts, [float(edges[-1])], coefficients])
