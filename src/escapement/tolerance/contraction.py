"""Derivatives of the contraction of a cycle by the numbers of the model.

The logarithm of the contraction is the integral of f_w over the driver angle, plus the
contributions of impacts. The law is f = A + B w + C sqrt(w), where C is due only to viscous drag,
so that three values of f give f_w with its derivatives.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from escapement.mechanisms.protocol import FloatArray
from escapement.numerics.gauss import WEIGHTS
from escapement.tolerance.dual import Dual, slopes_of, value_of
from escapement.tolerance.dual_law import ANGLE, SPEED
from escapement.tolerance.variation import Variation


def contraction(varied: Variation, first: FloatArray) -> Dual:
    """The contraction of a cycle, of which `first` is S at the start by each number."""
    change = np.zeros(len(varied.law.names))

    def closed(columns: FloatArray) -> FloatArray:
        return np.asarray(columns[..., :-1] + columns[..., -1:] * first)

    for panels, times, _point in varied.sampled:
        slopes = slopes_of(_decay(varied, panels[0].piece, times), varied.law.count)
        for panel, part in zip(panels, np.split(slopes, len(panels)), strict=True):
            inner = part[:, :SPEED] + part[:, SPEED, None] * closed(panel.s)
            change += panel.half * (WEIGHTS * np.sqrt(panel.w)) @ inner
    for boundary in varied.boundaries[1:]:
        if boundary.angle.any():
            change += closed(boundary.angle) * _step(varied, boundary)
        if varied.begins(boundary.piece):
            left = varied.law.impact(varied.next_pair(boundary.piece))
            change += 2.0 * slopes_of(left, varied.law.count)[..., :SPEED] / value_of(left)
    value = float(varied.boundaries[-1].behind[-1])
    return Dual(value, value * change)


def _step(varied: Variation, boundary: Any) -> float:
    """By how much f_w falls at an event, after which another formula holds."""
    before = float(value_of(_decay(varied, boundary.piece - 1, boundary.time)))
    # a cycle ends as it begins
    piece = boundary.piece % len(varied.sides)
    return before - float(value_of(_decay(varied, piece, varied.times[piece])))


def _decay(varied: Variation, piece: int, times: Any) -> Any:
    """f_w at times within a piece."""
    here, law = varied.point(piece, times), varied.law
    pair, side = varied.pair(piece), varied.sides[piece]
    angle = law.seeded(varied.state(piece, times)[0].reshape(np.shape(times)), ANGLE)

    def rate(w: float) -> Any:
        still = Dual(np.full(np.shape(times), w), np.zeros((*np.shape(times), law.count)))
        return 2.0 * law.at(pair, side, angle, still, *varied.signs[piece]).acceleration

    one, four, nine = rate(1.0), rate(4.0), rate(9.0)
    b = 0.5 * (nine - 2.0 * four + one)
    return b + (four - one - 3.0 * b) / (2.0 * np.sqrt(here.w))
