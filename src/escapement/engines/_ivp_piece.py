"""One smooth piece of a motion by solve_ivp, in units fitting that piece.

Within a piece one side of the slot carries the force and the transmission is
analytic. The angle is counted from the end of the piece at which the follower
is slow: there a light driver speeds up within an angle of sqrt(rho), and the
digits of the angle are wanted. Speeds are divided by `unit`, that of the start
or what the torque gives the driver over a cell, so that every piece takes a
time of order one and absolute tolerances mean the same at any speed.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from escapement._jit import jit
from escapement.dynamics import acceleration, bend, contact, contact_moment
from escapement.dynamics import tabulate as tabulate_motion
from escapement.engines._ivp_crossings import crossings, refine
from escapement.mechanisms._slotted import transmission_at
from escapement.model import FloatArray

MOST_STEPS = 25_000
"""Solver steps a piece may take, a second or two; DOP853 needs fifty."""
_LEAST = 1e-30  # an absolute tolerance of zero: no scale of the error is ever 0/0


class NotConverged(Exception):
    """The solver gives up on a piece, or is given up; the argument says why."""


class Scene(NamedTuple):
    """What the equation of motion needs to know, in natural units."""

    path: FloatArray
    rho: float
    mu: tuple[float, float]
    load: float


class Options(NamedTuple):
    """How to integrate; `atol` of (angle, speed, loss) or None, natural units."""

    rtol: float
    atol: tuple[float, float, float] | None
    method: str
    max_step: float


@jit
def _derivative(x, y, path, anchor, unit, sign, rho, mu, load):
    """Slope of y = (angle from anchor, speed/unit, friction loss/unit^2) over time * unit."""
    out = np.empty(3)
    g, u, dg = transmission_at(path, anchor + y[0])
    w = (unit * y[1]) ** 2
    out[0] = y[1]
    out[1] = acceleration(g, u, dg, w, sign, rho, mu, load) / unit**2
    # signed, so that it stays smooth where a step runs past the reversal
    moment = contact_moment(g, u, dg, w, sign, rho, mu, load)
    out[2] = bend(sign, mu) * abs(u) * moment * y[1] / unit**2
    return out


@dataclass(frozen=True)
class Solution:
    """A piece as solved: what became of it, and any state within.

    Times are natural ones since its start. `ended` is "arrived", "reversed",
    "stopped" or "horizon"; extrema are times, `rates` the acceleration after the
    start and before the end.
    """

    dense: Any
    anchor: float
    unit: float
    length: float
    ended: str
    extrema: list[float]
    rates: tuple[float, float]

    def __call__(self, time: Any) -> tuple[Any, Any, Any]:
        """Driver angle [rad], speed and friction loss; natural units."""
        y = self.dense(np.maximum(time * self.unit, 0.0))
        return y[0] + self.anchor, y[1] * self.unit, y[2] * self.unit**2


@dataclass(frozen=True)
class _Landed:
    """Dense output with its last step taken anew, to end where the piece ends.

    The interpolant inside a step is a less accurate one than the step itself, and
    where an event falls into a step that runs on beyond it, the error would stay.
    """

    before: Any
    join: float
    landing: Any

    def __call__(self, x: Any) -> Any:
        return np.where(x < self.join, self.before(x), self.landing(x))


@dataclass(frozen=True)
class Free:
    """Driver turning alone under the torque: exact."""

    theta: float
    speed: float
    rho: float
    length: float = np.inf

    def __call__(self, time: Any) -> tuple[Any, Any, Any]:
        """Driver angle [rad], speed and friction loss; natural units."""
        theta = self.theta + time * (self.speed + time / (2.0 * self.rho))
        return theta, self.speed + time / self.rho, 0.0 * time


def starting_rate(scene: Scene, theta: float, sign: float) -> float:
    """Acceleration of a driver at rest."""
    g, u, dg = transmission_at(scene.path, theta)
    return acceleration(g, u, dg, 0.0, sign, scene.rho, scene.mu, scene.load)


def solve_piece(
    scene: Scene,
    start: tuple[float, float, float],
    goal: tuple[float, float],
    horizon: float,
    options: Options,
) -> Solution:
    """Integrate until the goal, the next pin reversal, a stop or the horizon.

    Parameters
    ----------
    scene : Scene
    start : tuple
        Driver angle [rad], speed [natural] and side of the slot.
    goal : tuple
        Driver angle where the piece ends at the latest, and the angle to count
        from [rad].
    horizon : float
        Natural time left.
    options : Options

    Raises
    ------
    NotConverged
        When the solver cannot go on or takes more than `MOST_STEPS`.
    """
    theta, speed, sign = start
    end, anchor = goal
    path, rho, mu, load = scene
    unit = max(speed, np.sqrt(2.0 * np.pi / (rho + 1.0)))
    numbers = (path, anchor, unit, sign, rho, mu, load)
    steps = 0

    def arrive(x: float, y: FloatArray, *_: Any) -> float:
        nonlocal steps
        steps += 1
        if steps > MOST_STEPS:
            other = "" if options.method == "DOP853" else " or method 'DOP853'"
            raise NotConverged(
                f"method {options.method!r} needs more than {MOST_STEPS} steps for a piece of "
                f"the motion; choose a larger rtol, a larger max_step{other}"
            )
        return y[0] - (end - anchor)

    def reverse(x: float, y: FloatArray, *_: Any) -> float:
        g, _u, dg = transmission_at(path, anchor + y[0])
        return contact(g, dg, (unit * y[1]) ** 2, rho, load)

    def stop(x: float, y: FloatArray, *_: Any) -> float:
        return y[1]

    def solve(span: tuple[float, float], y: Any, **more: Any) -> Any:
        # a trial step may leave the domain: its NaN makes the solver take a shorter one
        with np.errstate(all="ignore"):
            solved = solve_ivp(
                _derivative,
                span,
                y,
                dense_output=True,
                args=numbers,
                rtol=options.rtol,
                atol=_absolute(scene, options, unit, 0.5 * (theta + end)),
                method=options.method,
                max_step=options.max_step * unit,
                **more,
            )
        if solved.status < 0:
            raise NotConverged(f"method {options.method!r} gives up: {solved.message}")
        return solved

    events: Any = (arrive, reverse, stop)
    for event, direction in zip(events, (1.0, -sign, -1.0), strict=True):
        event.terminal = True
        event.direction = direction
    solved = solve((0.0, horizon * unit), [theta - anchor, speed / unit, 0.0], events=events)
    arrived, reversed_, stopped = (times.size > 0 for times in solved.t_events)
    grid = refine(solved.t)
    table = np.empty((4, grid.size))
    angle, pace = solved.sol(grid)[:2]
    tabulate_motion(path, angle + anchor, (unit * pace) ** 2, sign, rho, mu, load, table)
    force = rho * (table[1] * (unit * pace) ** 2 + load) + table[0]
    force[0] = sign * abs(force[0])  # a start on the reversal itself is not one

    def force_at(x: float) -> float:
        return reverse(x, solved.sol(x))

    last = float(grid[-1])
    ended = "arrived" if arrived else "stopped" if stopped else "horizon"
    # the solver looks at the ends of its steps only and misses two crossings inside one
    if reversed_:
        force[-1] = -sign * abs(force[-1])
        turns = [*crossings(force_at, grid, force), last]
    else:
        turns = crossings(force_at, grid[:-1], force[:-1])
    if turns:
        beyond = solved.sol(turns[0])[0] >= end - anchor
        last, ended = turns[0], "arrived" if beyond else "reversed"
    dense: Any = solved.sol
    join = float(solved.t[max(int(np.searchsorted(solved.t, last)) - 1, 0)])
    if join < last:
        again = solve(
            (join, last), dense(join), first_step=min(last - join, options.max_step * unit)
        )
        dense = _Landed(dense, join, again.sol)
        if ended == "arrived":
            y = dense(last)
            last += float((end - anchor - y[0]) / y[1])

    def rate_at(x: float) -> float:
        return float(_derivative(x, dense(x), *numbers)[1])

    kept = grid <= last
    extrema = crossings(rate_at, grid[kept], table[2, kept])
    return Solution(
        dense,
        anchor,
        unit,
        last / unit,
        ended,
        [x / unit for x in extrema],
        (float(table[2, 0]), rate_at(last)),
    )


def _absolute(
    scene: Scene, options: Options, unit: float, middle: float
) -> tuple[float, float, float]:
    """Absolute tolerances of the scaled state.

    The terminal cycle is where loss and work agree, so the loss is wanted to its own
    digits, however small it is; `middle` is an angle at which to see how small.
    """
    if options.atol is None:
        g, u, dg = transmission_at(scene.path, middle)
        moment = (scene.rho * abs(dg) + abs(g) / unit**2) / (scene.rho + g * g)
        small = 1e-2 * options.rtol
        scales = (small, small, small * scene.mu[0] * abs(u) * moment)
    else:
        angle, speed, loss = options.atol
        scales = (angle, speed / unit, loss / unit**2)
    first, second, third = (max(scale, _LEAST) for scale in scales)
    return first, second, third
