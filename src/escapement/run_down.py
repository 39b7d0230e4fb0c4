"""How a timer runs down: its turns, its rate and the place where it stops.

With a spring the driver runs ever more slowly. All engagements are computed one by one, or, of
many, by quasi-static theory, see `quasi_static`.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy.optimize import brentq

from escapement import validate
from escapement.model import Escapement, FloatArray, Run
from escapement.quantity import Choice, Declared, like, quantity, setting
from escapement.quasi_static import Course, Timer, sampled
from escapement.simulation import LONGEST, simulate, terminal
from escapement.status import MESSAGES, Status
from escapement.text import Shown

MOST = LONGEST["energy"]
"""Engagements of a run."""
FEW = 100_000
"""So many engagements are computed one by one unless a method is named; they take half a second."""
METHODS = ("full", "quasi-static")


@dataclass(frozen=True)
class Length(Declared):
    """How far a timer is to run, and how that is computed."""

    turns: float | None = field(default=None, metadata=quantity(
        "driver turns to run, rounded up to whole engagements", exclusive=True, axis=False,
        metavar="N", remedy="give how often the driver turns"
    ))  # fmt: skip
    duration: float | None = field(default=None, metadata=like(Run, "duration", note=", instead"))
    method: str | None = field(default=None, metadata=setting(Choice(
        long_name="full, every engagement, or quasi-static, samples of them", allowed=METHODS,
        metavar="NAME"
    )))  # fmt: skip

    def __post_init__(self) -> None:
        self.check_fields()
        if self.turns is not None and self.duration is not None:
            remedy = "leave one of them out"
            raise validate.fail("duration", "left out beside turns", self.duration, remedy)


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
        When and where the run ends [s, driver turns]. Of a duration by quasi-static theory the
        turns are interpolated between the ends of two engagements.
    method : str
        "full", or "quasi-static" with an estimate of the error.
    uncertainty : float
        Greatest error of a time by that method, beside that of the engine [s]; 0 of "full".
    status, message : outcome, and its reason in a sentence.
    """

    _units: ClassVar = {
        **{name: "s" for name in ("times", "nominal_period", "end_time", "uncertainty")},
        "end_turns": "turns",
    }

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
        return np.asarray(cell * np.arange(1, self.times.size + 1))

    @property
    def remaining_turns(self) -> FloatArray:
        """Driver turns left at the end of each engagement, shape (n,)."""
        return self.end_turns - self.turns

    @cached_property
    def periods(self) -> FloatArray:
        """Duration of each engagement [s], shape (n,)."""
        return np.asarray(np.diff(self.times, prepend=0.0))

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
        known = np.concatenate([[0.0], self.turns, [self.end_turns]])
        times = np.concatenate([[0.0], self.times, [self.end_time]])
        return float(np.interp(turns, known, times))


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
        Time to run instead [s], > 0. Without either a spring runs until it is spent or the driver
        stops.
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
    length = Length(turns, duration, method)
    timer = Timer(escapement, initial_speed, rtol)
    if length.turns is None and length.duration is None and timer.spent == math.inf:
        rule = "given, as turns or as duration, where the torque does not end"
        raise validate.fail("turns", rule, None, "such a timer runs for ever")
    nominal = terminal(escapement.held, rtol=rtol)
    count = _engagements(timer, length, nominal.period)
    course = None
    if length.method == "quasi-static" or (length.method is None and count > FEW):
        course = sampled(timer, count, nominal.contraction)
        if course is None and length.method is not None:
            remedy = "its torque changes too much while a disturbance dies out; leave method out"
            raise validate.fail("method", "'full' for this timer", length.method, remedy)
    if course is None:
        whole = count if length.duration is None else None
        motion = simulate(
            escapement, whole, duration=length.duration, initial_speed=initial_speed, rtol=rtol
        )
        course = Course(motion.handoff_times, motion, 0.0, 0.0, None)
    return _ended(timer, course, nominal.period, count, length.duration)


def _engagements(timer: Timer, length: Length, period: float) -> int:
    """How many engagements to run at most; a spring only gets weaker, so no period is shorter."""
    if length.duration is not None:
        return math.ceil(min(length.duration / period, MOST)) if period > 0.0 else 0
    if length.turns is None:
        return min(math.ceil(timer.spent / timer.cell) + 1, MOST)
    count = math.ceil(length.turns * 2.0 * math.pi / timer.cell * (1.0 - 1e-12))
    if count > MOST:
        rule = f"at most {MOST * timer.cell / (2.0 * math.pi):g}, ten million engagements"
        raise validate.fail("turns", rule, length.turns, "run fewer")
    return count


def _ended(
    timer: Timer, course: Course, nominal: float, count: int, duration: float | None
) -> Rundown:
    """The run up to its goal, to its stop, or to where the spring is spent.

    Behind a spent spring the driver turns on for a while, of no use to a timer.
    """
    times, last, turn = course.times, course.last, timer.cell / (2.0 * math.pi)
    breaks, status, message = timer.escapement.mechanism.breaks, last.status, last.message
    ends = np.concatenate([[0.0], last.handoff_times, [last.end_time]])
    turned = float(last.at(ends[-1:]).theta[0]) - breaks[0] if last.end_time > 0.0 else 0.0
    end = last.end_time
    if course.before + turned >= timer.spent:
        turned, status = timer.spent - course.before, Status.SPENT
        cell, place = int(turned / timer.cell), turned + breaks[0]
        end = brentq(lambda time: last.at([time]).theta[0] - place, ends[cell], ends[cell + 1])
    end, turns = course.shift + end, (course.before + turned) / (2.0 * math.pi)
    goal = duration or (float(times[count - 1]) if times.size >= count else math.inf)
    if goal < end:
        known = np.append(0.0, times)
        turns = float(np.interp(goal, known, turn * np.arange(known.size)))
        end, status, message = goal, Status.OK, MESSAGES[Status.OK]
    if status in (Status.STALL, Status.SPENT):
        reason = "the spring is spent" if status is Status.SPENT else MESSAGES[status]
        message = f"after {turns:.6g} turns, at {end:.6g} s, {reason}"
    method = METHODS[0] if course.uncertainty is None else METHODS[1]
    return Rundown(
        timer.escapement, times[times <= end], nominal, end, turns, method,
        course.uncertainty or 0.0, status, message,
    )  # fmt: skip
