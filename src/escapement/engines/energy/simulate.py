"""A motion by the fast engine, whose equation is linear in w over the driver angle.

At first only the handoffs are computed. Reversals, extrema and states between the handoffs
are computed when they are asked for, from the w at the start of each engagement.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from escapement.dynamics import LOSSES, left_by_blow
from escapement.engines.energy.calls import prepared
from escapement.engines.energy.cells import NO_CELLS
from escapement.engines.energy.events import EventKind
from escapement.engines.energy.handoffs import handoffs
from escapement.engines.energy.march import OK, PAINLEVE, SPENT, STALL
from escapement.engines.energy.pattern import pattern_handoffs
from escapement.engines.energy.peaks import PEAKS
from escapement.engines.energy.pieces import MOTION_EVENT, events_of, follow, states_in
from escapement.mechanism import FloatArray
from escapement.model import Escapement
from escapement.motion import Motion, no_motion, stall_message
from escapement.scene import scene_tuple
from escapement.status import MESSAGES, Status
from escapement.trajectory import Events, Extrema
from escapement.validate import fail

_EMPTY = np.empty(0)
_START = np.zeros(1)
# Events are computed for so many engagements in one call of a kernel, and Ctrl-C is heard
# between two calls.
_AT_ONCE = 1 << 15
_DONE = MESSAGES[Status.OK]


@dataclass
class EnergyTrajectory:
    """Handoffs of a motion, and the pieces and events that follow from them.

    initial_speed : driver speed at the first entry [rad/s].
    times, speeds : of the handoffs [s, rad/s]; each of the first `turns` starts an engagement.
    end_time : time at which the motion ends [s].
    """

    escapement: Escapement
    rtol: float
    initial_speed: float
    times: FloatArray
    speeds: FloatArray
    turns: int
    end_time: float

    @cached_property
    def _events(self) -> np.ndarray:
        """Every event of the motion, an array of `pieces.MOTION_EVENT` in natural units."""
        clock = self.escapement.time_unit
        starts = np.concatenate([_START, self.times[: self.turns]]) / clock
        speeds = np.concatenate([[self.initial_speed], self.speeds[: self.turns]])
        squares = (speeds * clock) ** 2
        kernel_inputs, tables = prepared(self.escapement), []
        if len(self.escapement.scenes) > 1:
            return self._pattern_events(kernel_inputs[0], starts, squares)
        for first in range(0, starts.size, _AT_ONCE):
            # begin one engagement earlier: a handoff is an extremum if theta_ddot changes its
            # sign there, which needs the sign before it
            some = slice(max(first - 1, 0), first + _AT_ONCE)
            of_some = starts[some], squares[some]
            table, _ = events_of(*kernel_inputs, some.start, *of_some, 0.0, self.rtol)
            table["engagement"] += some.start
            within = table["time"] * clock <= self.end_time
            tables.append(table[(table["engagement"] >= first) & within])
        return np.concatenate(tables)

    def _pattern_events(
        self, addresses: Any, starts: FloatArray, squares: FloatArray
    ) -> np.ndarray:
        """Every event where engagements differ, each of which is marched alone."""
        tables, rising, scenes = [], 0.0, self.escapement.scenes
        for k, (start, w) in enumerate(zip(starts, squares, strict=True)):
            scene, before = scenes[k % len(scenes)], scenes[k % len(scenes) - 1]
            if k and self.escapement.meetings[k % len(scenes)].kind == "strike":
                # the speed falls at once, from a maximum if it rose
                w_before = w / left_by_blow(scene) ** 2
                end = before.edges[-1] + before.dwell
                row = k - 1, EventKind.MAXIMUM, end, start, w_before, 0.0
                tables += [np.array([row], MOTION_EVENT)] if rising > 0.0 else []
                rising = -1.0
            once = np.array([start]), np.array([w])
            plain = scene_tuple(scene)
            table, rising = events_of(addresses, plain, NO_CELLS, 0, *once, rising, self.rtol)
            table["engagement"] = k
            tables.append(table)
        happened = np.concatenate(tables)
        within = happened["time"] * self.escapement.time_unit <= self.end_time
        return np.asarray(happened[within])

    @cached_property
    def _pieces(self) -> FloatArray:
        """Start time, engagement, place in the pattern, s, angles of start and end, w and
        `Scene.turned`; shape (8, n).

        They are in natural units, and s is 0 in a dwell.
        """
        rows: list[list[float]] = []
        side = 0.0
        scenes = self.escapement.scenes
        # a cell ends where the follower, and then the driver, has come to the next pin's entry
        ends = [float(scene.edges[-1] + scene.dwell) for scene in scenes]
        for engagement, kind, angle, time, w, at_entry in self._events.tolist():
            if kind == EventKind.ENTRY:
                side = at_entry
            elif kind == EventKind.REVERSAL:
                side = -side
            elif kind == EventKind.EXIT:
                side = 0.0
            elif kind != EventKind.BREAK:
                continue
            # a piece ends where the next one of its engagement begins, or at the end of the cell
            if rows and rows[-1][1] == engagement:
                rows[-1][5] = angle
            place, turned = engagement % len(scenes), self.escapement.turned_before(engagement)
            rows.append([time, engagement, place, side, angle, ends[place], w, turned])
        return np.array(rows).reshape(-1, 8).T

    @property
    def start(self) -> FloatArray:
        """Start time of each piece [s]."""
        result: FloatArray = self._pieces[0] * self.escapement.time_unit
        return result

    @property
    def engagement(self) -> np.ndarray:
        """Engagement of each piece."""
        result: np.ndarray = self._pieces[1].astype(int)
        return result

    @property
    def sign(self) -> FloatArray:
        """s in each piece, or 0 while the follower is locked."""
        result: FloatArray = self._pieces[3]
        return result

    @property
    def losses(self) -> FloatArray:
        """Work lost over each piece in each of `dynamics.LOSSES` [J], shape (5, n)."""
        return np.asarray(self._read_through[0] * self.escapement.torque_unit)

    @property
    def peaks(self) -> FloatArray:
        """Greatest magnitudes over each piece, as `peaks.PEAKS` names them, in SI; shape (4, n).

        The force is that of a crank of 1 m.
        """
        torque, rate = self.escapement.torque_unit, self.escapement.time_unit**-2.0
        scale = np.array([rate, rate, torque, torque])
        return np.asarray(self._read_through[1] * scale[:, None])

    @cached_property
    def _read_through(self) -> tuple[FloatArray, FloatArray]:
        """Losses and peaks of each piece in natural units."""
        scenes = self.escapement.scenes
        end_time = self.end_time / self.escapement.time_unit
        pieces = self._pieces[2:].T.copy()
        if len(pieces):
            since = np.array([end_time - self._pieces[0, -1]])
            pieces[-1, 3] = self._solve(len(pieces) - 1, since)[0][0]
        # a motion that has settled repeats its pieces, of which each is solved once
        distinct, which = np.unique(pieces, axis=0, return_inverse=True)
        lost, peaks = np.zeros((len(distinct), len(LOSSES))), np.zeros((len(distinct), len(PEAKS)))
        for (place, side, angle, end, w, turned), *rows in zip(distinct, lost, peaks, strict=True):
            here = scenes[int(place)]._replace(turned=turned)
            states_in(here, angle, end, w, side, self.rtol, _EMPTY, _EMPTY, _EMPTY, *rows)
        return lost.T[:, which.reshape(-1)], peaks.T[:, which.reshape(-1)]

    @cached_property
    def reversals(self) -> Events:
        """Every pin reversal."""
        return Events(*self._select(self._events["kind"] == EventKind.REVERSAL))

    @cached_property
    def extrema(self) -> Extrema:
        """Every extremum of the driver speed."""
        kinds = self._events["kind"]
        chosen = (kinds == EventKind.MINIMUM) | (kinds == EventKind.MAXIMUM)
        return Extrema(*self._select(chosen), maximum=kinds[chosen] == EventKind.MAXIMUM)

    def _select(self, chosen: np.ndarray) -> tuple[np.ndarray, FloatArray, FloatArray, FloatArray]:
        events, clock = self._events[chosen], self.escapement.time_unit
        engagement = events["engagement"]
        late = np.array([meeting.late for meeting in self.escapement.meetings])
        theta = events["angle"] + engagement * self.escapement.mechanism.cell_angle
        theta += late[engagement % late.size]
        return engagement, events["time"] * clock, theta, np.sqrt(events["w"]) / clock

    def _solve(self, piece: int, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angles and w at times since the start of a piece, in natural units."""
        _start, _engagement, place, sign, angle, end, w, turned = self._pieces[:, piece]
        scene = self.escapement.scenes[int(place)]._replace(turned=turned)
        return follow(scene, (angle, w, sign), end, times, self.rtol)

    def state(self, piece: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angle in the cell [rad] and speed [rad/s] at times within a piece."""
        clock = self.escapement.time_unit
        since = np.ascontiguousarray(t, dtype=float) / clock - self._pieces[0, piece]
        theta, squares = self._solve(piece, np.maximum(since, 0.0))
        return theta, np.sqrt(squares) / clock


def simulate(
    escapement: Escapement,
    *,
    engagements: int | None,
    duration: float | None,
    initial_speed: float,
    rtol: float,
    longest: int = 10_000_000,
) -> Motion:
    """Motion in the driver-angle domain; arguments are validated by `escapement.simulate`.

    A duration of more than `longest` engagements is refused.
    """
    clock, march_all = escapement.time_unit, handoffs
    kernel_inputs: tuple[Any, ...] = prepared(escapement)
    if len(escapement.scenes) > 1:
        pattern: Any = escapement.mechanism
        march_all, kernel_inputs = pattern_handoffs, (*kernel_inputs[:2], NO_CELLS, pattern.pattern)
    horizon = np.inf if duration is None else duration / clock
    w = (initial_speed * clock) ** 2
    size = engagements or 64
    # how many engagements a duration takes is unknown: the arrays grow until they hold it
    while True:
        times, speeds = np.empty(size), np.empty(size)
        code, done, angle = march_all(*kernel_inputs, w, horizon, rtol, clock, times, speeds)
        if code != OK or duration is None or done < size or times[-1] >= duration:
            break
        if size >= longest:
            rule = f"at most {times[-1]:.6g} s, in which {longest} engagements pass"
            raise fail("duration", rule, duration, "the figures of merit need no long motion")
        size = min(8 * size, longest)
    if code == PAINLEVE:
        return no_motion(escapement, "energy", rtol)
    # after a stall times[done] is the time of the stall, and otherwise times[done - 1] the end
    last = done - 1 if code == OK else done
    end = float(times[last])
    status, message = Status.OK, _DONE
    if code != OK:
        status = Status(code)
        stopped = code in (STALL, SPENT)
        message = stall_message(angle, done, status) if stopped else MESSAGES[status]
    if duration is not None and (code == OK or end >= duration):
        done = done if end <= duration else last
        end, status, message = duration, Status.OK, _DONE
    trajectory = EnergyTrajectory(escapement, rtol, initial_speed, times, speeds, last, end)
    if done < size:
        times, speeds = times[:done], speeds[:done]
    return Motion(escapement, "energy", rtol, trajectory, end, times, speeds, status, message)
