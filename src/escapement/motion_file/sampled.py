"""A trajectory between the samples of a file."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from escapement.engines.energy.pieces import follow
from escapement.mechanism import FloatArray
from escapement.model import Escapement
from escapement.trajectory import Events, Extrema

_RTOL = 1e-12  # of states between what the file holds


@dataclass(frozen=True)
class SampledTrajectory:
    """A trajectory between samples; see `escapement.trajectory.Trajectory`.

    t, theta, theta_dot : samples, each start of a piece among them.
    """

    escapement: Escapement
    reversals: Events
    extrema: Extrema
    start: FloatArray
    engagement: np.ndarray
    sign: FloatArray
    losses: FloatArray
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
        angle, end, speed = (values[piece] for values in self._pieces)
        start = (angle, (speed * clock) ** 2, self.sign[piece])
        scenes, engagement = self.escapement.scenes, int(self.engagement[piece])
        turned = self.escapement.turned_before(engagement)
        scene = scenes[engagement % len(scenes)]._replace(turned=turned)
        theta, squares = follow(scene, start, end, since, _RTOL)
        return theta, np.sqrt(squares) / clock

    @cached_property
    def _pieces(self) -> tuple[list[float], list[float], list[float]]:
        """Of each piece where in the cell it starts and ends at the latest, and its first speed."""
        meetings, cell = self.escapement.meetings, self.escapement.mechanism.cell_angle
        ends = [(m.edges[0], m.edges[-1], m.edges[-1] + m.dwell, m.late) for m in meetings]
        entry, exit_, cell_end, late = np.array(ends).T[:, self.engagement % len(meetings)]
        first = np.diff(self.engagement, prepend=-1) != 0
        # a piece of no length may end the motion
        sample = np.minimum(np.searchsorted(self.t, self.start), self.t.size - 1)
        angle = self.theta[sample] - self.engagement * cell - late
        locked = self.sign == 0.0
        angle = np.where(locked & ~np.append(False, locked[:-1]), exit_, angle)
        angle = np.where(first, entry, angle)
        # a piece ends where the next one of its engagement begins, or at the end of the cell
        end = np.where(np.roll(first, -1), cell_end, np.roll(angle, -1))
        return angle.tolist(), [*end[:-1].tolist(), cell_end[-1]], self.theta_dot[sample].tolist()
