"""First-order change of the greatest or least value of a quantity over a motion.

Within a piece the position of a maximum does not matter, since the quantity is stationary there. At
the end of a piece the event moves, and the quantity with it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from escapement.mechanisms.protocol import FloatArray
from escapement.tolerance.dual import slopes_of, value_of
from escapement.tolerance.dual_law import ANGLE, SPEED, Point
from escapement.tolerance.time_panels import Panel
from escapement.tolerance.variation import Boundary, Variation

CLOSE = 0.02
"""A peak between two points is higher than the points by less than this share."""
Quantity = Callable[[Point], Any]


def extreme(varied: Variation, quantity: Quantity, sign: float = 1.0) -> tuple[float, FloatArray]:
    """The greatest value of a quantity over a motion, or the least if `sign` is -1.

    Returns
    -------
    float, ndarray of shape (columns,)
        The value and its derivatives.
    """
    found: list[tuple[float, Any]] = []
    for panels, inner, point in varied.sampled:
        piece = panels[0].piece
        ends = varied.times[piece : piece + 2]
        values = np.broadcast_to(sign * value_of(quantity(point)), inner.shape)
        at_ends = [sign * float(value_of(quantity(varied.point(piece, t)))) for t in ends]
        values = np.array([at_ends[0], *values, at_ends[1]])
        k = int(values.argmax())
        found.append((values[k], (panels, np.array([ends[0], *inner, ends[1]]), k)))
    best = max(value for value, _ in found)
    # the peaks of several engagements may be nearly equal
    near = [candidate for value, candidate in found if value >= best - CLOSE * abs(best)]
    peaks = [_nearby(varied, quantity, sign, *candidate) for candidate in near]
    return max(peaks, key=lambda peak: sign * peak[0])


def _total_slope(varied: Variation, quantity: Quantity, piece: int, time: float) -> float:
    """Derivative of the quantity by the driver angle along the motion."""
    point = varied.point(piece, time)
    found = slopes_of(quantity(point), varied.law.count)
    return float(found[ANGLE] + found[SPEED] * 2.0 * value_of(point.acceleration))


def _nearby(
    varied: Variation,
    quantity: Quantity,
    sign: float,
    panels: list[Panel],
    times: FloatArray,
    k: int,
) -> tuple[float, FloatArray]:
    """The extremum next to a point of a piece, or at its end."""
    from scipy.optimize import brentq

    piece = panels[0].piece

    def slope(time: float) -> float:
        return sign * _total_slope(varied, quantity, piece, time)

    low, high = times[max(k - 1, 0)], times[min(k + 1, times.size - 1)]
    if not slope(low) > 0.0 > slope(high):
        boundary = varied.boundaries[piece + (k > 0)]
        value = quantity(varied.point(piece, boundary.time))
        return float(value_of(value)), _at_end(varied, quantity, boundary, piece)
    time = brentq(slope, low, high, xtol=1e-15 * high)
    value = quantity(varied.point(piece, time))
    found = slopes_of(value, varied.law.count)
    starts = [panel.start for panel in panels]
    s = panels[max(int(np.searchsorted(starts, time, side="right")) - 1, 0)].at(time)
    return float(value_of(value)), np.append(found[:SPEED], 0.0) + found[SPEED] * s


def _at_end(varied: Variation, quantity: Quantity, boundary: Boundary, piece: int) -> FloatArray:
    """The derivative at a boundary, on the side of a piece."""
    point = varied.point(piece, boundary.time)
    s = boundary.behind if piece == boundary.piece else boundary.before
    slope = 2.0 * float(value_of(point.acceleration))
    return varied.total(quantity(point), s, boundary.angle, slope)
