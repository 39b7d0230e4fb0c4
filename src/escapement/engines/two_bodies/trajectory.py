"""A motion of two bodies in pieces: flights, and contacts of one pair of features each."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from escapement.dynamics.codes import PIECES, Event
from escapement.dynamics.contact_state import STATE_ROWS, ContactState
from escapement.dynamics.event_rows import NotedTrajectory
from escapement.dynamics.law import LOSSES
from escapement.dynamics.motion import State
from escapement.dynamics.state_from_table import state_from
from escapement.dynamics.trajectory import Extrema
from escapement.engines.two_bodies.law import MOTION, STATE, energy
from escapement.engines.two_bodies.march import ROW, STEP, STEPS, TIME, march
from escapement.engines.two_bodies.scene import prepared
from escapement.engines.two_bodies.trace import trace
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.numerics.jit import as_python

_ROOM = 128  # rows that an engagement takes, in most cases
_SLIGHT = 1e-12  # share of the speed below which two speeds are equal


@dataclass
class TwoBodyTrajectory(NotedTrajectory):
    """The states at handoffs, from which everything else is computed when it is read.

    begins : shape (n + 1, BEGIN), at the start and at handoffs, see `march.BEGIN`.
    end_time : time at which the motion ends [s].
    """

    escapement: Escapement
    begins: FloatArray
    end_time: float

    @property
    def _end(self) -> float:
        return self.end_time / self.escapement.time_unit

    @cached_property
    def _happened(self) -> tuple[np.ndarray, np.ndarray]:
        """All rows of the motion, and the engagement of each."""
        scene, used = prepared(self.escapement), np.zeros(2, np.int64)
        # a motion that ends at a handoff has no part of the next engagement
        count = max(int(np.searchsorted(self.begins[:, TIME], self._end * (1.0 - 1e-14))), 1)
        begins, size = np.resize(self.begins, (count + 1, self.begins.shape[1])), _ROOM * count
        end = self._end * (1.0 + 1e-15)
        bodies = scene.law, scene.pairs, scene.joints, scene.pitches
        while True:
            rows, used[:] = np.zeros(size, ROW), 0
            march(*bodies, end, 0, begins, rows, used)
            if used[0] <= size:
                break
            size = int(used[0])
        rows = rows[: used[0]]
        rows = rows[rows["time"] <= end]
        return rows, rows["engagement"]

    @cached_property
    def _steps(self) -> np.ndarray:
        """Rows that begin a step, those of pieces among them."""
        rows = self._happened[0]
        return np.asarray(rows[np.isin(rows["kind"], [STEP, *PIECES])])

    @cached_property
    def _firsts(self) -> np.ndarray:
        """The step with which each piece begins."""
        return np.flatnonzero(self._steps["kind"] != STEP)

    @cached_property
    def extrema(self) -> Extrema:
        """Every extremum of the driver speed, which is monotonic within each step."""
        rows = self._happened[0]
        impact = np.flatnonzero(rows["kind"] == Event.IMPACT)
        before = rows[impact].copy()
        before["speed"] = before["before"]
        every = np.insert(rows, impact, before)
        slight = _SLIGHT * np.abs(every["speed"]).max(initial=0.0)
        changes = np.flatnonzero(np.abs(np.diff(every["speed"])) > slight)
        rising = np.diff(every["speed"])[changes] > 0.0
        turns = np.flatnonzero(rising[1:] != rising[:-1]) + 1
        chosen = every[changes[turns]]
        columns = self.columns(chosen, chosen["engagement"])
        return Extrema(**columns, maximum=~rising[turns])

    def _traced(self, which: np.ndarray, since: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Natural states at times since steps, and the work lost up to there."""
        scene, table = prepared(self.escapement), np.empty((STATE_ROWS, which.size))
        lost = np.empty((STATE - MOTION, which.size))
        steps = self._steps, which, since
        trace(scene.law, scene.pairs, scene.pitches[0], *steps, table, lost)
        return table, lost

    @cached_property
    def _last(self) -> tuple[FloatArray, FloatArray]:
        """The state at the end, and the work lost up to there."""
        last = self._steps.size - 1
        since = max(self._end - self._steps["time"][last], 0.0)
        return self._traced(np.array([last]), np.array([since]))

    @cached_property
    def _work(self) -> FloatArray:
        """Work lost over each piece [J], that in the load last."""
        lost = np.append(self._steps["lost"][self._firsts].T, self._last[1], axis=1)
        return np.asarray(np.diff(lost) * self.escapement.torque_unit)

    @property
    def losses(self) -> FloatArray:
        """Work lost over each piece in each of `dynamics.law.LOSSES` [J], shape (7, n)."""
        found = np.zeros((len(LOSSES), self._firsts.size))
        found[: STATE - MOTION - 1] = self._work[:-1]
        return found

    @property
    def load_work(self) -> FloatArray:
        """Work that the load takes over each piece [J]."""
        return np.asarray(self._work[-1])

    @cached_property
    def elastic(self) -> float:
        """Energy in the follower's spring and weight at the end, less that at the start [J]."""
        law, turns = prepared(self.escapement).law, ContactState(*self._last[0])
        ends = self._steps["phi"][0], turns.phi[0]
        first, last = (as_python(energy)(law, (0.0, phi, 0.0, 0.0))[1] for phi in ends)
        return float((last - first) * self.escapement.torque_unit)

    def states_at(self, pieces: np.ndarray, t: FloatArray) -> State:
        """States at times [s] within pieces of these indices."""
        owners, times = pieces.reshape(-1), t.reshape(-1) / self.escapement.time_unit
        firsts = np.append(self._firsts, self._steps.size)
        which = np.searchsorted(self._steps["time"], times, side="right") - 1
        which = np.clip(which, firsts[owners], firsts[owners + 1] - 1)
        table = self._traced(which, np.maximum(times - self._steps["time"][which], 0.0))[0]
        states, engagement = ContactState(*table), self._steps["engagement"][which]
        states.theta[:] += engagement * self.escapement.mechanism.cell_angle
        states.phi[:] += self.begins[engagement, STEPS] * prepared(self.escapement).pitches[1]
        return state_from(self.escapement, t, table)
