"""A trajectory between the samples of a file."""

from dataclasses import dataclass

import numpy as np

from escapement.engines.energy.pieces import follow
from escapement.model import Escapement, FloatArray
from escapement.trajectory import Events, Extrema

_RTOL = 1e-12  # of states between what the file holds


@dataclass(frozen=True)
class SampledTrajectory:
    """A trajectory between samples; see `escapement.motion.Trajectory`.

    t, theta, theta_dot : samples, each start of a piece among them.
    """

    escapement: Escapement
    start: FloatArray
    engagement: np.ndarray
    sign: FloatArray
    friction_loss: FloatArray
    reversals: Events
    extrema: Extrema
    t: FloatArray
    theta: FloatArray
    theta_dot: FloatArray

    def state(self, piece: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angle in the cell [rad] and speed [rad/s] at times within a piece.

        From the piece's start by the equation of motion: no curve through the samples
        would follow the speed of a light driver, which peaks between two of them.
        """
        clock = self.escapement.time_unit
        since = np.maximum(np.ascontiguousarray(t) - self.start[piece], 0.0) / clock
        angle, w = self._start(piece)
        end = self.escapement.mechanism.breaks[-1]
        if not self._begins(piece + 1):
            end = self._start(piece + 1)[0]
        start = (angle, w, self.sign[piece])
        theta, squares = follow(self.escapement.scene, start, end, since, _RTOL)
        return theta, np.sqrt(squares) / clock

    def _begins(self, piece: int) -> bool:
        """Whether a piece, there or not, is the first of an engagement."""
        inside = 0 < piece < self.start.size
        return not inside or bool(self.engagement[piece] != self.engagement[piece - 1])

    def _start(self, piece: int) -> tuple[float, float]:
        """Driver angle in the cell, and squared speed in natural units, where a piece starts."""
        mechanism = self.escapement.mechanism
        # a piece of no length may end the motion
        sample = min(int(np.searchsorted(self.t, self.start[piece])), self.t.size - 1)
        angle = self.theta[sample] - self.engagement[piece] * mechanism.cell_angle
        if self._begins(piece):
            angle = mechanism.breaks[0]
        elif self.sign[piece] == 0.0:
            angle = mechanism.breaks[-1]
        return float(angle), float(self.theta_dot[sample] * self.escapement.time_unit) ** 2
