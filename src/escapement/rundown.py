"""How a timer runs down: its turns, its rate and the place where it stops.

With a spring the driver runs ever more slowly. All engagements are computed one by one, or, of
many, by quasi-static theory: where the torque hardly changes within the engagements in which a
disturbance dies out, the period depends on the torque alone. It is then sampled at some places of
the run, each by a few engagements of the full law, and summed from the series through the samples.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from escapement import validate
from escapement.chebyshev import Series, interpolate, nodes
from escapement.errors import InvalidValue
from escapement.model import Escapement, FloatArray
from escapement.motion import Motion
from escapement.simulation import LONGEST, simulate, terminal
from escapement.status import MESSAGES, Status
from escapement.text import Shown

MOST = LONGEST["energy"]
"""Engagements of a run."""
FEW = 100_000
"""So many engagements are computed one by one unless a method is named; they take half a second."""
METHODS = ("full", "quasi-static")
_FORGOTTEN = 1e-13
"""A disturbance is over when it has shrunk to this share."""
_LATE = 0.05
"""Share of the run before its stop that is computed one by one."""
_ORDER = 24
"""Places at which the period is sampled."""
_CHECKS = 7
"""Further places, at which the series is compared with the full law."""
_SAFETY = 4.0
"""Stated error over the greatest difference at those places."""


@dataclass(frozen=True, eq=False, repr=False)
class Rundown(Shown):
    """A run from its start to the turns or the time asked for, or to its stop.

    Parameters
    ----------
    escapement : Escapement
        What runs down.
    times : array, shape (n,)
        End of each engagement [s], its dwell included.
    nominal_period : float
        Period of the terminal cycle at the torque of the start [s]; NaN where there is none.
    end_time, end_turns : float
        When and where the run ends [s, driver turns], within an engagement where it stops there.
    method : str
        "full", or "quasi-static" with an estimate of the error.
    uncertainty : float
        Greatest error of a time by that method, beside that of the engine [s]; 0 of "full".
    status, message : outcome, and its reason in a sentence.
    """

    _units = {
        "times": "s", "nominal_period": "s", "end_time": "s", "end_turns": "turns",
        "lateness": "s", "uncertainty": "s",
    }  # fmt: skip

    escapement: Escapement = field(repr=False)
    times: FloatArray
    nominal_period: float
    end_time: float
    end_turns: float
    method: str
    uncertainty: float
    status: Status = Status.OK
    message: str = MESSAGES[Status.OK]

    @cached_property
    def turns(self) -> FloatArray:
        """Driver turns since the start at the end of each engagement, shape (n,)."""
        cell = self.escapement.mechanism.cell_angle / (2.0 * math.pi)
        return cell * np.arange(1, self.times.size + 1)

    @property
    def remaining_turns(self) -> FloatArray:
        """Driver turns left at the end of each engagement, shape (n,)."""
        return self.end_turns - self.turns

    @cached_property
    def periods(self) -> FloatArray:
        """Duration of each engagement [s], shape (n,)."""
        return np.diff(self.times, prepend=0.0)

    @property
    def rates(self) -> FloatArray:
        """Engagements per second in each engagement [1/s], shape (n,)."""
        return 1.0 / self.periods

    @property
    def mean_speeds(self) -> FloatArray:
        """Mean driver speed over each engagement [rad/s], shape (n,)."""
        return self.escapement.mechanism.cell_angle / self.periods

    @property
    def rate_errors(self) -> FloatArray:
        """Rate over that of the nominal period, less 1 [-], shape (n,); below 0 it is slow."""
        return self.nominal_period / self.periods - 1.0

    @property
    def lateness(self) -> FloatArray:
        """Time less that of as many nominal periods [s], shape (n,)."""
        return self.times - self.nominal_period * np.arange(1, self.times.size + 1)

    def time_of(self, turns: float) -> float:
        """Time at which the driver has turned so often [s].

        Between the ends of two engagements it is interpolated linearly, which is right to the
        variation of the speed within an engagement.

        Raises
        ------
        InvalidValue
            When the run has no such turn.
        """
        turns = validate.number("turns", turns, remedy="give driver turns of the run")
        if turns > self.end_turns:
            rule = f"at most {self.end_turns:g}, where the run ends"
            raise validate.fail("turns", rule, turns, "give fewer, or run for longer")
        ends = np.append(self.turns, self.end_turns), np.append(self.times, self.end_time)
        return float(np.interp(turns, *(np.append(0.0, column) for column in ends)))


def rundown(
    escapement: Escapement,
    *,
    turns: float | None = None,
    duration: float | None = None,
    method: str | None = None,
    initial_speed: float = 0.0,
    rtol: float | None = None,
) -> Rundown:
    """Let a timer run down.

    Parameters
    ----------
    escapement : Escapement
        A timer, with a `spring_rate` or without.
    turns : float, optional
        Driver turns to run, > 0; they are rounded up to whole engagements.
    duration : float, optional
        Time to run instead [s], > 0. Without either a spring runs until the driver stops.
    method : str, optional
        "full" computes every engagement, "quasi-static" samples them. Without it the first is
        taken of up to 100 000 engagements, and of more where the second does not hold.
    initial_speed : float
        Driver speed at the first pin entry [rad/s], >= 0.
    rtol : float, optional
        Relative error asked for in times, as of `simulate`.

    Returns
    -------
    Rundown
        Its `status` is `stall` or `spent` where the driver stopped on the way.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, and when quasi-static theory is asked for where a
        disturbance dies out too slowly, or where the torque is a curve.
    """
    if method is not None and method not in METHODS:
        raise validate.fail("method", " or ".join(METHODS), method, "leave it out to let it choose")
    ask = _Question(escapement, initial_speed, rtol)
    count = _engagements(ask, turns, duration)
    nominal = terminal(replace(escapement, spring_rate=0.0), rtol=rtol)
    if method != "full" and (count > FEW or method is not None):
        plan = _plan(ask, count, nominal.contraction)
        if plan is not None:
            return _sampled(ask, plan, duration, nominal.period)
        if method is not None:
            raise validate.fail(
                "method", "'full' for this timer", method,
                "its torque changes too much while a disturbance dies out; leave method out",
            )  # fmt: skip
    return _full(ask, count, duration, nominal.period)


class _Question(NamedTuple):
    """What runs down, and how it is computed."""

    escapement: Escapement
    initial_speed: float
    rtol: float | None

    @property
    def cell(self) -> float:
        """Driver angle of an engagement [rad]."""
        return float(self.escapement.mechanism.cell_angle)

    @property
    def spent(self) -> float:
        """Driver angle at which the spring has no torque left [rad], infinite without one."""
        rate = self.escapement.spring_rate
        return self.escapement.torque / rate if rate > 0.0 else math.inf

    def run(self, engagements: int, before: float = 0.0, speed: float | None = None) -> Motion:
        """Motion of some engagements after the driver has turned by an angle `before` [rad]."""
        start = self.initial_speed if speed is None else speed
        timer = _after(self.escapement, before)
        return simulate(timer, engagements, initial_speed=start, rtol=self.rtol)

    def settled(self, before: float, engagements: int, settle: int) -> Motion:
        """Motion on which no disturbance is left when the driver has turned by `before`.

        It begins `settle` engagements earlier with the terminal speed of the torque there.
        """
        early = before - settle * self.cell
        speed = terminal(_constant(self.escapement, early)).handoff_velocity
        return self.run(settle + engagements, early, speed)


def _after(escapement: Escapement, turned: float) -> Escapement:
    """The timer once its driver has turned by an angle [rad]."""
    if turned == 0.0:
        return escapement
    return replace(escapement, torque=escapement.torque - escapement.spring_rate * turned)


def _constant(escapement: Escapement, turned: float) -> Escapement:
    """The timer with the constant torque that its spring has after an angle turned [rad]."""
    return replace(_after(escapement, turned), spring_rate=0.0)


def _engagements(ask: _Question, turns: float | None, duration: float | None) -> int:
    """How many engagements to run at most."""
    spring = ask.escapement.spring_rate
    if turns is not None and duration is not None:
        raise InvalidValue(
            f"turns and duration must not both be given, got {turns!r} and {duration!r}; "
            "leave one out"
        )
    if turns is not None:
        turns = validate.positive("turns", turns, "give how often the driver turns")
        count = math.ceil(turns * 2.0 * math.pi / ask.cell * (1.0 - 1e-12))
        if count > MOST:
            rule = f"at most {MOST * ask.cell / (2.0 * math.pi):g}, ten million engagements"
            raise validate.fail("turns", rule, turns, "run fewer")
        return count
    if duration is not None:
        duration = validate.positive("duration", duration, "give the time to run")
        # a spring only gets weaker, so that no later period is shorter
        period = terminal(_constant(ask.escapement, 0.0)).period
        return math.ceil(min(duration / period, MOST)) if period > 0.0 else FEW
    if not spring > 0.0:
        raise InvalidValue(
            "turns or duration must be given for a timer without spring_rate, got neither; "
            "without losing torque it never stops"
        )
    return min(math.ceil(ask.spent / ask.cell) + 1, MOST)


def _full(ask: _Question, count: int, duration: float | None, nominal: float) -> Rundown:
    """Every engagement."""
    start = {"initial_speed": ask.initial_speed, "rtol": ask.rtol}
    if duration is None:
        motion = simulate(ask.escapement, count, **start)
    else:
        motion = simulate(ask.escapement, duration=duration, **start)
    return _result(ask, motion.handoff_times, motion, 0.0, 0.0, nominal)


def _result(
    ask: _Question, times: FloatArray, last: Motion, before: float, shift: float, nominal: float
) -> Rundown:
    """The run that ends with a motion, or where the spring is spent in it.

    The driver has turned by `before` [rad] when that motion begins, at the time `shift` [s].
    Behind a spent spring it turns on for a while, of no use to a timer.
    """
    end, turned, status, message = last.end_time, 0.0, last.status, last.message
    start = ask.escapement.mechanism.breaks[0]
    if end > 0.0:
        turned = float(last.at([end]).theta[0]) - start
    if before + turned >= ask.spent:
        turned = ask.spent - before
        brackets = np.concatenate([[0.0], last.handoff_times, [end]])
        at = int(turned / ask.cell)
        angle = turned + start
        end = brentq(lambda t: last.at([t]).theta[0] - angle, brackets[at], brackets[at + 1])
        times, status = times[times <= shift + end], Status.SPENT
    turns = (before + turned) / (2.0 * math.pi)
    if status in (Status.STALL, Status.SPENT):
        reason = "the spring is spent" if status is Status.SPENT else MESSAGES[status]
        message = f"after {turns:.6g} turns, at {shift + end:.6g} s, {reason}"
    return Rundown(ask.escapement, times, nominal, shift + end, turns, "full", 0.0, status, message)


class _Plan(NamedTuple):
    """A run by quasi-static theory: engagements `head` to `late` are sampled, not computed.

    settle : engagements in which a disturbance dies out.
    count : engagements of the run, at most.
    """

    head: int
    late: int
    settle: int
    count: int


def _plan(ask: _Question, count: int, contraction: float) -> _Plan | None:
    """How to sample a run, or None where a disturbance dies out too slowly."""
    timer, rate = ask.escapement, ask.escapement.spring_rate
    late = count
    if rate > 0.0:
        # below this torque the timer stops
        least = _least_torque(timer)
        late = min(count, int((1.0 - _LATE) * (timer.torque - least) / rate / ask.cell))
        contraction = max(contraction, terminal(_constant(timer, late * ask.cell)).contraction)
    if not 0.0 <= contraction < 1.0 or late < 1:
        return None
    settle = 3 + math.ceil(math.log(_FORGOTTEN) / math.log(max(contraction, 1e-100)))
    head = 2 * settle
    return _Plan(head, late, settle, count) if 2 * head < late else None


def _least_torque(timer: Escapement) -> float:
    """Torque below which there is no terminal cycle [N m], to a thousandth."""
    low, high = 0.0, timer.torque
    while high - low > 1e-3 * timer.torque:
        middle = 0.5 * (low + high)
        goes_on = terminal(replace(timer, torque=middle, spring_rate=0.0)).status is Status.OK
        low, high = (low, middle) if goes_on else (middle, high)
    return low


def _sampled(ask: _Question, plan: _Plan, duration: float | None, nominal: float) -> Rundown:
    """The run with most of its engagements from a series."""
    head, late, settle, count = plan

    def root(turned: FloatArray) -> FloatArray:
        """sqrt of the torque in the middle of an engagement: the period follows its inverse."""
        timer = ask.escapement
        return np.sqrt(timer.torque - timer.spring_rate * (turned + 0.5 * ask.cell))

    def scaled(turned: FloatArray) -> FloatArray:
        """Period of the engagement after an angle turned, times that root."""
        ends = (ask.settled(angle, 1, settle).handoff_times[-2:] for angle in turned.tolist())
        return np.array([end - start for start, end in ends]) * root(turned)

    edges = ask.cell * np.array([head, late], dtype=float)
    series = Series(edges, interpolate(scaled(nodes(edges[:1], edges[1:], _ORDER)[0])[None, :]))
    places = np.linspace(*edges, _CHECKS + 2)[1:-1]
    apart = np.abs(series(places) / scaled(places) - 1.0).max()
    first = ask.run(head)
    starts = ask.cell * np.arange(head, late)
    middle = first.end_time + np.cumsum(series(starts) / root(starts))
    last = ask.settled(late * ask.cell, max(count - late, 1), settle)
    shift = float(middle[-1] - last.handoff_times[settle - 1])
    times = np.concatenate([first.handoff_times, middle, last.handoff_times[settle:] + shift])
    run = _result(ask, times, last, (late - settle) * ask.cell, shift, nominal)
    turn, done, goal = ask.cell / (2.0 * math.pi), (Status.OK, MESSAGES[Status.OK]), run.end_time
    if run.times.size >= count:
        goal = float(run.times[count - 1])
    goal = min(goal, duration or math.inf)
    if goal < run.end_time:
        ends = np.append(0.0, run.times), turn * np.arange(run.times.size + 1)
        turns, kept = float(np.interp(goal, *ends)), run.times[run.times <= goal]
        run = replace(
            run, times=kept, end_time=goal, end_turns=turns, status=done[0], message=done[1]
        )
    off = _SAFETY * float(apart) * float(middle[-1] - first.end_time)
    return replace(run, method="quasi-static", uncertainty=off)
