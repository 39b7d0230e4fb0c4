"""A motion with clearance in pieces: contact with either wall, flights and dwells."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from escapement.dynamics.contact_state import STATE_ROWS, ContactState
from escapement.dynamics.event_rows import NotedTrajectory
from escapement.dynamics.motion import State
from escapement.dynamics.state_from_table import state_from
from escapement.engines.contact.rigid.march import TIME, march
from escapement.engines.contact.rigid.notes import ROW
from escapement.engines.contact.rigid.trace import LOST, trace
from escapement.engines.contact.rigid.walls import Clearance
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement, once_per_escapement
from escapement.model.scene import packed

_ROOM = 24  # rows that an engagement takes, in most cases
# Ctrl-C takes effect between calls of the kernel for so many engagements
_AT_ONCE = 4096
_KEPT = 512
NO_ROWS, NO_NUMBERS = np.empty(0, ROW), np.empty(0, np.int64)


@once_per_escapement
def prepared(escapement: Escapement) -> tuple[FloatArray, tuple[float, ...], float]:
    """Scene and clearance as `march.march` takes them, and the follower angle at the pin entry.

    They are kept on the escapement, so that its next call does not compute them again.
    """
    wheel: Any = escapement.mechanism
    clearance = Clearance(
        half_clearance=float(escapement.joint.half_clearance),
        restitution=float(escapement.joint.restitution),
        step=float(wheel.follower_step),
    )
    entry = float(wheel.follower_angle(np.array(wheel.breaks[:1]))[0])
    return packed(escapement.scene), tuple(clearance), entry


@dataclass
class RigidTrajectory(NotedTrajectory):
    """The states at handoffs, from which everything else is computed when it is read.

    begun : shape (n + 1, 5), states at the start and at handoffs, see `march.STATE`; each starts
        an engagement, and the last engagement may be incomplete.
    end_time : time at which the motion ends [s].
    numbers : its engagements, ascending; all of them by default.
    """

    escapement: Escapement
    rtol: float
    begun: FloatArray
    end_time: float
    numbers: Any = None

    @cached_property
    def _numbers(self) -> np.ndarray:
        if self.numbers is not None:
            return np.asarray(self.numbers)
        # a motion that ends at a handoff has no part of the next engagement
        last = self.end_time / self.escapement.time_unit * (1.0 - 1e-14)
        return np.arange(max(int(np.searchsorted(self.begun[:, TIME], last)), 1))

    def around(self, t: FloatArray) -> "RigidTrajectory":
        """A trajectory of only the engagements that contain these times [s]."""
        # a short motion is kept as a whole, so that its next states are there at once
        if self._numbers.size <= _KEPT:
            return self
        starts = self.begun[self._numbers, TIME] * self.escapement.time_unit
        held = np.unique(np.searchsorted(starts, t, side="right") - 1)
        return replace(self, numbers=held) if held.size else self

    @cached_property
    def _inputs(self) -> tuple[Any, ...]:
        return *prepared(self.escapement)[:2], self.rtol

    @cached_property
    def _happened(self) -> tuple[np.ndarray, np.ndarray]:
        """All rows of the motion, and the engagement of each."""
        numbers = self._numbers
        parts = [numbers[k : k + _AT_ONCE] for k in range(0, numbers.size, _AT_ONCE)]
        tables = [self._happened_in(part) for part in parts]
        rows, engagement = (np.concatenate(columns) for columns in zip(*tables, strict=True))
        return rows, engagement

    def _happened_in(self, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same for some engagements."""
        # whether a handoff is an extremum depends on the engagement before it
        whole = wanted.size == wanted[-1] + 1
        numbers = wanted if whole else np.union1d(np.maximum(wanted - 1, 0), wanted)
        begun = self.begun[numbers]
        used, size = np.zeros(2, np.int64), _ROOM * numbers.size
        while True:
            rows, engagement = np.zeros(size, ROW), np.zeros(size, np.int64)
            used[:] = 0
            march(*self._inputs, np.inf, 0, begun, numbers, rows, engagement, used)
            if used[0] <= size:
                break
            size = int(used[0])
        rows, engagement = rows[: used[0]], engagement[: used[0]]
        end = self.end_time / self.escapement.time_unit
        # no rounding may put an event into the next engagement
        rows["time"] = np.minimum(rows["time"], np.append(self.begun[1:, TIME], np.inf)[engagement])
        # the rounding of the end must not leave out what happens there
        kept = rows["time"] <= end * (1.0 + 1e-15)
        if not whole:
            kept &= np.isin(engagement, wanted)
        return rows[kept], engagement[kept]

    def _traced(
        self, which: np.ndarray, firsts: np.ndarray, times: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Natural states at times since the start of some pieces, and the work lost in these."""
        pieces, engagement = self._pieces
        end = self.end_time / self.escapement.time_unit
        # the last piece of an engagement lasts until the next engagement
        after = np.append(self.begun[1:, TIME], end)[engagement]
        follows = np.append(np.diff(engagement) == 0, False)
        until = np.where(follows, np.append(pieces["time"][1:], end), np.minimum(after, end))
        lengths = (until - pieces["time"])[which]
        states, lost = np.empty((STATE_ROWS, times.size)), np.zeros((which.size, LOST))
        chosen = pieces[which], engagement[which], lengths
        trace(*self._inputs, *chosen, firsts, times, states, lost)
        return states, lost

    @cached_property
    def _work(self) -> FloatArray:
        every, none = np.arange(self.start.size), np.zeros(self.start.size + 1, np.int64)
        return np.asarray(self._traced(every, none, np.empty(0))[1] * self.escapement.torque_unit)

    @property
    def losses(self) -> FloatArray:
        """Work lost over each piece in each of `dynamics.law.LOSSES` [J], shape (7, n)."""
        return np.asarray(self._work[:, :-1].T)

    @property
    def load_work(self) -> FloatArray:
        """Work that the load takes over each piece [J]."""
        return np.asarray(self._work[:, -1])

    def states_at(self, pieces: np.ndarray, t: FloatArray) -> State:
        """State at times [s] within pieces of these indices."""
        owners, times = pieces.reshape(-1), t.reshape(-1)
        order = np.lexsort((times, owners))
        rows, engagement = self._pieces
        since = np.maximum(times / self.escapement.time_unit - rows["time"][owners], 0.0)[order]
        which, firsts = np.unique(owners[order], return_index=True)
        table = np.empty((STATE_ROWS, times.size))
        table[:, order] = self._traced(which, np.append(firsts, times.size), since)[0]
        mechanism = self.escapement.mechanism
        states = ContactState(*table)
        states.theta[:] += engagement[owners] * mechanism.cell_angle
        states.phi[:] += engagement[owners] * mechanism.follower_step
        return state_from(self.escapement, t, table)
