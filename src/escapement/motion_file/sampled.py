"""A trajectory from the data of its pieces in a file."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from escapement.dynamics.trajectory import Events, Extrema, Trajectory
from escapement.engines.energy.pieces import follow
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

_RTOL = 1e-12  # tolerance of states between the data in the file


@dataclass(frozen=True)
class SampledTrajectory(Trajectory):
    """A trajectory from the starts of its pieces; see `escapement.dynamics.trajectory.Trajectory`.

    theta, theta_dot : samples there.
    """

    escapement: Escapement
    reversals: Events
    extrema: Extrema
    start: FloatArray
    engagement: np.ndarray
    sign: FloatArray
    losses: FloatArray
    theta: FloatArray
    theta_dot: FloatArray

    def states(self, pieces: np.ndarray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angles in the cell [rad] and speeds [rad/s] at times, each within a piece.

        They are computed from the piece's start with the equation of motion: a curve through the
        samples would miss the speed of a light driver, which peaks between two of them.
        """
        clock = self.escapement.time_unit
        since = np.maximum(t - self.start[pieces], 0.0) / clock
        theta, squares = follow(self.escapement, self._rows, pieces, since, _RTOL)
        return theta, np.sqrt(squares) / clock

    @cached_property
    def _rows(self) -> FloatArray:
        """The pieces as `pieces.states_of` takes them."""
        pairs, cell = self.escapement.pairs, self.escapement.mechanism.cell_angle
        ends = [(m.edges[0], m.edges[-1], m.edges[-1] + m.dwell, m.delay) for m in pairs]
        index = self.engagement % len(pairs)
        entry, exit_, cell_end, delay = np.array(ends).T[:, index]
        first = np.diff(self.engagement, prepend=-1) != 0
        angle = self.theta - self.engagement * cell - delay
        locked = self.sign == 0.0
        angle = np.where(locked & ~np.append(False, locked[:-1]), exit_, angle)
        angle = np.where(first, entry, angle)
        # a piece ends where the next one of its engagement begins, or at the end of the cell
        end = np.where(np.roll(first, -1), cell_end, np.roll(angle, -1))
        end[-1] = cell_end[-1]
        driver_angle = self.escapement.driver_angle_before(self.engagement) + np.zeros(angle.size)
        w = (self.theta_dot * self.escapement.time_unit) ** 2
        return np.column_stack([index, self.sign, angle, end, w, driver_angle])
