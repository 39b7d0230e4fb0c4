"""The pieces and events of a motion, computed from its handoffs when they are asked for.

Each engagement is computed separately from the w at its start, so that a few states of a long
motion cost only a few engagements.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from escapement.dynamics.codes import Event
from escapement.dynamics.figure_table import PEAKS
from escapement.dynamics.law import LOSSES
from escapement.dynamics.trajectory import Events, Extrema, Trajectory
from escapement.engines.energy.calls import prepared, scene_and_pattern
from escapement.engines.energy.pieces import MOTION_EVENT, events_of, follow, states_of
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

# Events are computed for this many engagements in one call of a kernel; Ctrl-C takes effect
# between two calls.
_AT_ONCE = 1 << 15
# The engagements of a part of a long motion; the events of a part are kept.
_PART = 512
# The w at the end of an engagement may differ from that of its handoff by this share.
_FAR = 1e-6
_STOPS = [Event.ENTRY, Event.REVERSAL, Event.EXIT, Event.BREAK]


class Pieces(NamedTuple):
    """Pieces of a motion: arrays with a number, and `rows` with a row, for each.

    start : time [s]. engagement : its number.
    rows : as `pieces.states_of` takes them, in natural units.
    """

    start: FloatArray
    engagement: np.ndarray
    rows: FloatArray


@dataclass
class EnergyTrajectory(Trajectory):
    """Handoffs of a motion, and the pieces and events that follow from them.

    initial_speed : driver speed at the first entry [rad/s].
    times, speeds : of the handoffs [s, rad/s]; each of the first `turns` starts an engagement.
    end_time : time at which the motion ends [s].
    some : its engagements, ascending; all of them by default.
    """

    escapement: Escapement
    rtol: float
    initial_speed: float
    times: FloatArray
    speeds: FloatArray
    turns: int
    end_time: float
    some: Any = None

    @cached_property
    def engagements(self) -> np.ndarray:
        """Its engagements, ascending."""
        return np.arange(self.turns + 1) if self.some is None else self.some

    def around(self, t: FloatArray) -> "EnergyTrajectory":
        """A trajectory of only the engagements that contain these times [s]."""
        if self.engagements.size <= _PART:
            return self
        held = np.searchsorted(self.times[: self.turns], t, side="right")
        return replace(self, some=np.unique(held))

    def parts(self) -> "Iterator[tuple[EnergyTrajectory, slice]]":
        """Trajectories of some engagements each, one after the other, and which these are."""
        if self.engagements.size <= _PART:
            yield self, slice(None)
            return
        for first in range(0, self.engagements.size, _PART):
            some = slice(first, first + _PART)
            yield replace(self, some=self.engagements[some]), some

    def _entries(self, numbers: np.ndarray) -> tuple[FloatArray, FloatArray]:
        """Times [s] and speeds [rad/s] at the starts of engagements."""
        before, first = np.maximum(numbers - 1, 0), numbers == 0
        times = np.where(first, 0.0, self.times[before])
        return times, np.where(first, self.initial_speed, self.speeds[before])

    @cached_property
    def _events(self) -> np.ndarray:
        """Every event, an array of `pieces.MOTION_EVENT` whose times are those of the motion [s].

        Angles and w are in natural units.
        """
        # a handoff is an extremum if theta_ddot changes its sign there, which needs the sign
        # before it
        numbers = wanted = self.engagements
        if wanted.size <= self.turns:
            numbers = np.unique(np.concatenate([wanted - 1, wanted]))
            numbers = numbers[numbers >= 0]
        tables = [
            self._events_in(numbers[first : first + _AT_ONCE])
            for first in range(0, numbers.size, _AT_ONCE)
        ]
        found = np.concatenate(tables)
        return found if numbers.size == wanted.size else found[np.isin(found["engagement"], wanted)]

    def _events_in(self, numbers: np.ndarray) -> np.ndarray:
        """The events of some engagements."""
        escapement, clock = self.escapement, self.escapement.time_unit
        start, speed = self._entries(numbers)
        driver_angle = np.broadcast_to(
            escapement.driver_angle_before(numbers), numbers.shape
        ).astype(float)
        squares = (speed * clock) ** 2
        given = prepared(escapement)
        table, reached = events_of(*given, numbers, driver_angle, squares, self.rtol)
        inner = numbers < self.turns
        given = (self.speeds[numbers[inner]] * clock) ** 2
        allowed = _FAR * (given + squares[inner]) + _FAR**2
        lost = numbers[inner][~(np.abs(reached[inner] - given) <= allowed)]
        # an engagement whose events lead to another end than its handoff has no states
        table["w"][np.isin(table["engagement"], lost)] = np.nan
        owner = np.searchsorted(numbers, table["engagement"])
        time, after = start[owner] + table["time"] * clock, np.minimum(numbers + 1, self.turns)
        ends = np.where(numbers < self.turns, self._entries(after)[0], np.inf)
        # no rounding may put an event before the last one, or into the next engagement
        table["time"] = np.maximum.accumulate(np.minimum(time, ends[owner]))
        return np.asarray(table[table["time"] <= self.end_time])

    @cached_property
    def _pieces(self) -> Pieces:
        """Its pieces; s is 0 in a dwell."""
        found = self._events[np.isin(self._events["kind"], _STOPS)]
        engagement, kind, angle, time, w, side = (found[name] for name in MOTION_EVENT.names or ())
        entry = kind == Event.ENTRY
        first = np.flatnonzero(entry)[np.cumsum(entry) - 1]
        turns, leaves = (np.cumsum(kind == k) for k in (Event.REVERSAL, Event.EXIT))
        turns, leaves = turns - turns[first], leaves - leaves[first]
        side = np.where(leaves > 0, 0.0, side[first] * (1 - 2 * (turns % 2)))
        scenes, index = self.escapement.scenes, engagement % len(self.escapement.scenes)
        # a piece ends where the next one of its engagement begins, or at the end of the cell,
        # where the follower, and then the driver, has come to the next pin's entry
        ends = np.array([float(scene.edges[-1] + scene.dwell) for scene in scenes])[index]
        ends[:-1] = np.where(entry[1:], ends[:-1], angle[1:])
        driver_angle = np.broadcast_to(self.escapement.driver_angle_before(engagement), angle.shape)
        rows = np.column_stack([index, side, angle, ends, w, driver_angle])
        # of events at one angle the last begins the piece
        kept = ends > angle
        return Pieces(time[kept], engagement[kept], rows[kept])

    @property
    def start(self) -> FloatArray:
        """Start time of each piece [s]."""
        return self._pieces.start

    @property
    def engagement(self) -> np.ndarray:
        """Engagement of each piece."""
        return self._pieces.engagement

    @property
    def sign(self) -> FloatArray:
        """s in each piece, or 0 while the follower is locked."""
        return self._pieces.rows[:, 1]

    @cached_property
    def losses(self) -> FloatArray:
        """Work lost over each piece in each of `dynamics.law.LOSSES` [J], shape (7, n)."""
        return self._read_through(0)[0].T * self.escapement.torque_unit

    @cached_property
    def peaks(self) -> FloatArray:
        """Greatest magnitudes over each piece, as `PEAKS` names them, in SI; shape (5, n).

        The force is that of a crank of 1 m.
        """
        torque, clock = self.escapement.torque_unit, self.escapement.time_unit
        scale = np.array([clock**-2.0, clock**-2.0, torque, torque, torque / clock])
        return np.asarray((self._read_through(len(PEAKS))[1] * scale).T)

    def _read_through(self, wanted: int) -> tuple[FloatArray, FloatArray]:
        """Losses of each piece in natural units, and so many of its peaks."""
        rows = self._pieces.rows
        if len(rows) and self.engagements[-1] == self.turns:
            # the last piece ends where the motion does
            rows = rows.copy()
            rows[-1, 3] = self.states(np.array([len(rows) - 1]), np.array([self.end_time]))[0][0]
        # a motion that has settled repeats its pieces, of which each is solved once
        which, distinct = np.arange(len(rows)), rows
        if self.escapement.curve is None:
            distinct, which = np.unique(rows, axis=0, return_inverse=True)
        lost, peaks = np.zeros((len(distinct), len(LOSSES))), np.zeros((len(distinct), wanted))
        count, none = np.zeros(len(distinct), np.int64), np.empty(0)
        given = *scene_and_pattern(self.escapement), distinct, count
        states_of(*given, none, self.rtol, none, none, lost, peaks)
        return lost[which.reshape(-1)], peaks[which.reshape(-1)]

    @cached_property
    def reversals(self) -> Events:
        """Every pin reversal."""
        return Events(*self._select(self._events["kind"] == Event.REVERSAL))

    @cached_property
    def extrema(self) -> Extrema:
        """Every extremum of the driver speed."""
        kinds = self._events["kind"]
        chosen = (kinds == Event.MINIMUM) | (kinds == Event.MAXIMUM)
        return Extrema(*self._select(chosen), maximum=kinds[chosen] == Event.MAXIMUM)

    def _select(self, chosen: np.ndarray) -> tuple[np.ndarray, FloatArray, FloatArray, FloatArray]:
        events, clock = self._events[chosen], self.escapement.time_unit
        engagement = events["engagement"]
        delays = np.array([pair.delay for pair in self.escapement.pairs])
        theta = events["angle"] + engagement * self.escapement.mechanism.cell_angle
        theta += delays[engagement % delays.size]
        return engagement, events["time"], theta, np.sqrt(events["w"]) / clock

    def states(self, pieces: np.ndarray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angles in the cell [rad] and speeds [rad/s] at times, each within a piece."""
        clock, (start, _engagement, rows) = self.escapement.time_unit, self._pieces
        since = np.maximum(t - start[pieces], 0.0) / clock
        theta, squares = follow(self.escapement, rows, pieces, since, self.rtol)
        return theta, np.sqrt(squares) / clock
