"""The fast engine: linear in theta_dot^2 over the driver angle.

A motion is the list of its handoffs; reversals, extrema and states in between
are worked out when asked for, by marching the engagement in question again.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from escapement.engines._cycle import handoffs
from escapement.engines._march import BREAK, MAXIMUM, REVERSAL, STALL
from escapement.engines._pieces import events_of, states_in
from escapement.model import Escapement, FloatArray
from escapement.motion import Events, Extrema, Motion, stall_message
from escapement.status import MESSAGES, Status

_ENTRY, _EXIT = -1.0, 4.0
_NOWHERE = np.empty(0)
_START = np.zeros(1)


Scene = tuple[FloatArray, FloatArray, float, float, float, float]
"""path, breaks, dwell angle, inertia ratio, friction, load ratio."""


def scene_of(escapement: Escapement) -> Scene:
    """An escapement as the kernels see it."""
    mechanism = escapement.mechanism
    breaks = np.array(mechanism.breaks)
    dwell = mechanism.cell_angle - (breaks[-1] - breaks[0])
    # an exact zero: a dwell of one rounding error is none
    dwell = dwell if dwell > 1e-12 else 0.0
    numbers = (escapement.inertia_ratio, escapement.friction, escapement.load_ratio)
    return mechanism.path, breaks, float(dwell), *numbers


@dataclass
class EnergyTrajectory:
    """Handoffs of a motion in natural units, and what follows from them.

    starts, squares : entry time and squared entry speed of each engagement,
        the one in which the motion ends included.
    """

    escapement: Escapement
    rtol: float
    starts: FloatArray
    squares: FloatArray
    end: float

    @cached_property
    def _scene(self) -> Scene:
        return scene_of(self.escapement)

    @cached_property
    def _events(self) -> FloatArray:
        if self.starts.size == 0:
            return np.empty((0, 5))
        table = events_of(*self._scene, self.starts, self.squares, self.rtol)
        return table[table[:, 3] <= self.end]

    @cached_property
    def _pieces(self) -> FloatArray:
        """Start time, engagement, sign, start angle, end angle, w; shape (6, pieces)."""
        rows, sign = [], 0.0
        exit_ = self.escapement.mechanism.breaks[-1]
        for engagement, kind, angle, time, w in self._events:
            if kind == _ENTRY:
                sign, angle = angle, self.escapement.mechanism.breaks[0]
            elif kind == REVERSAL:
                sign = -sign
            elif kind == _EXIT:
                sign = 0.0
            elif kind != BREAK:
                continue
            if rows and rows[-1][1] == engagement:
                rows[-1][4] = angle
            rows.append([time, engagement, sign, angle, exit_, w])
        return np.array(rows).reshape(-1, 6).T

    @property
    def start(self) -> FloatArray:
        """Start time of each piece [s]."""
        return self._pieces[0] * self.escapement.time_unit

    @property
    def engagement(self) -> np.ndarray:
        """Engagement of each piece."""
        return self._pieces[1].astype(int)

    @property
    def sign(self) -> FloatArray:
        """Side of the slot in each piece, 0 while locked."""
        return self._pieces[2]

    @cached_property
    def friction_loss(self) -> FloatArray:
        """Work lost in friction over each piece [J]."""
        path, _breaks, _dwell, *losses = self._scene
        lost = []
        for piece, (start, _, sign, angle, end, w) in enumerate(self._pieces.T):
            if sign == 0.0:
                lost.append(0.0)
                continue
            if piece + 1 == self._pieces.shape[1]:
                end = self._solve(piece, np.array([self.end - start]))[0][0]
            none = (_NOWHERE, _NOWHERE, _NOWHERE)
            lost.append(states_in(path, angle, end, w, sign, *losses, self.rtol, *none)[0])
        return np.array(lost) * self.escapement.torque

    @cached_property
    def reversals(self) -> Events:
        """Every pin reversal."""
        return Events(*self._select(self._events[:, 1] == REVERSAL))

    @cached_property
    def extrema(self) -> Extrema:
        """Every extremum of the driver speed."""
        kinds = self._events[:, 1]
        chosen = (kinds > REVERSAL) & (kinds <= MAXIMUM)
        return Extrema(*self._select(chosen), maximum=kinds[chosen] == MAXIMUM)

    def _select(self, chosen: np.ndarray) -> tuple[np.ndarray, FloatArray, FloatArray, FloatArray]:
        engagement, _, angle, time, w = self._events[chosen].T
        clock = self.escapement.time_unit
        theta = angle + engagement * self.escapement.mechanism.cell_angle
        return engagement.astype(int), time * clock, theta, np.sqrt(w) / clock

    def _solve(self, piece: int, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angles and squared speeds at times since the piece's start."""
        _start, _engagement, sign, angle, end, w = self._pieces[:, piece]
        path, _breaks, _dwell, rho, mu, load = self._scene
        theta, squares = np.empty_like(times), np.empty_like(times)
        if sign == 0.0:
            speed = np.sqrt(w)
            theta = angle + times * (speed + times / (2.0 * rho))
            return theta, (speed + times / rho) ** 2
        numbers = (w, sign, rho, mu, load, self.rtol)
        states_in(path, angle, end, *numbers, times, theta, squares)
        return theta, squares

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
) -> Motion:
    """Motion in the driver-angle domain; arguments are validated by `escapement.simulate`."""
    clock = escapement.time_unit
    scene = scene_of(escapement)
    horizon = np.inf if duration is None else duration / clock
    w = (initial_speed * clock) ** 2
    size = engagements or 64
    while True:
        times, squares = np.empty(size), np.empty(size)
        code, done, angle, _w = handoffs(*scene, w, horizon, rtol, times, squares)
        if engagements or code or done < size or times[-1] >= horizon:
            break
        size *= 8
    status, message, end = Status.OK, MESSAGES[Status.OK], times[done - 1]
    running = done
    if code == STALL:
        status, end, running = Status.STALL, times[done], done + 1
        message = stall_message(angle, done)
    elif code:
        status, message = Status.NOT_CONVERGED, MESSAGES[Status.NOT_CONVERGED]
        end = times[done - 1] if done else 0.0
    if end > horizon:
        done, end, status, message = done - 1, horizon, Status.OK, MESSAGES[Status.OK]
        while done and times[done - 1] > horizon:
            done -= 1
    starts = np.concatenate([_START, times[: running - 1]])
    entries = np.concatenate([[w], squares[: running - 1]])
    return Motion(
        escapement,
        "energy",
        rtol,
        EnergyTrajectory(escapement, rtol, starts, entries, end),
        end * clock,
        times[:done] * clock,
        np.sqrt(squares[:done]) / clock,
        status,
        message,
    )
