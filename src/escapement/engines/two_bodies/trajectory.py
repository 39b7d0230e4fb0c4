"""A motion of two bodies in pieces: flights, and contacts of one pair of features each."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from escapement.dynamics.codes import PIECES, Event
from escapement.dynamics.law import LOSSES
from escapement.dynamics.motion import State
from escapement.dynamics.trajectory import Events, Extrema, Impacts, Trajectory
from escapement.engines.two_bodies.law import LOST, MOTION, STATE, stored
from escapement.engines.two_bodies.march import ROW, STEP, march
from escapement.engines.two_bodies.scene import prepared
from escapement.engines.two_bodies.trace import MORE, trace
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.numerics.jit import as_python

_ROOM = 128  # rows that an engagement takes, in most cases
_SLIGHT = 1e-12  # share of the speed below which two speeds are equal


@dataclass
class TwoBodyTrajectory(Trajectory):
    """The states at handoffs, from which everything else is computed when it is read.

    begins : shape (n + 1,), `march.BEGIN` at the start and at handoffs.
    end_time : time at which the motion ends [s].
    """

    escapement: Escapement
    begins: np.ndarray
    end_time: float

    @property
    def _end(self) -> float:
        return self.end_time / self.escapement.time_unit

    @cached_property
    def _rows(self) -> np.ndarray:
        """All rows of the motion."""
        scene, used = prepared(self.escapement), np.zeros(2, np.int64)
        # a motion that ends at a handoff has no part of the next engagement
        last = int(np.searchsorted(self.begins["time"], self._end * (1.0 - 1e-14)))
        begins, size = np.resize(self.begins, max(last, 1) + 1), _ROOM * max(last, 1)
        while True:
            rows = np.zeros(size, ROW)
            used[:] = 0
            march(*scene[:4], self._end * (1.0 + 1e-15), begins[:], rows, used)
            if used[0] <= size:
                break
            size = int(used[0])
        rows = rows[: used[0]]
        return np.asarray(rows[rows["time"] <= self._end * (1.0 + 1e-15)])

    @cached_property
    def _steps(self) -> np.ndarray:
        return np.asarray(self._rows[self._rows["kind"] != Event.IMPACT])

    @cached_property
    def _firsts(self) -> np.ndarray:
        """The step with which each piece begins."""
        return np.flatnonzero(self._steps["kind"] != STEP)

    def _seconds(self, rows: np.ndarray) -> FloatArray:
        return np.asarray(np.minimum(rows["time"] * self.escapement.time_unit, self.end_time))

    def _columns(self, rows: np.ndarray) -> dict[str, Any]:
        """Columns of `Events` by name for some rows."""
        theta = rows["y"][:, 0] + rows["engagement"] * self.escapement.mechanism.cell_angle
        return {
            "engagement": rows["engagement"],
            "time": self._seconds(rows),
            "theta": theta,
            "theta_dot": rows["y"][:, 2] / self.escapement.time_unit,
        }

    @cached_property
    def start(self) -> FloatArray:
        """Start time of each piece [s]."""
        return self._seconds(self._steps[self._firsts])

    @property
    def engagement(self) -> np.ndarray:
        """Engagement of each piece."""
        return np.asarray(self._steps["engagement"][self._firsts])

    @property
    def sign(self) -> FloatArray:
        """The sense in which the contact turns the follower in each piece, 0 in flights."""
        return np.asarray(self._steps["side"][self._firsts])

    @cached_property
    def _follows(self) -> tuple[np.ndarray, np.ndarray]:
        """Pieces that begin within an engagement without a blow, and the pieces before them."""
        rows = self._rows[self._rows["kind"] != STEP]
        pieces = np.isin(rows["kind"], PIECES)
        same = np.diff(rows["engagement"], prepend=-1) == 0
        plain = np.flatnonzero(pieces & same & np.roll(pieces, 1))
        return rows[plain], rows[plain - 1]

    @cached_property
    def reversals(self) -> Events:
        """Every instant at which a contact ends because its force becomes zero."""
        rows, before = self._follows
        return Events(**self._columns(rows[(rows["pair"] < 0) & (before["pair"] >= 0)]))

    @cached_property
    def slide_changes(self) -> Events:
        """Every instant at which the sliding of a contact turns round."""
        rows, before = self._follows
        same = (rows["pair"] >= 0) & (rows["pair"] == before["pair"])
        return Events(**self._columns(rows[same & (rows["sigma"] == -before["sigma"])]))

    @cached_property
    def extrema(self) -> Extrema:
        """Every extremum of the driver speed, which is monotonic within each step."""
        rows = self._rows
        impact = rows["kind"] == Event.IMPACT
        before = rows[impact].copy()
        before["y"][:, 2] = before["before"]
        every = np.insert(rows, np.flatnonzero(impact), before)
        speed = every["y"][:, 2]
        changes = np.flatnonzero(np.abs(np.diff(speed)) > _SLIGHT * np.abs(speed).max(initial=0.0))
        rising = np.diff(speed)[changes] > 0.0
        turns = np.flatnonzero(rising[1:] != rising[:-1]) + 1
        chosen = every[changes[turns]]
        return Extrema(**self._columns(chosen), maximum=~rising[turns])

    @cached_property
    def impacts(self) -> Impacts:
        """Every blow."""
        rows, timer = self._rows[self._rows["kind"] == Event.IMPACT], self.escapement
        clock, torque, length = timer.time_unit, timer.torque_unit, _length(timer)
        return Impacts(
            **self._columns(rows),
            wall=rows["side"],
            speed_before=rows["before"] / clock,
            approach_speed=rows["approach"] * length / clock,
            impulse=rows["impulse"] * torque * clock / length,
            energy=rows["energy"] * torque,
        )

    def _traced(self, which: np.ndarray, since: FloatArray) -> FloatArray:
        """Natural states and what belongs to them, with a column for each time since a step."""
        scene, table = prepared(self.escapement), np.empty((STATE + MORE, which.size))
        trace(scene.law, scene.pairs, scene.pitches[0], self._steps, which, since, table)
        return table

    @cached_property
    def _last(self) -> FloatArray:
        """The state at the end."""
        last = self._steps.size - 1
        since = max(self._end - self._steps["time"][last], 0.0)
        return np.asarray(self._traced(np.array([last]), np.array([since]))[:STATE, 0])

    @cached_property
    def _work(self) -> FloatArray:
        """Work lost over each piece [J], shape (n, len(LOST))."""
        at = np.append(self._steps["y"][self._firsts, MOTION:], self._last[None, MOTION:], axis=0)
        return np.asarray(np.diff(at, axis=0) * self.escapement.torque_unit)

    @property
    def losses(self) -> FloatArray:
        """Work lost over each piece in each of `dynamics.law.LOSSES` [J], shape (7, n)."""
        found = np.zeros((len(LOSSES), self._firsts.size))
        found[: len(LOST) - 1] = self._work[:, :-1].T
        return found

    @property
    def load_work(self) -> FloatArray:
        """Work that the load takes over each piece [J]."""
        return np.asarray(self._work[:, -1])

    @cached_property
    def elastic(self) -> float:
        """Energy in the follower's spring and weight at the end, less that at the start [J]."""
        energy, law = as_python(stored), prepared(self.escapement).law
        change = energy(law, self._last[1]) - energy(law, self._steps["y"][0, 1])
        return float(change * self.escapement.torque_unit)

    def states_at(self, pieces: np.ndarray, t: FloatArray) -> State:
        """States at times [s] within pieces of these indices."""
        owners, times = pieces.reshape(-1), t.reshape(-1) / self.escapement.time_unit
        firsts = np.append(self._firsts, self._steps.size)
        which = np.searchsorted(self._steps["time"], times, side="right") - 1
        which = np.clip(which, firsts[owners], firsts[owners + 1] - 1)
        table = self._traced(which, np.maximum(times - self._steps["time"][which], 0.0))
        engagement = self._steps["engagement"][which]
        table[0] += engagement * self.escapement.mechanism.cell_angle
        table[1] += self.begins["steps"][engagement] * prepared(self.escapement).pitches[1]
        return _state(self.escapement, t, table)


def _length(escapement: Escapement) -> float:
    """Unit of length [m]; NaN without one."""
    return float(escapement.mechanism.crank_radius or np.nan)


def _state(escapement: Escapement, t: FloatArray, table: FloatArray) -> State:
    """States in SI from a table in natural units."""
    clock, torque = escapement.time_unit, escapement.torque_unit
    rows = table.reshape(STATE + MORE, *t.shape)
    driver, follower, moment, force = rows[STATE : STATE + 4]
    sized = escapement.mechanism.crank_radius is not None
    push = force * torque / _length(escapement) if sized else None
    reaction = push * np.hypot(1.0, escapement.scene.mu_plus) if push is not None else None
    powers = dict.fromkeys(LOSSES, np.zeros(t.shape))
    lost = rows[STATE + 4 : STATE + 4 + len(LOST) - 1] * (torque / clock)
    return State(
        t=t,
        theta=rows[0],
        theta_dot=rows[2] / clock,
        theta_ddot=driver / clock**2,
        phi=rows[1],
        phi_dot=rows[3] / clock,
        phi_ddot=follower / clock**2,
        contact_moment=moment * torque,
        contact_force=push,
        driver_bearing_reaction=reaction,
        follower_bearing_reaction=reaction,
        power_lost=powers | dict(zip(LOST[:-1], lost, strict=True)),
    )
