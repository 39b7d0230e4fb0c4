"""The reference engine: SciPy's solve_ivp in the time domain.

Each smooth piece is integrated on its own with a fixed side of the slot, from
one break of the mechanism, or knot of its table, to the next or to the pin
reversal before it. Time is measured in units of sqrt(I_f/torque), so the
tolerance means the same thing for a watch and a turret. The state carries the
friction loss, so that the energy ledger is an independent check.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from escapement.dynamics import side_at
from escapement.engines.time.piece import NotConverged, Options, solve_piece, starting_rate
from escapement.engines.time.solution import Free, Solution
from escapement.mechanisms.slotted import transmission_at
from escapement.model import Escapement, FloatArray, Mechanism, dwell_angle
from escapement.motion import Events, Extrema, Motion, no_motion, stall_message
from escapement.painleve import critical_friction
from escapement.scene import Path, Scene
from escapement.status import MESSAGES, Status

_TIGHTER = 0.02  # local tolerance over the one asked for: errors add up over a run
_FLOOR = 2.3e-14  # solve_ivp clips a smaller rtol with a warning
_ROUNDING = 4.0 * float(np.finfo(float).eps)
_TOGETHER = 1e-12  # radians between two reversals that undo each other
_CEILING = 1e-9  # with longer steps a solver leaps over the narrow peak of 1/J near the limit


@dataclass
class _Pieces:
    """Growing trajectory: one solution per piece."""

    clock: float
    torque: float
    start: Any = field(default_factory=list)
    engagement: Any = field(default_factory=list)
    sign: Any = field(default_factory=list)
    friction_loss: Any = field(default_factory=list)
    solution: list[Any] = field(default_factory=list)
    reversals: Any = None
    extrema: Any = None

    def add(self, x: float, engagement: int, sign: float, loss: float, solution: Any) -> None:
        self.start.append(x * self.clock)
        self.engagement.append(engagement)
        self.sign.append(sign)
        self.friction_loss.append(loss * self.torque)
        self.solution.append(solution)

    def freeze(self) -> None:
        for name in ("start", "engagement", "sign", "friction_loss"):
            kind = int if name == "engagement" else float
            setattr(self, name, np.array(getattr(self, name), dtype=kind))

    def state(self, piece: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angle in the cell [rad] and speed [rad/s] at times within a piece."""
        solution = self.solution[piece]
        time = (t - self.start[piece]) / self.clock
        # a light driver at a handoff feels even the rounding of a time: its end is its end
        at_end = np.abs(time - solution.length) <= _ROUNDING * (t / self.clock)
        theta, speed, _loss = solution(np.where(at_end, solution.length, time))
        return theta, speed / self.clock


@dataclass
class _Run:
    """One simulation in natural units, advanced piece by piece."""

    scene: Scene
    edges: FloatArray
    options: Options
    horizon: float
    pieces: _Pieces
    x: float = 0.0
    theta: float = 0.0
    speed: float = 0.0
    engagement: int = 0
    rising: float = 0.0
    reversals: list[tuple[float, ...]] = field(default_factory=list)
    extrema: list[tuple[float, ...]] = field(default_factory=list)
    stalled: bool = False

    @property
    def over(self) -> bool:
        return self.stalled or self.x >= self.horizon

    def cell(self, mechanism: Mechanism) -> bool:
        """One engagement and the dwell after it; False if the motion ends within."""
        breaks, path = mechanism.breaks, self.scene.path
        self.theta = breaks[0]
        for start, end in pairwise(self.edges):
            slow = start if abs(_ratio(path, start)) < abs(_ratio(path, end)) else end
            self._engage(end, slow)
        if not self.over and dwell_angle(mechanism) > 0.0:
            self._dwell(breaks[0] + mechanism.cell_angle)
        return not self.over

    def _engage(self, end: float, slow: float) -> None:
        """Advance to the break at `end`, through any reversals."""
        g, _, dg = transmission_at(self.scene.path, self.theta)
        sign = side_at(g, dg, self.speed**2, self.scene)
        while self.theta < end and not self.over:
            if self.speed <= 0.0 and starting_rate(self.scene, self.theta, sign) <= 0.0:
                self._stand(sign)
            elif self._piece(sign, end, slow):
                self._turn()
                sign = -sign

    def _turn(self) -> None:
        """Note a reversal; there and back within rounding is none."""
        last = self.reversals[-1] if self.reversals else None
        if last and last[0] == self.engagement and self.theta - last[2] <= _TOGETHER:
            self.reversals.pop()
        else:
            self.reversals.append((self.engagement, self.x, self.theta, self.speed))

    def _stand(self, sign: float) -> None:
        """At rest, and the drive does not carry the load."""
        self.stalled = True
        if not self.pieces.start:
            self.pieces.add(self.x, self.engagement, sign, 0.0, Free(self.theta, 0.0, np.inf))

    def _piece(self, sign: float, end: float, slow: float) -> bool:
        """Advance by one smooth piece; True if it ends in a pin reversal."""
        start = (self.theta, self.speed, sign)
        # a table's piece may lie next to a stop, where all that is lost is rounding
        first, last = (
            (self.edges[0], self.edges[-1]) if self.scene.path.table else (self.theta, end)
        )
        goal = (end, slow, 0.5 * (first + last))
        solved = solve_piece(self.scene, start, goal, self.horizon - self.x, self.options)
        theta, speed, loss = (float(value) for value in solved(solved.length))
        self._record_extrema(solved)
        self.pieces.add(self.x, self.engagement, sign, loss, solved)
        horizon = solved.ended == "horizon"
        self.x = self.horizon if horizon else self.x + solved.length
        self.theta = end if solved.ended == "arrived" else theta
        self.speed = speed
        self.stalled = solved.ended == "stopped"
        return solved.ended == "reversed"

    def _record_extrema(self, solved: Solution) -> None:
        """Extrema of the speed within a piece and on its first corner."""
        first, last = solved.rates
        self._corner(first)
        for time in solved.extrema:
            theta, speed, _loss = solved(time)
            self._extremum(self.x + time, float(theta), float(speed))
            self.rising = -self.rising
        self.rising = np.sign(last) or self.rising

    def _corner(self, rate: float) -> None:
        """An extremum where the acceleration jumps through zero."""
        now = np.sign(rate)
        if now * self.rising < 0.0:
            self._extremum(self.x, self.theta, self.speed)
        self.rising = now or self.rising

    def _extremum(self, x: float, theta: float, speed: float) -> None:
        self.extrema.append((self.engagement, x, theta, speed, self.rising > 0.0))

    def _dwell(self, end: float) -> None:
        """Turn free to the end of the cell: constant acceleration, closed form."""
        rho = self.scene.rho
        self._corner(1.0 / rho)
        angle = end - self.theta
        arrival = np.sqrt(self.speed**2 + 2.0 * angle / rho)
        length = 2.0 * angle / (self.speed + arrival)
        self.pieces.add(self.x, self.engagement, 0.0, 0.0, Free(self.theta, self.speed, rho))
        if self.x + length > self.horizon:
            self.x = self.horizon
            return
        self.x, self.theta, self.speed = self.x + length, end, float(arrival)


def _ratio(path: Path, theta: float) -> float:
    return float(transmission_at(path, theta)[0])


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
    run = _Run(
        escapement.scene,
        escapement.scene.edges,
        Options(
            min(max(rtol * _TIGHTER, _FLOOR), _CEILING),
            None if atol is None else (atol, atol * clock, atol / torque),
            method,
            max_step / clock,
        ),
        np.inf if duration is None else duration / clock,
        _Pieces(clock, torque),
        speed=initial_speed * clock,
    )
    handoffs: list[tuple[float, float]] = []
    status, message = Status.OK, MESSAGES[Status.OK]
    try:
        while run.engagement != engagements and run.cell(mechanism):
            handoffs.append((run.x, run.speed))
            run.engagement += 1
    except NotConverged as reason:
        status, message = Status.NOT_CONVERGED, str(reason)
    if run.stalled:
        status, message = Status.STALL, stall_message(run.theta, run.engagement)
    end = float(run.x * clock) if duration is None or run.x < run.horizon else duration
    return _assemble(escapement, rtol, run, handoffs, end, status, message)


def _assemble(
    escapement: Escapement,
    rtol: float,
    run: _Run,
    handoffs: list[tuple[float, float]],
    end: float,
    status: Status,
    message: str,
) -> Motion:
    """From natural units to SI."""
    pieces, clock, cell = run.pieces, run.pieces.clock, escapement.mechanism.cell_angle

    def columns(rows: list[tuple[float, ...]], width: int) -> list[Any]:
        table = np.array(rows, dtype=float).reshape(-1, width).T
        index = table[0].astype(int)
        return [index, table[1] * clock, table[2] + index * cell, table[3] / clock, *table[4:]]

    pieces.freeze()
    pieces.reversals = Events(*columns(run.reversals, 4))
    *events, maximum = columns(run.extrema, 5)
    index, time, theta, speed = events
    pieces.extrema = Extrema(index, time, theta, speed, maximum.astype(bool))
    times, speeds = np.array(handoffs, dtype=float).reshape(-1, 2).T
    return Motion(
        escapement, "ivp", rtol, pieces, end, times * clock, speeds / clock, status, message
    )
