"""A motion with compliant contact, from the ends of its steps: pieces of contact and flight."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from escapement.dynamics.compliance import IMPULSE, LOAD, LOCKED, LOST, WALLS
from escapement.dynamics.contact_state import STATE_ROWS, ContactState
from escapement.dynamics.motion import State
from escapement.dynamics.state_from_table import state_from
from escapement.dynamics.trajectory import Events, Extrema, Impacts, Trajectory
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.numerics.gauss import POINTS, WEIGHTS
from escapement.numerics.search import peaks, zeros

SLIDE, PRESS, HELD = range(STATE_ROWS, STATE_ROWS + 3)
"""Rows behind those of a `ContactState`: sliding speed, speed of penetration, and energy stored in
the walls."""
_SHARES = np.linspace(0.0, 1.0, 5)
"""Points in each step between which extrema and changes of sign are looked for."""
_RATE, _TURN, _MOMENT, _FORCE = _PEAKS = [
    ContactState._fields.index(name)
    for name in ("theta_ddot", "phi_ddot", "contact_moment", "contact_force")
]
"""Rows of both accelerations, moment and force, whose greatest magnitudes are figures of merit."""
_KEPT = [*_PEAKS, SLIDE, PRESS, HELD]
_CANDIDATES = 4
"""Number of steps that are searched for a greatest magnitude; two of them may share an end."""


@dataclass(frozen=True)
class Steps:
    """The states at the ends of all steps of a march, in natural units.

    table : array of records with the time, engagement, mode, speed of the last touch, and state at
        the end of each step. Where the law changes there are two with the same time.
    escapement : the mechanism that moves.
    tabulate : fills rows of a `ContactState`, and those behind it, at times between the records of
        these indices and their next ones.
    """

    table: np.ndarray
    escapement: Escapement
    tabulate: Callable[[np.ndarray, FloatArray, FloatArray], None]

    def at(self, which: np.ndarray, times: FloatArray) -> FloatArray:
        """What `tabulate` fills in, at times between records and their next ones."""
        found = np.empty((HELD + 1, times.size))
        self.tabulate(which, times, found)
        return found

    @cached_property
    def samples(self) -> dict[int, FloatArray]:
        """Some rows of `at`, each of shape (steps, shares), with one-sided values at both ends."""
        which, time = self.steps, self.table["time"]
        low, high = time[which], time[which + 1]
        found = np.empty((len(_KEPT), which.size, _SHARES.size))
        for k, share in enumerate(_SHARES):
            found[:, :, k] = self.at(which, low + share * (high - low))[_KEPT]
        return dict(zip(_KEPT, found, strict=True))

    @cached_property
    def steps(self) -> np.ndarray:
        """Rows at which a step begins: the next one is later."""
        return np.flatnonzero(np.diff(self.table["time"]) > 0.0)

    @cached_property
    def pieces(self) -> tuple[np.ndarray, np.ndarray]:
        """First and last row of each piece of contact, flight or dwell in an engagement."""
        rows, first = self.table, self.steps
        changes = np.diff(rows["engagement"][first]) != 0
        new = np.append(True, changes | (np.diff(rows["mode"][first]) != 0))
        starts = np.flatnonzero(new)
        return first[starts], first[np.append(starts[1:], first.size) - 1] + 1

    def roots(self, column: int) -> tuple[np.ndarray, FloatArray, np.ndarray]:
        """Changes of sign of a row of `samples`: the steps, the times, and whether it falls."""
        values = self.samples[column]
        step, index = np.nonzero(values[:, :-1] * values[:, 1:] < 0.0)
        which, before = self.steps[step], values[step, index]
        start, end = self.table["time"][which], self.table["time"][which + 1]
        low, high = (start + _SHARES[index + k] * (end - start) for k in (0, 1))
        times = zeros(lambda times: self.at(which, times)[column], low, high)
        return which, times, before > 0.0

    def greatest(self, column: int) -> tuple[float, float]:
        """Greatest magnitude of a row of `samples`, refined in the best steps, and its time."""
        values = np.abs(self.samples[column])
        which = np.argsort(values.max(axis=1))[-_CANDIDATES:]
        rows = self.steps[which][:, None]
        low, high = self.table["time"][rows], self.table["time"][rows + 1]

        def size_at(times: FloatArray) -> FloatArray:
            owners = np.broadcast_to(rows, times.shape).reshape(-1)
            found = self.at(owners, times.reshape(-1))[column]
            return np.asarray(np.abs(found).reshape(times.shape))

        found, when = peaks(size_at, low + _SHARES * (high - low), values[which])
        best = int(found.argmax())
        return float(found[best]), float(when[best])


class CompliantTrajectory(Trajectory):
    """The `Trajectory` of a motion with compliant contact."""

    def __init__(self, rows: Steps) -> None:
        self.rows, self._clock = rows, rows.escapement.time_unit
        first, last = rows.pieces
        table, torque = rows.table, rows.escapement.torque_unit
        self.start: FloatArray = table["time"][first] * self._clock
        self.engagement: np.ndarray = table["engagement"][first]
        mode = table["mode"][first]
        self.sign: FloatArray = np.where(mode == LOCKED, 0.0, mode)
        gained = (table["state"][last] - table["state"][first]).T
        self.losses: FloatArray = gained[LOST:WALLS] * torque
        self.load_work: FloatArray = gained[LOAD] * torque

    def states_at(self, pieces: Any, t: FloatArray) -> State:
        """The whole state at times within pieces [s]."""
        first, last = self.rows.pieces
        owners, times = np.asarray(pieces).reshape(-1), t.reshape(-1) / self._clock
        time = self.rows.table["time"]
        which = np.clip(
            np.searchsorted(time, times, side="right") - 1, first[owners], last[owners] - 1
        )
        times = np.clip(times, time[which], time[which + 1])
        table = self.rows.at(which, times)[:STATE_ROWS]
        return state_from(self.rows.escapement, t, table)

    def _events(
        self, which: np.ndarray, time: FloatArray
    ) -> tuple[np.ndarray, FloatArray, FloatArray, FloatArray]:
        """Columns of `Events` at times between rows."""
        theta, speed = self.rows.at(which, time)[:2]
        engagement = self.rows.table["engagement"][which]
        return engagement, time * self._clock, theta, speed / self._clock

    @cached_property
    def reversals(self) -> Events:
        """Instants at which the pin leaves a wall and touches the other one next."""
        last = self.rows.pieces[1]
        held = np.flatnonzero(self.sign)
        reversed_at = held[:-1][self.sign[held[1:]] * self.sign[held[:-1]] < 0.0]
        which = last[reversed_at] - 1
        return Events(*self._events(which, self.rows.table["time"][which + 1]))

    @cached_property
    def extrema(self) -> Extrema:
        """Extrema of the driver speed, including those where a contact begins or ends."""
        which, time, top = self.rows.roots(_RATE)
        before, behind = self.rows.samples[_RATE][:, 0], self.rows.samples[_RATE][:, -1]
        corners = np.flatnonzero(behind[:-1] * before[1:] < 0.0)
        edge = self.rows.steps[corners + 1]
        which, time = np.append(which, edge), np.append(time, self.rows.table["time"][edge])
        top = np.append(top, behind[corners] > 0.0)
        order = np.argsort(time, kind="stable")
        events = self._events(which[order], time[order])
        return Extrema(*events, top[order])

    @cached_property
    def slide_changes(self) -> Events:
        """Instants at which the contact point changes its sense of sliding on a wall."""
        which, time, _falls = self.rows.roots(SLIDE)
        held = np.abs(self.rows.table["mode"][which]) == 1.0
        return Events(*self._events(which[held], time[held]))

    @cached_property
    def impacts(self) -> Impacts:
        """Every contact with a wall, from beginning to end, and every stop by the lock.

        energy : work lost in the wall during the contact. impulse : impulse of compression, up to
        the deepest penetration, or to the end of the contact if that is earlier.
        """
        rows, escapement = self.rows, self.rows.escapement
        first, table = rows.pieces[0], rows.table
        mode = table["mode"][first]
        # a contact with a wall may last over a handoff
        at = first[(mode != np.append(0.0, mode[:-1])) & (mode != 0.0)]
        locked = table["mode"][at] == LOCKED
        walls = table["state"][:, WALLS]
        taken = np.append(walls[at - locked], walls[-1])
        columns = self._events(at, table["time"][at])
        length: float = escapement.mechanism.crank_radius
        return Impacts(
            *columns,
            np.where(locked, 0.0, table["mode"][at]),
            columns[3],
            np.where(locked, 0.0, table["touch"][at]) * length / self._clock,
            self._compressions(at) * (escapement.torque_unit * self._clock / length),
            np.diff(taken) * escapement.torque_unit,
        )

    def _compressions(self, at: np.ndarray) -> FloatArray:
        """Impulse of the wall from each of these rows to the deepest penetration."""
        rows, table = self.rows, self.rows.table
        mode, impulse = table["mode"], table["state"][:, IMPULSE]
        which, time, falls = rows.roots(PRESS)
        deepest = falls & (np.abs(mode[which]) == 1.0)
        which, time = which[deepest], time[deepest]
        start = table["time"][which]
        times = start + 0.5 * (POINTS[:, None] + 1.0) * (time - start)
        forces = np.abs(rows.at(np.tile(which, POINTS.size), times.reshape(-1))[_FORCE])
        part = 0.5 * (time - start) * (WEIGHTS @ forces.reshape(times.shape))
        # a contact may end before its deepest penetration
        first = rows.pieces[0]
        ends = np.append(first[np.abs(mode[first]) != 1.0], mode.size - 1)
        indices = np.append(which, ends)
        order = np.argsort(indices, kind="stable")
        reached = np.append(impulse[which] + part, impulse[ends])[order]
        found: FloatArray = reached[np.searchsorted(indices[order], at)] - impulse[at]
        pressed = rows.samples[PRESS][np.searchsorted(rows.steps, at), 0] >= 0.0
        return np.where(pressed, found, 0.0)

    @property
    def elastic(self) -> float:
        """Energy stored in the walls at the end, less that at the start [J]."""
        held = self.rows.samples[HELD]
        return float(held[-1, -1] - held[0, 0]) * self.rows.escapement.torque_unit

    @cached_property
    def hardest(self) -> tuple[float, float]:
        """Greatest contact force [N], and when it acts [s]."""
        force, time = self.rows.greatest(_FORCE)
        escapement: Any = self.rows.escapement
        return (
            force * escapement.torque_unit / escapement.mechanism.crank_radius,
            time * self._clock,
        )

    @cached_property
    def peaks(self) -> FloatArray:
        """Greatest magnitudes in the order of `figures_of_merit.find_peaks`, shape (4, 1)."""
        torque = self.rows.escapement.torque_unit
        units: FloatArray = np.array([self._clock**-2.0, self._clock**-2.0, torque, torque])
        return (np.array([self.rows.greatest(k)[0] for k in _PEAKS]) * units)[:, None]
