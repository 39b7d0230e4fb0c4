"""A motion between walls that yield, as pieces of contact and flight in SI."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from escapement.engines.contact.compliant.law import IMPULSE, LOAD, LOST, WALLS
from escapement.engines.contact.compliant.march import (
    CELL,
    FIRST,
    MODE,
    SERIES,
    TIME,
    TOUCH,
)
from escapement.engines.contact.compliant.rows import TABLE, tabulate
from escapement.engines.contact.compliant.slot import LOCKED
from escapement.engines.contact.state import COLUMNS, OWN, every_loss, state_from
from escapement.mechanism import FloatArray
from escapement.model import Escapement
from escapement.motion import State
from escapement.scene import Joint
from escapement.trajectory import Events, Extrema, Held, Impacts

_HALVINGS = 50
_SHARES = 9
_RATE, _SLIDE, _PRESS, _HELD = 2, 13, 14, 15
"""Rows of a table: the driver's acceleration, sliding speed, speed of penetration,
and energy that the walls hold."""


@dataclass(frozen=True)
class Rows:
    """The states at the ends of all steps of a march, in natural units.

    table : shape (n, march.ROW). escapement, joint : whose they are.
    """

    table: FloatArray
    escapement: Escapement
    joint: Joint

    def at(self, which: np.ndarray, times: FloatArray) -> FloatArray:
        """What `rows.tabulate` gives at times between rows and their next ones."""
        found = np.empty((TABLE, times.size))
        step = self.escapement.mechanism.follower_step
        tabulate(self.table, which, times, self.escapement.scene, self.joint, step, found)
        return found

    @cached_property
    def ends(self) -> tuple[FloatArray, FloatArray]:
        """What `at` gives at the start and at the end of each step, one-sided."""
        which, time = self.steps, self.table[:, TIME]
        return self.at(which, time[which]), self.at(which, time[which + 1])

    @cached_property
    def steps(self) -> np.ndarray:
        """Rows at which a step begins: the next one is later."""
        return np.flatnonzero(np.diff(self.table[:, TIME]) > 0.0)

    @cached_property
    def pieces(self) -> tuple[np.ndarray, np.ndarray]:
        """First and last row of each piece of contact, flight or dwell in an engagement."""
        rows, first = self.table, self.steps
        kind = rows[first][:, [CELL, MODE]]
        new = np.append(True, (np.diff(kind, axis=0) != 0.0).any(axis=1))
        starts = np.flatnonzero(new)
        return first[starts], first[np.append(starts[1:], first.size) - 1] + 1

    def roots(self, column: int, wanted: np.ndarray) -> tuple[np.ndarray, FloatArray]:
        """Steps within which a column of the table changes its sign, and when."""
        before, behind = (end[column] for end in self.ends)
        found = np.flatnonzero((before * behind < 0.0) & wanted)
        which = self.steps[found]
        low, high = (self.table[which + k, TIME].copy() for k in (0, 1))
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            same = self.at(which, middle)[column] * before[found] > 0.0
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return which, high


class CompliantTrajectory(Held):
    """See `escapement.trajectory.Trajectory`, and there what a free follower adds."""

    def __init__(self, rows: Rows) -> None:
        self.rows, self._clock = rows, rows.escapement.time_unit
        first, last = rows.pieces
        table, torque = rows.table, rows.escapement.torque_unit
        self.start: FloatArray = table[first, TIME] * self._clock
        self.engagement: np.ndarray = table[first, CELL].astype(int)
        mode = table[first, MODE]
        self.sign: FloatArray = np.where(mode == LOCKED, 0.0, mode)
        gained = (table[last, FIRST:SERIES] - table[first, FIRST:SERIES]).T
        self.losses: FloatArray = every_loss(gained[LOST : LOST + len(OWN)] * torque)
        self.load_work: FloatArray = gained[LOAD] * torque

    def states_at(self, pieces: Any, t: FloatArray) -> State:
        """The whole state at times within pieces [s]."""
        first, last = self.rows.pieces
        owners, times = np.asarray(pieces).reshape(-1), t.reshape(-1) / self._clock
        time = self.rows.table[:, TIME]
        which = np.clip(
            np.searchsorted(time, times, side="right") - 1, first[owners], last[owners] - 1
        )
        times = np.clip(times, time[which], time[which + 1])
        table = self.rows.at(which, times)[: len(COLUMNS) + len(OWN)]
        return state_from(self.rows.escapement, t, table)

    def _events(
        self, which: np.ndarray, time: FloatArray
    ) -> tuple[np.ndarray, FloatArray, FloatArray, FloatArray]:
        """Columns of `Events` at times between rows."""
        theta, speed = self.rows.at(which, time)[:2]
        engagement = self.rows.table[which, CELL].astype(int)
        return engagement, time * self._clock, theta, speed / self._clock

    @cached_property
    def reversals(self) -> Events:
        """Where the pin lets go of a wall and touches the other one next."""
        last = self.rows.pieces[1]
        held = np.flatnonzero(self.sign)
        turned = held[:-1][self.sign[held[1:]] * self.sign[held[:-1]] < 0.0]
        which = last[turned] - 1
        return Events(*self._events(which, self.rows.table[which + 1, TIME]))

    @cached_property
    def extrema(self) -> Extrema:
        """Extrema of the driver speed, with those at corners where a wall is touched."""
        before, behind = (end[_RATE] for end in self.rows.ends)
        which, time = self.rows.roots(_RATE, np.full(before.size, True))
        top = before[np.searchsorted(self.rows.steps, which)] > 0.0
        corners = np.flatnonzero(behind[:-1] * before[1:] < 0.0)
        edge = self.rows.steps[corners + 1]
        which, time = np.append(which, edge), np.append(time, self.rows.table[edge, TIME])
        top = np.append(top, behind[corners] > 0.0)
        order = np.argsort(time, kind="stable")
        events = self._events(which[order], time[order])
        return Extrema(*events, top[order])

    @cached_property
    def slide_changes(self) -> Events:
        """Where the contact point changes its sense of sliding on a wall."""
        held = np.abs(self.rows.table[self.rows.steps, MODE]) == 1.0
        return Events(*self._events(*self.rows.roots(_SLIDE, held)))

    @cached_property
    def impacts(self) -> Impacts:
        """Every contact with a wall, from touch to letting go, and every stop by the lock.

        energy : what the wall takes while the contact lasts. impulse : of compression, up to
        the deepest penetration, or the end of the contact where that comes before.
        """
        rows, own = self.rows, self.rows.escapement
        first, table = rows.pieces[0], rows.table
        mode = table[first, MODE]
        # the contact with a wall goes on over a handoff
        at = first[(mode != np.append(0.0, mode[:-1])) & (mode != 0.0)]
        locked = table[at, MODE] == LOCKED
        taken = np.append(table[at - locked, FIRST + WALLS], table[-1, FIRST + WALLS])
        columns = self._events(at, table[at, TIME])
        length: float = own.mechanism.crank_radius  # type: ignore[attr-defined]
        return Impacts(
            *columns,
            np.where(locked, 0.0, table[at, MODE]),
            columns[3],
            np.where(locked, 0.0, table[at, TOUCH]) * length / self._clock,
            self._compressions(at) * (own.torque_unit * self._clock / length),
            np.diff(taken) * own.torque_unit,
        )

    def _compressions(self, at: np.ndarray) -> FloatArray:
        """Impulse of the wall from each of these rows to the deepest penetration."""
        rows, steps = self.rows, self.rows.steps
        press, mode = rows.ends[1][_PRESS], rows.table[steps, MODE]
        turns = np.flatnonzero((press <= 0.0) | (mode == 0.0) | (mode == LOCKED))
        here = np.searchsorted(steps, at)
        place = np.searchsorted(turns, here)
        ends = steps[np.append(turns, steps.size - 1)[place]]
        ends = np.where(rows.table[ends, MODE] == 0.0, ends, ends + 1)
        impulse = rows.table[:, FIRST + IMPULSE]
        found: FloatArray = np.maximum(impulse[ends] - impulse[at], 0.0)
        return found

    @property
    def elastic(self) -> float:
        """Energy that the walls hold at the end, less that at the start [J]."""
        before, behind = (end[_HELD] for end in self.rows.ends)
        return float(behind[-1] - before[0]) * self.rows.escapement.torque_unit

    @cached_property
    def peaks(self) -> FloatArray:
        """Greatest magnitudes, as `metrics.find_peaks` asks for them; one column."""
        rows, time = self.rows, self.rows.table[:, TIME]
        torque, found = rows.escapement.torque_unit, []
        for quantity in (2, 5, 6, 7):
            which, low, high = rows.steps, time[rows.steps], time[rows.steps + 1]
            for _ in range(3):
                share = np.linspace(0.0, 1.0, _SHARES)
                times = low[:, None] + share * (high - low)[:, None]
                values = np.abs(rows.at(np.repeat(which, _SHARES), times.reshape(-1))[quantity])
                best = int(values.argmax())
                step, place = divmod(best, _SHARES)
                which = which[step : step + 1]
                ends = np.clip([place - 1, place + 1], 0, _SHARES - 1)
                low, high = times[step, ends[:1]], times[step, ends[1:]]
            found.append(values.max())
        units = (self._clock**-2.0, self._clock**-2.0, torque, torque)
        tops: FloatArray = np.array(found)[:, None] * np.array(units)[:, None]
        return tops
