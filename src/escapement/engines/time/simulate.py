"""A motion by SciPy's solve_ivp in the time domain.

Each smooth piece is integrated on its own with a fixed side of the slot, from
one break of the mechanism, or knot of its table, to the next or to the pin
reversal before it. The state carries the friction loss, so that the energy
ledger is an independent check.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from escapement.dynamics import drive, free_gain
from escapement.engines.time.law import Law
from escapement.engines.time.piece import Ending, NotConverged, Options, Solution, Task, solve_piece
from escapement.model import Escapement, FloatArray, Mechanism, dwell_angle
from escapement.motion import Motion, no_motion, stall_message
from escapement.painleve import critical_friction
from escapement.status import MESSAGES, Status
from escapement.trajectory import Events, Extrema

_SHARPER = 0.02
"""Local tolerance over the one asked for, because errors add up over a motion."""
_LEAST_RTOL = 2.3e-14
"""A smaller rtol makes solve_ivp warn and take this one."""
_MOST_RTOL = 1e-9
"""With a greater one a step may pass over the narrow peak of 1/J_s near the Painleve limit."""
_ROUNDING = 4.0 * float(np.finfo(float).eps)
"""Relative error of a time that is converted to natural units and back."""
_SAME_PLACE = 1e-12
"""Two reversals this close [rad] are one that rounding crosses twice."""


class FreeTurn(NamedTuple):
    """A driver that turns alone under the torque, I_d theta_ddot = tau, in closed form."""

    theta: float
    speed: float
    rate: float
    length: float = np.inf

    def state(self, time: Any) -> tuple[Any, Any, Any]:
        """Driver angle [rad], speed and friction loss in natural units."""
        gain = time * self.rate
        return self.theta + time * (self.speed + 0.5 * gain), self.speed + gain, 0.0 * time


class Event(NamedTuple):
    """A pin reversal or an extremum of the driver speed in natural units."""

    engagement: int
    time: float
    theta: float
    speed: float
    maximum: bool = False


@dataclass(frozen=True)
class SolvedTrajectory:
    """The pieces and events of a motion in SI; see `escapement.trajectory.Trajectory`."""

    clock: float
    solution: list[Solution | FreeTurn]
    start: FloatArray
    engagement: np.ndarray
    sign: FloatArray
    friction_loss: FloatArray
    reversals: Events
    extrema: Extrema

    def state(self, piece: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angle in the cell [rad] and speed [rad/s] at times within a piece."""
        solution = self.solution[piece]
        time = (t - self.start[piece]) / self.clock
        # Next to a handoff the speed of a light driver changes within the rounding of a
        # time, so that the end of a piece is recognised and evaluated as its end.
        at_end = np.abs(time - solution.length) <= _ROUNDING * (t / self.clock)
        theta, speed, _loss = solution.state(np.where(at_end, solution.length, time))
        return theta, speed / self.clock


@dataclass
class _Simulation:
    """A motion in natural units that is continued piece by piece.

    spans : end of each smooth interval, and the one of its ends where the follower is slow [rad].
    pieces : start, engagement, sign (0 in a dwell), friction loss and solution of each.
    trend : sign of the latest driver acceleration, by which extrema at corners are found.
    """

    mechanism: Mechanism
    law: Law
    spans: list[tuple[float, float]]
    options: Options
    end_time: float
    speed: float
    theta: float = 0.0
    time: float = 0.0
    engagement: int = 0
    trend: float = 0.0
    stalled: bool = False
    pieces: list[tuple[Any, ...]] = field(default_factory=list)
    handoffs: list[tuple[float, float]] = field(default_factory=list)
    reversals: list[Event] = field(default_factory=list)
    extrema: list[Event] = field(default_factory=list)

    @property
    def over(self) -> bool:
        return self.stalled or self.time >= self.end_time

    def run(self, engagements: int | None) -> None:
        """Continue to the end of the time, to a stop, or for a number of engagements."""
        while self.engagement != engagements:
            self.theta = entry = self.mechanism.breaks[0]
            for end, slow in self.spans:
                self._pass_interval(end, slow)
            if not self.over and dwell_angle(self.mechanism) > 0.0:
                self._dwell(entry + self.mechanism.cell_angle)
            if self.over:
                return
            self.handoffs.append((self.time, self.speed))
            self.engagement += 1

    def _pass_interval(self, end: float, slow: float) -> None:
        """Advance to the end of a smooth interval, through any reversals."""
        sign = self.law.side(self.theta, self.speed)
        while self.theta < end and not self.over:
            at_rest = self.speed <= 0.0
            if at_rest and self.law.acceleration(self.theta, 0.0, sign) <= 0.0:
                # stall: the drive does not carry the load
                self.stalled = True
                if not self.pieces:
                    self._add(sign, 0.0, FreeTurn(self.theta, 0.0, 0.0))
            elif self._solve_piece(sign, end, slow) is Ending.REVERSED:
                self._note_reversal()
                sign = -sign

    def _solve_piece(self, sign: float, end: float, slow: float) -> Ending:
        """Advance by one smooth piece."""
        # Next to a stop of a mesh all of the friction loss is rounding. A table's pieces are
        # short and may lie there, so that the whole engagement says how much is usual.
        breaks = self.mechanism.breaks
        first, last = (breaks[0], breaks[-1]) if self.law.is_table else (self.theta, end)
        typical, time_left = 0.5 * (first + last), self.end_time - self.time
        task = Task(self.theta, self.speed, sign, end, slow, typical, time_left)
        solved = solve_piece(self.law, task, self.options)
        theta, speed, loss = (float(value) for value in solved.state(solved.length))
        self._note_extrema(solved)
        self._add(sign, loss, solved)
        time_up = solved.ending is Ending.TIME_UP
        self.time = self.end_time if time_up else self.time + solved.length
        self.theta = end if solved.ending is Ending.ARRIVED else theta
        self.speed = speed
        self.stalled = solved.ending is Ending.STOPPED
        return solved.ending

    def _dwell(self, end: float) -> None:
        """Let the driver turn free to the end of the cell, while the follower is locked."""
        scene, angle = self.law.scene, end - self.theta
        rate = drive(scene) / scene.rho
        self._note_corner(rate)
        # the time is the angle over the mean speed
        arrival = np.sqrt(self.speed**2 + free_gain.py_func(angle, scene))
        length = 2.0 * angle / (self.speed + arrival)
        self._add(0.0, 0.0, FreeTurn(self.theta, self.speed, rate))
        if self.time + length > self.end_time:
            self.time = self.end_time
        else:
            self.time, self.speed = self.time + length, float(arrival)

    def _add(self, sign: float, loss: float, solution: Solution | FreeTurn) -> None:
        self.pieces.append((self.time, self.engagement, sign, loss, solution))

    def _note_reversal(self) -> None:
        """Note a pin reversal, or drop the last one if this undoes it at the same place."""
        found = Event(self.engagement, self.time, self.theta, self.speed)
        last = self.reversals[-1] if self.reversals else None
        if last and last.engagement == found.engagement and found.theta - last.theta <= _SAME_PLACE:
            self.reversals.pop()
        else:
            self.reversals.append(found)

    def _note_extrema(self, solved: Solution) -> None:
        """Note the extrema of the speed within a piece and on the corner at its start."""
        self._note_corner(solved.first_rate)
        for since in solved.extrema:
            theta, speed, _loss = solved.state(since)
            self._note_extremum(self.time + since, float(theta), float(speed))
            # after a root of the acceleration the speed has the other trend
            self.trend = -self.trend
        self.trend = np.sign(solved.last_rate) or self.trend

    def _note_corner(self, rate: float) -> None:
        """Note an extremum where the acceleration jumps through zero, as at a reversal."""
        # the sign of the force jumps at a reversal and at a handoff, and J_s with it
        after = np.sign(rate)
        if after * self.trend < 0.0:
            self._note_extremum(self.time, self.theta, self.speed)
        self.trend = after or self.trend

    def _note_extremum(self, time: float, theta: float, speed: float) -> None:
        self.extrema.append(Event(self.engagement, time, theta, speed, self.trend > 0.0))


def simulate(
    escapement: Escapement,
    *,
    engagements: int | None,
    duration: float | None,
    initial_speed: float,
    rtol: float,
    atol: float | None,
    method: str,
    max_step: float,
) -> Motion:
    """Motion by solve_ivp; arguments are validated by `escapement.simulate`."""
    mechanism, clock, torque = escapement.mechanism, escapement.time_unit, escapement.torque
    if escapement.friction >= critical_friction(mechanism, escapement.inertia):
        return no_motion(escapement, "ivp", rtol)
    options = Options(
        min(max(rtol * _SHARPER, _LEAST_RTOL), _MOST_RTOL),
        None if atol is None else (atol, atol * clock, atol / torque),
        method,
        max_step / clock,
    )
    law, end_time = Law.of(escapement), np.inf if duration is None else duration / clock
    spans = _smooth_spans(law)
    run = _Simulation(mechanism, law, spans, options, end_time, initial_speed * clock)
    status, message = Status.OK, MESSAGES[Status.OK]
    try:
        run.run(engagements)
    except NotConverged as reason:
        status, message = Status.NOT_CONVERGED, str(reason)
    if run.stalled:
        status, message = Status.STALL, stall_message(run.theta, run.engagement)
    # a duration is returned as it was given, without the rounding of the conversion
    end = float(run.time * clock) if duration is None or run.time < run.end_time else duration
    times, speeds = np.array(run.handoffs, dtype=float).reshape(-1, 2).T
    trajectory = _in_si(run, clock, torque, mechanism.cell_angle)
    return Motion(
        escapement, "ivp", rtol, trajectory, end, times * clock, speeds / clock, status, message
    )


def _smooth_spans(law: Law) -> list[tuple[float, float]]:
    """End of each smooth interval, and the one of its two ends where the follower is slow."""
    edges = law.scene.edges
    ratio = [abs(law.transmission(angle)[0]) for angle in edges]
    return [
        (edges[i + 1], edges[i] if ratio[i] < ratio[i + 1] else edges[i + 1])
        for i in range(edges.size - 1)
    ]


def _in_si(run: _Simulation, clock: float, torque: float, cell: float) -> SolvedTrajectory:
    """The pieces and events of a simulation, from natural units to SI."""

    def events(rows: Sequence[Event]) -> tuple[Any, ...]:
        """Columns of `Events`, and whether each is a maximum."""
        index, time, theta, speed, maximum = np.array(rows, dtype=float).reshape(-1, 5).T
        numbers = index.astype(int)
        return numbers, time * clock, theta + numbers * cell, speed / clock, maximum.astype(bool)

    solutions = [piece[4] for piece in run.pieces]
    rows = np.array([piece[:4] for piece in run.pieces], dtype=float).reshape(-1, 4)
    start, engagement, sign, loss = np.ascontiguousarray(rows.T)
    reversals, extrema = Events(*events(run.reversals)[:4]), Extrema(*events(run.extrema))
    numbers = (start * clock, engagement.astype(int), sign, loss * torque)
    return SolvedTrajectory(clock, solutions, *numbers, reversals, extrema)
