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
from enum import Enum
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

from escapement.engines.time.law import Law, slope
from escapement.model import FloatArray

MOST_STEPS = 25_000
"""Solver steps that a piece may take, a second or two; DOP853 needs fifty."""
_LEAST_ATOL = 1e-30  # with an atol of zero solve_ivp would divide 0 by 0
_PER_STEP = 8
"""Samples of each solver step."""
_FINEST = 1e-18
"""Absolute error of a root, for a piece whose time is of order one."""
_ROUNDING = 1e-9
"""Of the greatest value: less than this at the end of a piece may be rounding."""

RealFunction = Callable[[float], float]


class NotConverged(Exception):
    """The solver failed on a piece, or took too many steps; the argument says why."""


class Options(NamedTuple):
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
    """

    theta: float
    speed: float
    sign: float
    end: float
    anchor: float
    typical: float
    time: float


class Ending(Enum):
    """Why a piece ends: at its goal, at a pin reversal, at rest or at the end of the time."""

    ARRIVED = 1
    REVERSED = 2
    STOPPED = 3
    TIME_UP = 4


@dataclass(frozen=True)
class Solution:
    """A solved piece; times are natural ones since its start.

    dense : state in the piece's units as a function of time * unit.
    length : time that the piece takes.
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
        """Driver angle [rad], speed and friction loss in natural units."""
        y = self.dense(np.maximum(time * self.unit, 0.0))
        return y[0] + self.anchor, y[1] * self.unit, y[2] * self.unit**2


class _Spliced(NamedTuple):
    """Dense output `before` a time `join`, and that of the last step taken again `after` it."""

    before: Any
    join: float
    after: Any

    def __call__(self, x: Any) -> Any:
        return np.where(x < self.join, self.before(x), self.after(x))


def solve_piece(law: Law, task: Task, options: Options) -> Solution:
    """Integrate until the goal, the next pin reversal, a stop or the end of the time.

    Raises
    ------
    NotConverged
        When the solver cannot go on or takes more than `MOST_STEPS`.
    """
    unit = max(task.speed, np.sqrt(2.0 * np.pi / (law.scene.rho + 1.0)))
    problem = _Problem(law, task, options, unit, _absolute_tolerances(law, task, options, unit))
    y = [task.theta - task.anchor, task.speed / unit, 0.0]
    solved = problem.integrate((0.0, task.time * unit), y, events=problem.events())
    times, rates, forces = problem.sample(solved)
    end, ending = problem.find_end(solved, times, forces)
    dense, end = problem.retake_last_step(solved, end, ending)
    # extrema of the speed are roots of the acceleration
    kept = times < end
    last_rate = problem.rate(end, dense(end))
    times, rates = np.append(times[kept], end), np.append(rates[kept], last_rate)
    extrema = _find_roots(lambda x: problem.rate(x, dense(x)), times, rates)
    roots = [x / unit for x in extrema]
    return Solution(dense, task.anchor, unit, end / unit, ending, roots, float(rates[0]), last_rate)


@dataclass(frozen=True)
class _Problem:
    """A piece in its own units, which are those of `law.slope`."""

    law: Law
    task: Task
    options: Options
    unit: float
    atol: tuple[float, float, float]

    @property
    def arguments(self) -> tuple[Any, ...]:
        """What `slope` takes beside x and y."""
        return (self.task.anchor, self.unit, self.task.sign, self.law.plain)

    def rate(self, x: float, y: FloatArray) -> float:
        """Acceleration."""
        return float(slope(x, y, *self.arguments)[1])

    def force(self, y: FloatArray) -> float:
        """A number with the sign of the contact force."""
        return self.law.force(self.task.anchor + y[0], (self.unit * y[1]) ** 2)

    def events(self) -> Any:
        """Arrival, reversal and stop as events of solve_ivp; the first one counts the steps."""
        steps, way, sign = 0, self.task.end - self.task.anchor, self.task.sign

        def arrive(x: float, y: FloatArray, *_: Any) -> float:
            nonlocal steps
            steps += 1
            if steps > MOST_STEPS:
                raise NotConverged(_too_many_steps(self.options.method))
            return float(y[0] - way)

        def reverse(x: float, y: FloatArray, *_: Any) -> float:
            # at a start on a reversal the force is rounding, and its root would fire again
            return sign if x == 0.0 else self.force(y)

        def stop(x: float, y: FloatArray, *_: Any) -> float:
            return float(y[1])

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
            raise NotConverged(f"method {method!r} gives up: {solved.message}")
        return solved

    def sample(self, solved: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Times within every step, and accelerations and forces there, from the dense output."""
        times = _sample_times(solved.t)
        (angle, pace, _loss), sign = solved.sol(times), self.task.sign
        w = (self.unit * pace) ** 2
        rates, forces = self.law.tabulate(angle + self.task.anchor, w, sign)
        # a start on the reversal itself is not another one
        forces[0] = sign * abs(forces[0])
        return times, rates, forces

    def find_end(self, solved: Any, times: FloatArray, forces: FloatArray) -> tuple[float, Ending]:
        """When the piece ends, and why.

        solve_ivp misses two crossings of the force inside one step, so that the force is
        searched again between its steps.
        """
        arrived, reversed_, stopped = (roots.size > 0 for roots in solved.t_events)
        last, sign = float(times[-1]), self.task.sign
        if reversed_:
            # the last sample is the root that solve_ivp found: it counts as beyond it
            forces[-1] = -sign * abs(forces[-1])
        elif abs(forces[-1]) <= _ROUNDING * np.abs(forces).max():
            # the force may vanish at the goal, g = g' = 0, where its sign is rounding
            forces[-1] = sign * abs(forces[-1])
        turns = _find_roots(lambda x: self.force(solved.sol(x)), times, forces)
        if reversed_:
            turns.append(last)
        if turns:
            beyond = solved.sol(turns[0])[0] >= self.task.end - self.task.anchor
            return turns[0], Ending.ARRIVED if beyond else Ending.REVERSED
        if arrived:
            return last, Ending.ARRIVED
        return last, Ending.STOPPED if stopped else Ending.TIME_UP

    def retake_last_step(self, solved: Any, end: float, ending: Ending) -> tuple[Any, float]:
        """Dense output that ends where the piece ends, and when that is.

        The interpolant inside a step is less accurate than the ends of the step. Where an
        event falls into a step, the error of the interpolant would stay in the state, so
        the step is integrated again up to the event.
        """
        dense: Any = solved.sol
        join = float(solved.t[max(int(np.searchsorted(solved.t, end)) - 1, 0)])
        if not join < end:
            return dense, end
        step = min(end - join, self.options.max_step * self.unit)
        last = self.integrate((join, end), dense(join), first_step=step).sol
        if ending in (Ending.ARRIVED, Ending.STOPPED):
            # one Newton step brings the angle to the goal, or the speed to zero
            y, way = last(end), self.task.end - self.task.anchor
            arrived = ending is Ending.ARRIVED
            end += float((way - y[0]) / y[1] if arrived else -y[1] / self.rate(end, y))
            if not end > join:
                raise NotConverged(
                    f"method {self.options.method!r} makes errors greater than a whole step; "
                    "choose a smaller rtol, a smaller atol or a smaller max_step"
                )
            # extrapolated, an interpolant is worthless, most of all that of a short step
            step = min(step, end - join)
            last = self.integrate((join, end), dense(join), first_step=step).sol
        return _Spliced(dense, join, last), end


def _too_many_steps(method: str) -> str:
    other = "" if method == "DOP853" else " or method 'DOP853'"
    return (
        f"method {method!r} needs more than {MOST_STEPS} steps for a piece of "
        f"the motion; choose a larger rtol, a larger max_step{other}"
    )


def _absolute_tolerances(
    law: Law, task: Task, options: Options, unit: float
) -> tuple[float, float, float]:
    """Absolute tolerances of angle, speed and loss in the units of a piece."""
    if options.atol is None:
        g, u, dg = law.transmission(task.typical)
        # The terminal cycle is where loss and work agree (PHYSICS.md 2), so the loss needs
        # digits of its own, however small it is: mu |u| |N R| at a typical angle.
        moment = (law.scene.rho * abs(dg) + abs(g) / unit**2) / (law.scene.rho + g * g)
        small = 1e-2 * options.rtol
        speed = small * (task.speed / unit if _stops_soon(law, task) else 1.0)
        scales = (small, speed, small * law.scene.mu_plus * abs(u) * moment)
    else:
        angle, speed, loss = options.atol
        scales = (angle, speed / unit, loss / unit**2)
    first, second, third = (max(scale, _LEAST_ATOL) for scale in scales)
    return first, second, third


def _stops_soon(law: Law, task: Task) -> bool:
    """Whether the driver, braked as at the start, would stop early in the piece.

    What is left of its speed then decides where it stops.
    """
    braking = -law.acceleration(task.theta, task.speed, task.sign)
    return task.speed > 0.0 and bool(braking * 0.2 * (task.end - task.theta) > task.speed**2)


def _sample_times(steps: FloatArray) -> FloatArray:
    """The ends of a solver's steps, with evenly spaced times inside each."""
    inner = np.arange(_PER_STEP) / _PER_STEP
    times = steps[:-1, None] + np.diff(steps)[:, None] * inner
    return np.append(times.reshape(-1), steps[-1])


def _find_roots(function: RealFunction, x: FloatArray, f: FloatArray) -> list[float]:
    """All roots of `function`, ascending, given its values `f` at `x`.

    solve_ivp compares the signs of an event function at the ends of a step, so that it misses
    two roots inside one step. With a load an engagement may have two pin reversals, as close
    to each other as one likes (PHYSICS.md 2).

    Where |f| has a minimum between values of one sign, that minimum is computed, so that
    a pair of close roots is found. At the ends the sign of `f` counts, whatever the sign
    of the function, which may be rounding there.
    """
    x, f = _add_dips(function, x, f)
    sides = np.sign(f)
    changes = np.nonzero(sides[:-1] * sides[1:] < 0.0)[0]
    return [_root_between(function, float(x[i]), float(x[i + 1])) for i in changes]


def _root_between(function: RealFunction, low: float, high: float) -> float:
    at_low, at_high = function(low), function(high)
    if np.sign(at_low) * np.sign(at_high) < 0.0:
        return float(brentq(function, low, high, xtol=_FINEST, rtol=1e-15, maxiter=500))
    # one end is a root up to rounding, which hides the change of sign
    return low if abs(at_low) < abs(at_high) else high


def _add_dips(
    function: RealFunction, x: FloatArray, f: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Samples, with the minimum of |f| added wherever f may cross zero twice between two."""
    size, sides = np.abs(f), np.sign(f)
    inner = np.nonzero(
        (size[1:-1] <= size[:-2])
        & (size[1:-1] <= size[2:])
        & (sides[:-2] * sides[1:-1] > 0.0)
        & (sides[1:-1] * sides[2:] > 0.0)
        & (size[1:-1] < 0.1 * size.max(initial=0.0))
    )[0]
    # index of each least sample, and how far beyond zero its minimum has to reach
    dips = {int(i): 0.0 for i in inner[::-1] + 1}
    # no sample follows the last one, so that the minimum may lie before it, or be that sample
    if size.size > 1 and sides[-2] * sides[-1] > 0.0 and size[-1] < min(size[-2], 0.1 * size.max()):
        dips = {size.size - 1: _ROUNDING * float(size.max())} | dips
    # from the last to the first, so that an insertion moves no index that is still to come
    for i, depth in dips.items():
        side, low, high = sides[i], x[i - 1], x[min(i + 1, size.size - 1)]
        dip = minimize_scalar(
            lambda at, side=side: side * function(at),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-12 * (high - low)},
        )
        if dip.fun < -depth:
            place = np.searchsorted(x, dip.x)
            x, f = np.insert(x, place, dip.x), np.insert(f, place, side * dip.fun)
    return x, f
