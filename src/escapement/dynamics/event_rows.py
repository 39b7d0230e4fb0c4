"""Events of a motion with blows, read from the rows that an engine has noted."""

from functools import cached_property
from typing import Any

import numpy as np

from escapement.dynamics.codes import EXTREMA, PIECES, Event
from escapement.dynamics.trajectory import Events, Extrema, Impacts, Trajectory
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

EVENT = {
    "kind": np.int64,  # an `Event`
    "wall": float,
    "time": float,
    **dict.fromkeys(("theta", "speed", "phi", "turning"), float),
    # of an impact: driver speed before it, speed of approach, impulse, and the energy that it takes
    **dict.fromkeys(("before", "approach", "impulse", "energy"), float),
}
"""Fields of a row, for `numerics.records`: the start of a piece, or an event."""


class NotedTrajectory(Trajectory):
    """Base of trajectories whose pieces and events are rows of `EVENT` in natural units."""

    escapement: Escapement
    end_time: float

    @property
    def _happened(self) -> tuple[np.ndarray, np.ndarray]:
        """All rows of the motion, and the engagement of each."""
        raise NotImplementedError

    def _seconds(self, rows: np.ndarray) -> FloatArray:
        """Times of rows [s]."""
        return np.asarray(np.minimum(rows["time"] * self.escapement.time_unit, self.end_time))

    def columns(self, rows: np.ndarray, engagement: np.ndarray) -> dict[str, Any]:
        """Columns of `Events` by name for some rows."""
        theta = rows["theta"] + engagement * self.escapement.mechanism.cell_angle
        columns = {"engagement": engagement, "time": self._seconds(rows), "theta": theta}
        return columns | {"theta_dot": rows["speed"] / self.escapement.time_unit}

    def _chosen(self, *kinds: Event) -> tuple[np.ndarray, np.ndarray]:
        """The rows of some kinds, and their engagements."""
        rows, engagement = self._happened
        chosen = np.isin(rows["kind"], [int(kind) for kind in kinds])
        return rows[chosen], engagement[chosen]

    @cached_property
    def _pieces(self) -> tuple[np.ndarray, np.ndarray]:
        return self._chosen(*PIECES)

    @cached_property
    def start(self) -> FloatArray:
        """Start time of each piece [s]."""
        return self._seconds(self._pieces[0])

    @property
    def engagement(self) -> np.ndarray:
        """Engagement of each piece."""
        return self._pieces[1]

    @property
    def sign(self) -> FloatArray:
        """The wall that is touched in each piece, 0 in flights and dwells."""
        rows = self._pieces[0]
        return np.where(rows["kind"] == Event.CONTACT, rows["wall"], 0.0)

    @cached_property
    def reversals(self) -> Events:
        """Every instant at which a contact ends because its force becomes zero."""
        return Events(**self.columns(*self._chosen(Event.LIFT_OFF)))

    @cached_property
    def slide_changes(self) -> Events:
        """Every instant at which the contact point changes its sense of sliding."""
        return Events(**self.columns(*self._chosen(Event.SLIDE_CHANGE)))

    @cached_property
    def extrema(self) -> Extrema:
        """Every extremum of the driver speed."""
        rows, engagement = self._chosen(*EXTREMA)
        maximum = rows["kind"] == Event.MAXIMUM
        return Extrema(**self.columns(rows, engagement), maximum=maximum)

    @cached_property
    def impacts(self) -> Impacts:
        """Every impact."""
        rows, engagement = self._chosen(Event.IMPACT)
        escapement, wheel = self.escapement, self.escapement.mechanism
        length, clock, torque = wheel.crank_radius, escapement.time_unit, escapement.torque_unit
        return Impacts(
            **self.columns(rows, engagement),
            wall=rows["wall"],
            speed_before=rows["before"] / clock,
            approach_speed=rows["approach"] * length / clock,
            impulse=rows["impulse"] * torque * clock / length,
            energy=rows["energy"] * torque,
        )
