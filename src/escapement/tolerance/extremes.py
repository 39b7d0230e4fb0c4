"""How the greatest or least value of a quantity over a motion changes, to first order.

Within a piece the place of a maximum does not matter, since the quantity is stationary there. At
the end of a piece the event moves, and the quantity with it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from escapement.mechanism import FloatArray
from escapement.tolerance.dual import slopes_of, value_of
from escapement.tolerance.law import ANGLE, SPEED, Point
from escapement.tolerance.panels import Panel
from escapement.tolerance.variation import Variation

Quantity = Callable[[Point], Any]


def extreme(varied: Variation, quantity: Quantity, sign: float = 1.0) -> tuple[float, FloatArray]:
    """The greatest value of a quantity over a motion, or the least where `sign` is -1.

    Returns
    -------
    float, ndarray of shape (columns,)
        The value and its derivatives.
    """
    best: tuple[float, Any] = (-np.inf, None)
    for panels, times, point in varied.sampled:
        values = np.broadcast_to(sign * value_of(quantity(point)), times.shape)
        if values.max() > best[0]:
            best = float(values.max()), ("within", panels, times, int(values.argmax()))
    for k, boundary in enumerate(varied.boundaries):
        for piece in {max(boundary.piece - 1, 0), min(boundary.piece, len(varied.sides) - 1)}:
            value = sign * float(value_of(quantity(varied.point(piece, boundary.time))))
            if value > best[0]:
                best = value, ("end", k, piece)
    if best[1][0] == "end":
        return sign * best[0], _at_end(varied, quantity, *best[1][1:])
    return _within(varied, quantity, *best[1][1:])


def _total_slope(varied: Variation, quantity: Quantity, piece: int, time: float) -> float:
    """Derivative of the quantity by the driver angle along the motion."""
    point = varied.point(piece, time)
    found = slopes_of(quantity(point), varied.law.count)
    return float(found[ANGLE] + found[SPEED] * 2.0 * value_of(point.acceleration))


def _within(
    varied: Variation, quantity: Quantity, panels: list[Panel], times: FloatArray, k: int
) -> tuple[float, FloatArray]:
    """The extremum next to a point of a piece."""
    from scipy.optimize import brentq

    piece = panels[0].piece
    ends = np.array([varied.times[piece], *times, varied.times[piece + 1]])
    low, high = ends[k], ends[k + 2]

    def slope(time: float) -> float:
        return _total_slope(varied, quantity, piece, time)

    time = times[k]
    if slope(low) * slope(high) < 0.0:
        time = brentq(slope, low, high, xtol=1e-15 * high)
    value = quantity(varied.point(piece, time))
    found = slopes_of(value, varied.law.count)
    starts = [panel.start for panel in panels]
    s = panels[max(int(np.searchsorted(starts, time, side="right")) - 1, 0)].at(time)
    return float(value_of(value)), np.append(found[:SPEED], 0.0) + found[SPEED] * s


def _at_end(varied: Variation, quantity: Quantity, k: int, piece: int) -> FloatArray:
    """The derivative at a boundary, on the side of a piece."""
    boundary = varied.boundaries[k]
    point = varied.point(piece, boundary.time)
    s = boundary.behind if piece == boundary.piece else boundary.before
    slope = 2.0 * float(value_of(point.acceleration))
    return varied.total(quantity(point), s, boundary.angle, slope)
