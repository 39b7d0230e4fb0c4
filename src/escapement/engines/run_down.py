"""The run-down of a timer: its turns, its rate and the angle at which it stops.

With a spring the driver runs ever more slowly. The engine computes a long run by quasi-static
theory if that is as exact as `rtol`: see `engines.energy.rundown_series`.
"""

import math
import warnings
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import brentq, root_scalar

from escapement.base import validate
from escapement.base.results import Result
from escapement.base.status import MESSAGES, Status
from escapement.base.text import Shown
from escapement.dynamics.motion import Motion
from escapement.engines.simulate import LONGEST, simulate, terminal
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.model.torque_curve import TorqueCurve

MOST = LONGEST["energy"]
"""Engagements of a run."""
ROUNDING = 1e-12
"""Turns that differ by less are equal; angles in radians round them [-]."""
MOST_CELLS = 10_000
"""Greatest number of cells after which the driver may have made whole turns."""
_LATE = 10.0
"""Logarithm of time over target for a torque with which the driver stops on the way."""
ROWS = 11
"""Engagements that are told one by one."""

RUNDOWN = {
    "turns": Result("ratio", "driver turns to the end"),
    "end_time": Result("time", "time to the end"),
    "engagements": Result("ratio", "number of them"),
    "pin_loads": Result("ratio", "load cycles of each pin"),
    "nominal_period": Result("time", "period at the torque of the start"),
    "first_period": Result("time", "duration of the first engagement"),
    "last_period": Result("time", "duration of the last engagement"),
    "rate_error_percent": Result("ratio", "rate over that of the nominal period, minus 1"),
    "lateness": Result("time", "time minus that of as many nominal periods"),
    "target_error": Result("time", "time to the end minus the target"),
    "target_error_percent": Result("ratio", "the same, as a share of the target"),
    "turns_at_target": Result("ratio", "driver turns at the time of the target"),
    "torque_for_target": Result("torque", "torque with which the same turns take that time"),
    "time": Result("time", "end of an engagement"),
    "mean_speed": Result("speed", "mean driver speed over an engagement"),
}
"""What is told of a run."""


@dataclass(frozen=True, eq=False, repr=False)
class Rundown(Shown):
    """A run from its start to the requested turns or time, or to its stop.

    Parameters
    ----------
    escapement : Escapement
        The timer.
    times : array, shape (n,)
        End of each engagement [s], its dwell included.
    nominal_period : float
        Period of the terminal cycle at the torque of the start [s]; NaN where there is none.
    end_time, end_turns : float
        When and where the run ends [s, driver turns].
    status, message : outcome, and its reason in a sentence.
    """

    _units: ClassVar = {"times": "s", "nominal_period": "s", "end_time": "s", "end_turns": "turns"}

    escapement: Escapement = field(repr=False)
    times: FloatArray
    nominal_period: float
    end_time: float
    end_turns: float
    status: Status = Status.OK
    message: str = MESSAGES[Status.OK]

    @cached_property
    def turns(self) -> FloatArray:
        """Driver turns since the start at the end of each engagement, shape (n,)."""
        return np.asarray(turns_before(self.escapement, np.arange(1, self.times.size + 1)))

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
        return 2.0 * math.pi * np.diff(self.turns, prepend=0.0) / self.periods

    @property
    def rate_errors(self) -> FloatArray:
        """Rate over that of the nominal period, minus 1 [-], shape (n,); negative if slow."""
        return self.nominal_period / self.periods - 1.0

    @property
    def lateness(self) -> FloatArray:
        """Time minus that of the same number of nominal periods [s], shape (n,)."""
        return self.times - self.nominal_period * np.arange(1, self.times.size + 1)

    @property
    def columns(self) -> dict[str, FloatArray]:
        """What is told of every engagement, by name."""
        return {
            "turns": self.turns,
            "time": self.times,
            "mean_speed": self.mean_speeds,
            "rate_error_percent": 100.0 * self.rate_errors,
            "lateness": self.lateness,
        }

    def as_dict(self) -> dict[str, Any]:
        """What is told of the run, in SI: `RUNDOWN`, and a few of the engagements."""
        found: dict[str, Any] = {
            "turns": self.end_turns,
            "end_time": self.end_time,
            "engagements": self.times.size,
            "nominal_period": self.nominal_period,
        }
        if self.escapement.pin_length:
            wheel: Any = self.escapement.mechanism
            found["pin_loads"] = math.ceil(self.times.size / wheel.pins)
        if self.times.size:
            chosen = np.unique(np.linspace(0, self.times.size - 1, ROWS).astype(int))
            rows = np.column_stack([*self.columns.values()])[chosen].tolist()
            mean = self.nominal_period * self.times.size / self.times[-1]
            found |= {
                "first_period": self.periods[0],
                "last_period": self.periods[-1],
                "rate_error_percent": 100.0 * (mean - 1),
                "lateness": self.lateness[-1],
                "over_the_turns": [dict(zip(self.columns, row, strict=True)) for row in rows],
            }
        return found | {"status": self.status.label}

    def time_of(self, turns: float) -> float:
        """Time at which the driver has made this number of turns [s].

        Between the ends of two engagements it is interpolated linearly, which neglects the
        variation of the speed within an engagement.

        Raises
        ------
        InvalidValue
            When the run has no such turn.
        """
        turns = validate.number("turns", turns, remedy="give driver turns of the run")
        if turns * (1.0 - ROUNDING) > self.end_turns:
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
    initial_speed: float = 0.0,
    rtol: float | None = None,
) -> Rundown:
    """Let a timer run down.

    With a spring, thousands of engagements are computed from series through a few of them if
    these are as exact as the tolerance; otherwise each is computed. See docs/timer-design.md.

    Parameters
    ----------
    escapement : Escapement
        A timer, with a `spring_rate` or a `TorqueCurve` or without.
    turns : float, optional
        Driver turns to run, > 0; they are rounded up to whole engagements.
    duration : float, optional
        Time to run instead [s], > 0. Without either a spring runs until it is spent or the driver
        stops.
    initial_speed : float
        Driver speed at the first pin entry [rad/s], >= 0.
    rtol : float, optional
        Requested relative error of times, as in `simulate`.

    Returns
    -------
    Rundown
        Its `status` is `stall` or `spent` where the driver stopped on the way.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    spent = _spent_after(escapement)
    if turns is not None and duration is not None:
        raise validate.fail("duration", "left out with turns", duration, "leave one of them out")
    if misfit := escapement.mechanism.misfit:
        none = 0.0, 0.0, Status.INVALID, misfit
        return Rundown(escapement, np.empty(0), math.nan, *none)
    count = None if duration is not None else _engagements(turns, escapement, spent)
    nominal = terminal(escapement.held, rtol=rtol).period
    motion = simulate(escapement, count, duration=duration, initial_speed=initial_speed, rtol=rtol)
    times, status, message = motion.handoff_times, motion.status, motion.message
    whole = times.size
    if status in (Status.OK, Status.SPENT):
        # after the spring is spent the driver turns on for a while, of no use to a timer
        ends = turns_before(escapement, np.arange(1, whole + 1))
        whole = int(np.searchsorted(ends, spent * (1.0 + ROUNDING), side="right"))
    end = float(times[whole - 1]) if whole else 0.0
    driver_angle = float(turns_before(escapement, whole))
    if motion.end_time > end and driver_angle < spent * (1.0 - ROUNDING):
        end, driver_angle = _last_stretch(motion, end, spent)
    if driver_angle >= spent * (1.0 - ROUNDING):
        status = Status.SPENT
    if status in (Status.STALL, Status.SPENT):
        reason = "the spring is spent" if status is Status.SPENT else MESSAGES[status]
        message = f"after {driver_angle:.6g} turns, at {end:.6g} s, {reason}"
    return Rundown(
        escapement,
        times=times[:whole],
        nominal_period=nominal,
        end_time=end,
        end_turns=driver_angle,
        status=status,
        message=message,
    )


def run_against(run: Rundown, target: float, initial_speed: float = 0.0) -> dict[str, float]:
    """How a run compares with the time that it should take [s], by name as in `RUNDOWN`.

    The torque for the target is that at the start, of a curve the greatest; the whole curve changes
    in proportion to it. It is NaN where the driver stops on the way.
    """
    error = run.end_time - target
    reached = rundown(run.escapement, duration=target, initial_speed=initial_speed).end_turns
    return {
        "target_error": error,
        "target_error_percent": 100.0 * error / target,
        "turns_at_target": reached,
        "torque_for_target": _torque_for(run, target, initial_speed),
    }


def _torque_for(run: Rundown, target: float, speed: float) -> float:
    """Torque at the start with which as many turns take the time of the target [N m]."""
    timer: Any = run.escapement
    scaled = {"torque": timer.torque, "spring_rate": timer.spring_rate}
    if run.status not in (Status.OK, Status.SPENT) or not run.end_turns:
        return math.nan

    def excess(root: float) -> float:
        numbers = {name: math.exp(root) * x for name, x in scaled.items()}
        other = rundown(replace(timer, **numbers), turns=run.end_turns, initial_speed=speed)
        short = other.end_turns < run.end_turns * (1.0 - ROUNDING)
        return _LATE if short else math.log(other.end_time / target)

    # without a load the time is inversely proportional to the root of the torque
    guess = 2.0 * math.log(run.end_time / target)
    with warnings.catch_warnings():
        # a driver that stops on the way with both torques has no slope, of which SciPy warns
        warnings.simplefilter("ignore", RuntimeWarning)
        found = root_scalar(excess, x0=guess, x1=guess + 1e-3, method="secant", xtol=1e-10)
    torque = timer.torque.greatest if isinstance(timer.torque, TorqueCurve) else timer.torque
    return float(torque * math.exp(found.root)) if found.converged else math.nan


def turns_before(escapement: Escapement, engagement: Any) -> Any:
    """Driver turns from the start of a motion to an engagement, of which the first is number 0.

    They are counted in cells, so that whole turns are whole numbers.
    """
    cell = escapement.mechanism.cell_angle
    share = _turns_of_cell(cell)
    # an engagement of imperfect parts begins slightly before or after its cell
    delay = escapement.angle_before(engagement) - engagement * cell
    # as floats, because NumPy's integers may overflow
    whole = engagement * float(share.numerator) / float(share.denominator)
    return whole + delay / (2.0 * math.pi)


def _turns_of_cell(cell: float) -> Fraction:
    """Driver turns of a cell of this angle [rad]; a ratio of small whole numbers if it is one."""
    turns = cell / (2.0 * math.pi)
    near = Fraction(turns).limit_denominator(MOST_CELLS)
    return near if abs(near - turns) <= ROUNDING * turns else Fraction(turns)


def _spent_after(escapement: Escapement) -> float:
    """Driver turns after which there is no torque; infinite where there always is."""
    curve = escapement.curve
    if curve is None or curve.periodic or curve.at_rest[-1] > 0.0:
        return math.inf
    last = max(k for k, torque in enumerate(curve.at_rest) if torque > 0.0)
    return float(curve.angle[last + 1]) / (2.0 * math.pi)


def _engagements(turns: float | None, escapement: Escapement, spent: float) -> int:
    """How many engagements to run."""
    share = _turns_of_cell(escapement.mechanism.cell_angle)
    most = float(MOST * share)
    if turns is None:
        if spent == math.inf:
            rule = "given, as turns or as duration, where the torque does not end"
            raise validate.fail("turns", rule, None, "such a timer runs for ever")
        return MOST if spent >= most else min(math.ceil(spent / share) + 1, MOST)
    turns = validate.positive("turns", turns, "give how often the driver turns")
    if turns > most:
        rule = f"at most {most:g}, ten million engagements"
        raise validate.fail("turns", rule, turns, "run fewer")
    least = turns * (1.0 - ROUNDING)
    count = math.ceil(least / share)
    # an engagement of imperfect parts ends slightly before or after its cell
    return count + int(turns_before(escapement, count) < least)


def _last_stretch(motion: Motion, begin: float, spent: float) -> tuple[float, float]:
    """Time [s] and driver turns at which a run ends that goes on after a handoff at `begin` [s].

    It ends with the motion, or where the spring is spent.
    """
    start, end = float(motion.at(0.0).theta), motion.end_time

    def turns(t: float) -> float:
        return (float(motion.at(t).theta) - start) / (2.0 * math.pi)

    driver_angle = turns(end)
    if driver_angle > spent:
        end, driver_angle = brentq(lambda t: turns(t) - spent, begin, end, xtol=1e-300), spent
    return end, driver_angle
