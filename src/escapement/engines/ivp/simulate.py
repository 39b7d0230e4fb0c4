"""A motion by SciPy's solve_ivp in the time domain.

Each smooth piece is integrated on its own with a fixed side of the slot, from
one break of the mechanism, or knot of its table, to the next or to the pin
reversal before it. The state carries the friction loss, so that the energy
ledger is an independent check.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from escapement.base.spoken import as_spoken
from escapement.base.status import MESSAGES, Status
from escapement.base.validate import fail
from escapement.dynamics.codes import Ending, Event
from escapement.dynamics.law import LOSSES, is_felt, left_by_impact
from escapement.dynamics.motion import Motion, no_motion, stall_message
from escapement.dynamics.painleve import friction_limits
from escapement.dynamics.torque import KNOT_GAP, REST, SAME_ANGLE, is_spent, is_undriven, next_knot
from escapement.dynamics.train_losses import is_lossy
from escapement.dynamics.trajectory import Events, Extrema, Trajectory
from escapement.engines.ivp.free import is_free, stand_still, turn_free
from escapement.engines.ivp.law import SceneLaw, least_share
from escapement.engines.ivp.piece import NotConverged, Solution, Task, Tolerances, solve_piece
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import transmission_at
from escapement.model.escapement import Escapement
from escapement.numerics.jit import as_python

_SHARPER = 0.05
"""Ratio of the local to the requested tolerance: errors add up over a motion, and the energy
balance must close within a tenth of the tolerance."""
_LEAST_RTOL = 2.3e-14
"""A smaller rtol makes solve_ivp warn and take this one."""
_MOST_RTOL, _MOST_RTOL_STEEP = 5e-6, 1e-9
"""Greatest local tolerances. With greater ones, errors of the speed change the sign of a small
acceleration, and false extrema are found, above all where the law is steep."""
_STEEP = 0.1
"""Share of rho + g^2 that friction leaves of J_s, below which the law is steep."""
_ROUNDING = 4.0 * float(np.finfo(float).eps)
"""Relative error of a time that is converted to natural units and back."""
_MOST = 10_000
"""Greatest number of engagements that a duration may take; they need a minute."""
_SETTLED, _SAME = 1e-2, 1e-9
"""Relative changes of the handoff speed: periods hardly change any more, and rounding."""


class Span(NamedTuple):
    """A smooth interval of driver angles up to `end`, with its slow end [rad].

    slow : the end where the follower is slow. locked : whether it is the dwell.
    """

    end: float
    slow: float
    locked: bool


class Noted(NamedTuple):
    """An event of a motion, in natural units: a pin reversal or an extremum of the speed."""

    kind: Event
    engagement: int
    time: float
    theta: float
    speed: float


@dataclass(frozen=True)
class SolvedTrajectory(Trajectory):
    """The pieces and events of a motion in SI; see `escapement.dynamics.trajectory.Trajectory`."""

    clock: float
    solution: list[Solution]
    start: FloatArray
    engagement: np.ndarray
    sign: FloatArray
    losses: FloatArray
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

    laws, cells : for each engagement of the pattern its law, and the smooth intervals of its
        cell; `spans` are those of this cell.
    shares : of each, share of the speed that is left where it begins, below 1 after an impact.
    drive, law : the law of this cell, and that between two knots of the torque.
    pieces : start, engagement, sign (0 in a dwell), losses and solution of each.
    side : that of the slot that carries the force, 0 before it is known.
    trend : sign of the latest driver acceleration, by which extrema at corners are found.
    """

    escapement: Escapement
    laws: list[SceneLaw]
    cells: list[list[Span]]
    shares: list[float]
    drive: SceneLaw
    law: SceneLaw
    options: Tolerances
    end_time: float
    speed: float
    theta: float = 0.0
    time: float = 0.0
    engagement: int = 0
    side: float = 0.0
    spans: list[Span] = field(default_factory=list)
    trend: float = 0.0
    stalled: bool = False
    pieces: list[tuple[Any, ...]] = field(default_factory=list)
    handoffs: list[tuple[float, float]] = field(default_factory=list)
    reversals: list[Noted] = field(default_factory=list)
    extrema: list[Noted] = field(default_factory=list)

    @property
    def gap(self) -> float:
        """Distance up to which breaks and events are at one angle [rad]."""
        return SAME_ANGLE if self.drive.is_steady else KNOT_GAP

    @property
    def over(self) -> bool:
        return self.stalled or self.time >= self.end_time

    def run(self, engagements: int | None) -> None:
        """Continue to the end of the time, to a stop, or for a number of engagements."""
        while self.engagement != engagements:
            index = self.engagement % len(self.laws)
            self.spans = self.cells[index]
            self.drive = self.law = self.laws[index]
            self.theta, self.side = float(self.law.scene.edges[0]), 0.0
            if not self.drive.is_steady:
                self.drive = self.drive.after(self.escapement.driver_angle_before(self.engagement))
            if self.speed**2 <= REST and is_undriven(self.theta, self.drive.scene):
                self._stop(self.drive.side(self.theta, self.speed, self.side))
                return
            for span in self.spans if self.drive.is_steady else self._between_knots():
                self._pass(span)
            if self.over:
                return
            share = self.shares[(self.engagement + 1) % len(self.shares)]
            if is_felt(share) and self.engagement + 1 != engagements:
                # the speed falls at once, from a maximum if it rose
                self._note_corner(-1.0)
            self.speed *= share
            self.handoffs.append((self.time, self.speed))
            self.engagement += 1
            if engagements is None:
                self._check_length()

    def _check_length(self) -> None:
        """Refuse a duration of more than `_MOST` engagements, as soon as it is certain.

        Motions do not cross: under a constant torque, and with perfect parts, no engagement takes
        longer than the last one if the speed has not fallen over it.
        """
        left, length, certain = _MOST - self.engagement, 0.0, self.engagement > _MOST
        if self.drive.is_steady and len(self.laws) == 1 and self.engagement > 1:
            (before, slow), (now, fast) = self.handoffs[-2:]
            length, change = now - before, fast - slow
            settled = -_SAME * fast <= change <= _SETTLED * fast
            certain |= settled and left * length < self.end_time - self.time < np.inf
        if certain:
            most = (self.time + left * length) * self.escapement.time_unit
            rule = f"of at most {_MOST} engagements with engine 'ivp', here about {most:.3g} s"
            duration = as_spoken(self.end_time * self.escapement.time_unit, "time")
            raise fail("duration", rule, duration, "choose engine 'energy', or run for less time")

    def _between_knots(self) -> Iterator[Span]:
        """The spans of this cell, cut at knots of the torque; each comes with its own law."""
        start, scene = self.theta, self.drive.scene
        for span in self.spans:
            while start < span.end:
                end = next_knot(start, span.end, scene)
                self.law = self.drive.along(0.5 * (start + end))
                yield span._replace(end=end)
                start = end

    def _pass(self, span: Span) -> None:
        """Advance to the end of a smooth interval, through any reversals."""
        sign = 0.0 if span.locked else self.law.side(self.theta, self.speed, self.side)
        if sign * self.side < 0.0:
            # the force vanishes on the break before, as behind a spent spring at dead centre
            self._note_reversal()
        while self.theta < span.end and not self.over:
            at_rest = self.speed <= self.law.rest(self.theta, sign)
            if at_rest and self.law.acceleration(self.theta, 0.0, sign) <= 0.0:
                # stall: the drive does not carry the load
                self._stop(sign)
            elif self._solve_piece(sign, span) is Ending.REVERSED:
                self._note_reversal()
                sign = -sign
        self.side = sign

    def _stop(self, sign: float) -> None:
        """End the motion here, where the driver stands still."""
        self.stalled = True
        if not self.pieces:
            self._add(sign, 0.0 * self.law.losses, stand_still(self.law, self.theta))

    def _solve_piece(self, sign: float, span: Span) -> Ending:
        """Advance by one smooth piece."""
        end = span.end
        # Next to a stop of a mesh all of the friction loss is rounding. A table's pieces are
        # short and may lie there, so that the whole engagement says how much is usual.
        edges = self.law.scene.edges
        first, last = (edges[0], edges[-1]) if self.law.is_meshed else (self.theta, end)
        typical, time_left = 0.5 * (first + last), self.end_time - self.time
        task = Task(
            theta=self.theta,
            speed=self.speed,
            sign=sign,
            end=end,
            anchor=span.slow,
            typical=typical,
            time=time_left,
            gap=self.gap,
        )
        free = is_free(self.law, task)
        solved = turn_free(self.law, task) if free else solve_piece(self.law, task, self.options)
        theta, speed, losses = solved.state(solved.length)
        self._note_extrema(solved)
        self._add(sign, losses, solved)
        time_up = solved.ending is Ending.OVER
        self.time = self.end_time if time_up else self.time + solved.length
        self.theta = end if solved.ending is Ending.ARRIVED else float(theta)
        self.speed = float(speed)
        self.stalled = solved.ending is Ending.STOPPED
        return solved.ending

    def _add(self, sign: float, losses: FloatArray, solution: Solution) -> None:
        self.pieces.append((self.time, self.engagement, sign, losses, solution))

    def _note(
        self, noted: list[Noted], kind: Event, time: float, theta: float, speed: float
    ) -> None:
        """Note an event, or drop the last one of its list if this undoes it at the same angle."""
        if noted:
            cells = (self.engagement - noted[-1].engagement) * self.escapement.mechanism.cell_angle
            if float(cells + theta - noted[-1].theta) <= self.gap:
                noted.pop()
                return
        noted.append(Noted(kind, self.engagement, time, theta, speed))

    def _note_reversal(self) -> None:
        """Note a pin reversal here."""
        self._note(self.reversals, Event.REVERSAL, self.time, self.theta, self.speed)

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
        """Note an extremum of the speed, a maximum if the speed rose so far."""
        kind = Event.MAXIMUM if self.trend > 0.0 else Event.MINIMUM
        self._note(self.extrema, kind, time, theta, speed)


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
    clock, torque = escapement.time_unit, escapement.torque_unit
    if escapement.friction >= friction_limits(escapement)[0]:
        return no_motion(escapement, "ivp", rtol)
    laws, end_time = SceneLaw.all_of(escapement), np.inf if duration is None else duration / clock
    steep = min(least_share(law.scene) for law in laws) < _STEEP
    most = _MOST_RTOL_STEEP if steep else _MOST_RTOL
    # where the power in a train changes direction the acceleration has a corner, which a long
    # step would miss
    sharper = 0.0 if as_python(is_lossy)(laws[0].scene) else _SHARPER
    options = Tolerances(
        min(max(rtol * sharper, _LEAST_RTOL), most),
        None if atol is None else (atol, atol * clock, atol / torque),
        method,
        max_step / clock,
    )
    spans = [_smooth_spans(law) for law in laws]
    struck = [pair.kind == "strike" for pair in escapement.pairs]
    shares = [
        left_by_impact(law.scene) if has_impact else 1.0
        for law, has_impact in zip(laws, struck, strict=True)
    ]
    start = laws[0], laws[0], options, end_time, initial_speed * clock
    run = _Simulation(escapement, laws, spans, shares, *start)
    status, message = Status.OK, MESSAGES[Status.OK]
    try:
        run.run(engagements)
    except NotConverged as reason:
        status, message = Status.NOT_CONVERGED, str(reason)
    if run.stalled:
        status = Status.SPENT if is_spent(run.theta, run.drive.scene) else Status.STALL
        message = stall_message(run.theta, run.engagement, status)
    # a duration is returned as it was given, without the rounding of the conversion
    end = float(run.time * clock) if duration is None or run.time < run.end_time else duration
    times, speeds = np.array(run.handoffs, dtype=float).reshape(-1, 2).T
    trajectory = _in_si(run, escapement)
    return Motion(
        escapement,
        engine="ivp",
        rtol=rtol,
        trajectory=trajectory,
        end_time=end,
        handoff_times=times * clock,
        handoff_velocities=speeds / clock,
        status=status,
        message=message,
    )


def _smooth_spans(law: SceneLaw) -> list[Span]:
    """The smooth intervals of a cell, and its dwell."""
    edges, dwell = law.scene.edges, law.scene.dwell
    ratio = [abs(transmission_at(law.scene.path, angle)[0]) for angle in edges]
    spans = [
        Span(edges[i + 1], edges[i] if ratio[i] < ratio[i + 1] else edges[i + 1], False)
        for i in range(edges.size - 1)
    ]
    return [*spans, Span(edges[-1] + dwell, edges[-1], True)] if dwell > 0.0 else spans


def _in_si(run: _Simulation, escapement: Escapement) -> SolvedTrajectory:
    """The pieces and events of a simulation, from natural units to SI."""
    clock, torque = escapement.time_unit, escapement.torque_unit
    cell, delays = escapement.mechanism.cell_angle, np.array([m.delay for m in escapement.pairs])

    def events(rows: Sequence[Noted]) -> tuple[Any, ...]:
        """Columns of `Events`, and whether each is a maximum."""
        kind, index, time, theta, speed = np.array(rows, dtype=float).reshape(-1, 5).T
        numbers = index.astype(int)
        theta = theta + numbers * cell + delays[numbers % delays.size]
        return numbers, time * clock, theta, speed / clock, kind == Event.MAXIMUM

    solutions = [piece[4] for piece in run.pieces]
    rows = np.array([piece[:3] for piece in run.pieces], dtype=float).reshape(-1, 3)
    start, engagement, sign = np.ascontiguousarray(rows.T)
    losses = np.zeros((len(LOSSES), len(rows)))
    losses[run.laws[0].losses] = np.array([piece[3] for piece in run.pieces]).T
    reversals, extrema = Events(*events(run.reversals)[:4]), Extrema(*events(run.extrema))
    numbers = (start * clock, engagement.astype(int), sign, losses * torque)
    return SolvedTrajectory(clock, solutions, *numbers, reversals, extrema)
