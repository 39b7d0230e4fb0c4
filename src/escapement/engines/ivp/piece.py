"""One smooth piece of a motion by solve_ivp, in units that fit the piece.

Within a piece one side of the slot carries the force and the transmission is
analytic. The angle is counted from the end of the piece at which the follower
is slow: there a light driver speeds up within an angle of sqrt(rho), and the
digits of the angle are needed. Speeds are divided by `unit`, the speed at the start
or that which the torque gives the driver over a cell, so that every piece takes a
time of order one and absolute tolerances mean the same at any speed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import OdeSolution, solve_ivp

from escapement.dynamics.codes import Ending
from escapement.dynamics.law import settled as _settled
from escapement.dynamics.state_table import LawTable
from escapement.engines.ivp.law import SceneLaw, slope
from escapement.mechanisms.protocol import FloatArray
from escapement.numerics import search
from escapement.numerics.jit import as_python

settled = as_python(_settled)
MOST_STEPS = 25_000
"""Solver steps that a piece may take, a second or two; DOP853 needs fifty."""
_LEAST_ATOL = 1e-30  # with an atol of zero solve_ivp would divide 0 by 0
_PER_STEP = 8
"""Samples of each solver step."""
_RETAKES = 5
"""How often the last step of a piece is repeated; two times are enough."""
_NEARLY = 1e-3
"""Share of a step by which its end may be shifted without another integration."""
_ROUNDING = 1e-9
"""A value at the end of a piece below this share of the greatest value may be rounding."""
_NUDGE = 1e-7
"""Time over which the growth of the force is measured, for a piece whose time is of order one."""


class NotConverged(Exception):
    """The solver failed on a piece, or took too many steps; the argument says why."""


class Tolerances(NamedTuple):
    """Tolerances and method; `atol` of (angle, speed, loss) or None, in natural units."""

    rtol: float
    atol: tuple[float, float, float] | None
    method: str
    max_step: float


class Task(NamedTuple):
    """Where a piece begins, and how far it may reach.

    theta, speed, sign : driver angle [rad], speed and side of the slot at its start.
    end : driver angle where it ends at the latest [rad].
    anchor : driver angle to count from [rad].
    typical : driver angle at which the friction loss has its usual size [rad].
    time : natural time left.
    gap : distance up to which breaks and events are at one angle [rad].
    """

    theta: float
    speed: float
    sign: float
    end: float
    anchor: float
    typical: float
    time: float
    gap: float


@dataclass(frozen=True)
class Solution:
    """A solved piece; times are natural ones since its start.

    dense : state in the piece's units as a function of time * unit.
    length : time that the piece takes. ending : ARRIVED at its goal, REVERSED, STOPPED, or OVER.
    extrema : times at which the driver's acceleration vanishes.
    first_rate, last_rate : sign of the acceleration after the start and before the end.
    """

    dense: Any
    anchor: float
    unit: float
    length: float
    ending: Ending
    extrema: list[float]
    first_rate: float
    last_rate: float

    def state(self, time: Any) -> tuple[Any, Any, Any]:
        """Driver angle [rad], speed and losses in natural units."""
        y = self.dense(np.maximum(time * self.unit, 0.0))
        return y[0] + self.anchor, y[1] * self.unit, y[2:] * self.unit**2


def solve_piece(law: SceneLaw, task: Task, options: Tolerances) -> Solution:
    """Integrate until the goal, the next pin reversal, a stop or the end of the time.

    Raises
    ------
    NotConverged
        When the solver cannot go on or takes more than `MOST_STEPS`.
    """
    unit = max(task.speed, np.sqrt(2.0 * np.pi / (law.scene.rho + 1.0)))
    problem = _Problem(law, task, options, unit, _absolute_tolerances(law, task, options, unit))
    y = np.zeros(2 + law.losses.size)
    y[:2] = task.theta - task.anchor, task.speed / unit
    solved = problem.integrate((0.0, task.time * unit), y, events=problem.events())
    times, rates, forces = problem.sample(solved)
    end, ending = problem.find_end(solved, times, forces)
    dense, end = problem.retake_last_step(solved, end, ending)
    # extrema of the speed are roots of the acceleration
    kept = times < end
    # a sample that is as good as at the end is none
    kept &= (times <= times[0]) | (dense(times)[0] < dense(end)[0] - task.gap)
    times, rates = np.append(times[kept], end), np.append(rates[kept], problem.rate(dense(end)))
    angles = dense(times[[0, 1, -2, -1]])[0]
    rates[0] = _beside(rates[0], rates[1], angles[1] - angles[0], task.gap)
    rates[-1] = last_rate = _beside(rates[-1], rates[-2], angles[3] - angles[2], task.gap)
    if not task.sign and law.is_steady:
        # A locked follower leaves a law of the speed alone: the acceleration keeps its sign, though
        # at the speed where drag balances the drive rounding changes it.
        rates[:] = last_rate = rates[0]
    roots = [x / unit for x in _roots(problem.rate, dense, times, rates)]
    first = float(rates[np.argmax(rates != 0.0)])
    return Solution(
        dense=dense,
        anchor=task.anchor,
        unit=unit,
        length=end / unit,
        ending=ending,
        extrema=roots,
        first_rate=first,
        last_rate=last_rate,
    )


@dataclass(frozen=True)
class _Problem:
    """A piece in its own units, which are those of `law.slope`."""

    law: SceneLaw
    task: Task
    options: Tolerances
    unit: float
    atol: FloatArray

    @cached_property
    def arguments(self) -> tuple[Any, ...]:
        """What `slope` takes in addition to x and y."""
        task, law = self.task, self.law
        middle = 0.5 * (task.theta + task.end)
        signs = law.signs(middle, task.sign) if task.sign else (0.0, 0.0)
        return (task.anchor, self.unit, task.sign, *signs, law.losses, law.plain)

    @property
    def begun(self) -> float:
        """Angle up to which the force behind a reversal, where the piece starts, is rounding."""
        return self.task.theta - self.task.anchor + self.task.gap

    def rate(self, y: FloatArray) -> float:
        """Acceleration."""
        return float(slope(0.0, y, *self.arguments)[1])

    def force(self, y: FloatArray) -> float:
        """A number with the sign of the contact force."""
        if y[0] <= self.begun:
            return self.task.sign or 1.0
        angle, w = self.task.anchor + y[0], (self.unit * y[1]) ** 2
        return self.law.force(angle, w, self.task.sign)

    def pace(self, y: FloatArray) -> float:
        """Speed above that at which the driver counts as at rest."""
        return float(y[1] - self.law.rest(self.task.anchor + y[0], self.task.sign) / self.unit)

    def events(self) -> Any:
        """Arrival, reversal and stop as events of solve_ivp; the first one counts the steps."""
        steps, length, sign = 0, self.task.end - self.task.anchor, self.task.sign

        def arrive(x: float, y: FloatArray, *_: Any) -> float:
            nonlocal steps
            steps += 1
            if steps > MOST_STEPS:
                raise NotConverged(_too_many_steps(self.options.method))
            return float(y[0] - length)

        def reverse(x: float, y: FloatArray, *_: Any) -> float:
            # at the start it has the sign of the piece, so that the root there does not fire again
            return self.force(y)

        def stop(x: float, y: FloatArray, *_: Any) -> float:
            return self.pace(y)

        events: Any = (arrive, reverse, stop)
        for event, direction in zip(events, (1.0, -sign, -1.0), strict=True):
            event.terminal = True
            # without a direction the root at the start of a piece would end it at once
            event.direction = direction
        return events

    def integrate(self, span: tuple[float, float], y: Any, **more: Any) -> Any:
        """The result of solve_ivp, with dense output."""
        method, more["max_step"] = self.options.method, self.options.max_step * self.unit
        more |= {"rtol": self.options.rtol, "atol": self.atol, "dense_output": True}
        # A trial step may leave the angles at which the transmission is defined. The solver
        # answers the NaN that it gets there with a shorter step.
        with np.errstate(all="ignore"):
            solved = solve_ivp(slope, span, y, method, args=self.arguments, **more)
        if solved.status < 0:
            raise NotConverged(f"method {method!r} failed: {solved.message}")
        return solved

    def sample(self, solved: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Times within every step, and accelerations and forces there, from the dense output."""
        times, steps = _sample_times(solved.t), solved.sol.interpolants
        within = zip(steps, times[:-1].reshape(-1, _PER_STEP), strict=True)
        states = np.hstack([*(step(inner) for step, inner in within), solved.y[:, -1:]])
        (angle, pace), sign = states[:2], self.task.sign or 1.0
        w = (self.unit * pace) ** 2
        law = LawTable(*self.law.table(angle + self.task.anchor, w, self.task.sign))
        forces: Any = law.pressing if self.task.sign else np.ones(times.size)
        # the reversal at which a piece starts does not count again, however short the first steps
        begun = angle <= self.begun
        forces[begun] = sign * np.abs(forces[begun])
        return times, np.asarray(law.rate), forces

    def find_end(self, solved: Any, times: FloatArray, forces: FloatArray) -> tuple[float, Ending]:
        """When the piece ends, and why.

        solve_ivp misses two crossings of the force inside one step, so that the force is
        searched again between its steps.
        """
        arrived, reversed_, stopped = (roots.size > 0 for roots in solved.t_events)
        last, sign = float(times[-1]), self.task.sign or 1.0
        if reversed_:
            # the last sample is the root that solve_ivp found: it counts as beyond it
            forces[-1] = -sign * abs(forces[-1])
        elif abs(forces[-1]) <= _ROUNDING * np.abs(forces).max():
            # the force may vanish at the goal, g = g' = 0, where its sign is rounding
            forces[-1] = sign * abs(forces[-1])
        turns = _roots(self.force, solved.sol, times, forces)
        if reversed_:
            turns.append(last)
        if turns:
            # a reversal at the goal belongs to the next piece
            beyond = solved.sol(turns[0])[0] >= self.task.end - self.task.anchor - self.task.gap
            return turns[0], Ending.ARRIVED if beyond else Ending.REVERSED
        if arrived:
            return last, Ending.ARRIVED
        return last, Ending.STOPPED if stopped else Ending.OVER

    def retake_last_step(self, solved: Any, end: float, ending: Ending) -> tuple[Any, float]:
        """Dense output that ends where the piece ends, and when that is.

        The interpolant inside a step is less accurate than the ends of the step. Where an
        event falls into a step, the error of the interpolant would stay in the state, so
        the step is integrated again up to the event, which is then a little off.
        """
        dense: Any = solved.sol
        whole = max(int(np.searchsorted(solved.t, end)) - 1, 0)
        join = float(solved.t[whole])
        if not join < end:
            return dense, end
        start, step = dense(join), np.inf
        for _ in range(_RETAKES):
            step = min(step, end - join, self.options.max_step * self.unit)
            last = self.integrate((join, end), start, first_step=step).sol
            shift = self.correction(last(end), ending)
            near = abs(shift) <= _NEARLY * (last.ts[-1] - last.ts[-2])
            if ending is Ending.REVERSED and not near:
                # the force only touches zero, and has no root by which to shift the end
                break
            if not end + shift > join:
                raise NotConverged(
                    f"the error of method {self.options.method!r} is larger than a whole step; "
                    "choose a smaller rtol, a smaller atol or a smaller max_step"
                )
            end += shift
            # extrapolated further, an interpolant is useless, above all that of a short step
            if near:
                end += self.correction(last(end), ending)
                break
        times = np.append(solved.t[: whole + 1], last.ts[1:])
        steps = dense.interpolants[:whole] + last.interpolants
        return OdeSolution(times, steps, alt_segment=dense.side == "right"), end

    def correction(self, y: FloatArray, ending: Ending) -> float:
        """By how much later than at `y` the piece ends, by one step of Newton's method."""
        if ending is Ending.OVER:
            return 0.0
        if ending is Ending.ARRIVED:
            return float((self.task.end - self.task.anchor - y[0]) / y[1])
        rates = slope(0.0, y, *self.arguments)
        vanishes = self.pace if ending is Ending.STOPPED else self.force
        value = vanishes(y)
        growth = (vanishes(y + _NUDGE * rates) - value) / _NUDGE
        return -value / growth if growth else np.inf


def _roots(
    function: Callable[[FloatArray], float], dense: Any, x: FloatArray, f: FloatArray
) -> list[float]:
    """All roots of a function of the state along the dense output, given its values at times.

    solve_ivp compares the signs of an event function at the ends of a step, so that it misses two
    roots inside one step. With a load an engagement may have two pin reversals, at any distance
    from each other.
    """

    def between(low: float, high: float) -> Callable[[float], float]:
        inside = dense.ts[1:-1].searchsorted(0.5 * (low + high))
        step = dense.interpolants[inside]
        # around the end of a step the dense output chooses between two
        inner = dense.ts[inside] <= low and high <= dense.ts[inside + 1]
        return lambda time: function(step(time) if inner else dense(time))

    return search.roots(between, x, f, _ROUNDING)


def _beside(value: float, other: float, distance: float, gap: float) -> float:
    """An acceleration at an end of a piece, or the `other` where it has that one's sign close by.

    Next to an end rounding decides on the position of an extremum, which belongs to the end.
    """
    return value if settled(value, other, distance, gap) else other


def _too_many_steps(method: str) -> str:
    other = "" if method == "DOP853" else " or method 'DOP853'"
    return (
        f"method {method!r} needs more than {MOST_STEPS} steps between two events of "
        f"the motion; choose a larger rtol, a larger max_step{other}"
    )


def _absolute_tolerances(law: SceneLaw, task: Task, options: Tolerances, unit: float) -> FloatArray:
    """Absolute tolerances of angle, speed and losses in the units of a piece."""
    scales = np.empty(2 + law.losses.size)
    if options.atol is None:
        # The terminal cycle is where losses and work agree, so each loss needs digits of its
        # own, however small it is: those at a typical angle, at rest and at the unit of speed.
        # The contact force may vanish at one of the two.
        rates = [law.loss_rates(task.typical, w, task.sign) for w in (0.0, unit**2)]
        small = 1e-2 * options.rtol
        speed = small * (task.speed / unit if _stops_soon(law, task) else 1.0)
        scales[:2] = small, speed
        scales[2:] = small * np.abs(rates).max(axis=0, initial=0.0) / unit**2
    else:
        angle, speed, loss = options.atol
        scales[:] = loss / unit**2
        scales[:2] = angle, speed / unit
    return np.maximum(scales, _LEAST_ATOL)


def _stops_soon(law: SceneLaw, task: Task) -> bool:
    """Whether the driver, braked as at the start, would stop early in the piece.

    The rest of its speed then determines where it stops.
    """
    braking = -law.acceleration(task.theta, task.speed, task.sign)
    return task.speed > 0.0 and bool(braking * 0.2 * (task.end - task.theta) > task.speed**2)


def _sample_times(steps: FloatArray) -> FloatArray:
    """The ends of a solver's steps, with evenly spaced times inside each."""
    inner = np.arange(_PER_STEP) / _PER_STEP
    times = steps[:-1, None] + np.diff(steps)[:, None] * inner
    return np.append(times.reshape(-1), steps[-1])
