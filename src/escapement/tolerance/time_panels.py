"""Stretches of a motion over time that are short enough for sixteen Gauss points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from escapement.mechanisms.protocol import FloatArray
from escapement.numerics.gauss import BARYCENTRIC, POINTS, TRANSFORM
from escapement.tolerance.dual import slopes_of, value_of
from escapement.tolerance.dual_law import ANGLE, SPEED, Law, Point

RESOLVED = 1e-12
"""A panel is halved until the last Legendre coefficients are below this share of the first."""
MOST_HALVINGS = 12


@dataclass(frozen=True)
class Panel:
    """A stretch of a piece over time, at Gauss points.

    piece : index of the piece in the motion.
    start, half : its beginning and half its length [natural units of time].
    w : at the points, shape (n,).
    s : S at the points, shape (n, columns).
    """

    piece: int
    start: float
    half: float
    w: FloatArray
    s: FloatArray

    @property
    def times(self) -> FloatArray:
        """The times of its points."""
        return np.asarray(self.start + self.half * (1.0 + POINTS))

    def at(self, time: float) -> FloatArray:
        """S at a time within the panel, shape (columns,)."""
        x = (time - self.start) / self.half - 1.0
        gap = x - POINTS
        if not gap.all():
            return np.asarray(self.s[gap == 0.0][0])
        weights = BARYCENTRIC / gap
        return np.asarray(weights @ self.s / weights.sum())


Equation = tuple[float, float, FloatArray, FloatArray, FloatArray]
"""Start and half length of a panel; at its points w, and a and b of S' = a S + b."""


def resolved(law: Law, point_at: Callable[[FloatArray], Point], ends: FloatArray) -> list[Equation]:
    """The panels of a piece between two times, in turn; `point_at` gives the law at times."""
    cuts = np.linspace(float(ends[0]), float(ends[1]), 5) if ends[1] > ends[0] else np.empty(0)
    todo, found = np.column_stack([cuts[:-1], cuts[1:]]), []
    for depth in range(MOST_HALVINGS + 1):
        if not len(todo):
            break
        starts, halves = todo[:, 0], 0.5 * (todo[:, 1] - todo[:, 0])
        times = starts[:, None] + halves[:, None] * (1.0 + POINTS)
        point = point_at(times.reshape(-1))
        slopes = 2.0 * slopes_of(point.acceleration, law.count)
        slopes = np.broadcast_to(slopes, (times.size, law.count))
        slopes = slopes.reshape(*times.shape, law.count)
        w = value_of(point.w).reshape(times.shape)
        changes = np.sqrt(w)[..., None] * slopes
        series = np.abs(TRANSFORM @ np.dstack([changes[..., :ANGLE] * halves[:, None, None], w]))
        enough = RESOLVED * (series.max(axis=1) + 1e-3)
        ample = (series[:, -2:] <= enough[:, None]).all(axis=(1, 2))
        for k in np.flatnonzero(ample | (depth == MOST_HALVINGS)):
            source = np.zeros((POINTS.size, len(law.names) + 1))
            source[:, :-1] = changes[k, :, :SPEED]
            found.append((starts[k], halves[k], w[k], changes[k, :, SPEED], source))
        rest = todo[~ample]
        middle = rest.mean(axis=1)
        todo = np.concatenate(
            [np.column_stack(x) for x in ((rest[:, 0], middle), (middle, rest[:, 1]))]
        )
    return sorted(found, key=lambda panel: panel[0])
