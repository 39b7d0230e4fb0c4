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

from escapement.dynamics import acceleration, bend, contact, contact_moment
from escapement.dynamics import tabulate as tabulate_motion
from escapement.engines.time.crossings import NOTHING, crossings, refine
from escapement.engines.time.solution import Landed, Solution
from escapement.jit import jit
from escapement.mechanisms.slotted import transmission_at
from escapement.model import FloatArray
from escapement.scene import Scene

MOST_STEPS = 25_000
"""Solver steps a piece may take, a second or two; DOP853 needs fifty."""
_LEAST = 1e-30  # an absolute tolerance of zero: no scale of the error is ever 0/0


class NotConverged(Exception):
    """The solver gives up on a piece, or is given up; the argument says why."""


class Options(NamedTuple):
    """How to integrate; `atol` of (angle, speed, loss) or None, natural units."""

    rtol: float
    atol: tuple[float, float, float] | None
    method: str
    max_step: float


@jit(allocates=True)
def _derivative(x, y, scene, anchor, unit, side):
    """Slope of y = (angle from anchor, speed/unit, friction loss/unit^2) over time * unit."""
    out = np.empty(3)
    g, u, dg = transmission_at(scene.path, anchor + y[0])
    w = (unit * y[1]) ** 2
    out[0] = y[1]
    out[1] = acceleration(g, u, dg, w, side, scene) / unit**2
    # signed, so that it stays smooth where a step runs past the reversal
    moment = contact_moment(g, u, dg, w, side, scene)
    out[2] = bend(side, scene) * abs(u) * moment * y[1] / unit**2
    return out


def starting_rate(scene: Scene, theta: float, sign: float) -> float:
    """Acceleration of a driver at rest."""
    g, u, dg = transmission_at(scene.path, theta)
    return acceleration(g, u, dg, 0.0, sign, scene)


def _stops_soon(scene: Scene, start: tuple[float, float, float], end: float) -> bool:
    """Whether the driver, braked as at the start, would stop in the first part of a piece."""
    theta, speed, sign = start
    g, u, dg = transmission_at(scene.path, theta)
    rate = acceleration(g, u, dg, speed**2, sign, scene)
    return bool(-rate * 0.2 * (end - theta) > speed**2)


def solve_piece(
    scene: Scene,
    start: tuple[float, float, float],
    goal: tuple[float, float, float],
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
        Driver angle where the piece ends at the latest, the angle to count from, and
        one at which to see how much is lost [rad].
    horizon : float
        Natural time left.
    options : Options

    Raises
    ------
    NotConverged
        When the solver cannot go on or takes more than `MOST_STEPS`.
    """
    theta, speed, sign = start
    end, anchor, middle = goal
    unit = max(speed, np.sqrt(2.0 * np.pi / (scene.rho + 1.0)))
    # of a driver that is about to stop even the last of its speed counts
    share = speed / unit if speed > 0.0 and _stops_soon(scene, start, end) else 1.0
    piece = _Piece(scene, options, sign, end - anchor, anchor, middle, unit, share)
    y = [theta - anchor, speed / unit, 0.0]
    solved = piece.solve((0.0, horizon * unit), y, events=piece.events())
    grid, rates, forces = piece.looks(solved)
    last, ended = piece.end(solved, grid, forces)
    dense: Any = solved.sol
    join = float(solved.t[max(int(np.searchsorted(solved.t, last)) - 1, 0)])
    if join < last:
        step = min(last - join, options.max_step * unit)
        landing = piece.solve((join, last), dense(join), first_step=step).sol
        if ended in ("arrived", "stopped"):
            y = landing(last)
            short = (piece.way - y[0]) / y[1] if ended == "arrived" else -y[1] / piece.rate(last, y)
            last += float(short)
            # once more: behind its end an interpolant is no good, least of all a short one
            landing = piece.solve((join, last), dense(join), first_step=min(step, last - join)).sol
        dense = Landed(dense, join, landing)
    kept = grid < last
    at_last = piece.rate(last, dense(last))
    times, rates = np.append(grid[kept], last), np.append(rates[kept], at_last)
    extrema = crossings(lambda x: piece.rate(x, dense(x)), times, rates)
    return Solution(
        dense,
        anchor,
        unit,
        last / unit,
        ended,
        [x / unit for x in extrema],
        (float(rates[0]), at_last),
    )


@dataclass(frozen=True)
class _Piece:
    """A piece to be solved: `way` is the scaled angle where it ends at the latest."""

    scene: Scene
    options: Options
    sign: float
    way: float
    anchor: float
    middle: float
    unit: float
    share: float

    @property
    def numbers(self) -> tuple[Any, ...]:
        return (self.scene, self.anchor, self.unit, self.sign)

    def rate(self, x: float, y: FloatArray) -> float:
        """Scaled acceleration."""
        return float(_derivative(x, y, *self.numbers)[1])

    def force(self, y: FloatArray) -> float:
        """A number with the sign of the contact force."""
        g, _u, dg = transmission_at(self.scene.path, self.anchor + y[0])
        return contact(g, dg, (self.unit * y[1]) ** 2, self.scene)

    def events(self) -> Any:
        """Arrival, reversal and stop as solve_ivp's events; the first counts the steps."""
        steps = 0

        def arrive(x: float, y: FloatArray, *_: Any) -> float:
            nonlocal steps
            steps += 1
            if steps > MOST_STEPS:
                raise NotConverged(_too_many_steps(self.options.method))
            return y[0] - self.way

        def reverse(x: float, y: FloatArray, *_: Any) -> float:
            # on a reversal the force is rounding, and a root would be found there again
            return self.sign if x == 0.0 else self.force(y)

        def stop(x: float, y: FloatArray, *_: Any) -> float:
            return y[1]

        events: Any = (arrive, reverse, stop)
        for event, direction in zip(events, (1.0, -self.sign, -1.0), strict=True):
            event.terminal = True
            event.direction = direction
        return events

    def solve(self, span: tuple[float, float], y: Any, **more: Any) -> Any:
        """What solve_ivp answers, with dense output."""
        options = self.options
        # a trial step may leave the domain: its NaN makes the solver take a shorter one
        with np.errstate(all="ignore"):
            solved = solve_ivp(
                _derivative,
                span,
                y,
                dense_output=True,
                args=self.numbers,
                rtol=options.rtol,
                atol=_absolute(self.scene, options, self.unit, self.middle, self.share),
                method=options.method,
                max_step=options.max_step * self.unit,
                **more,
            )
        if solved.status < 0:
            raise NotConverged(f"method {options.method!r} gives up: {solved.message}")
        return solved

    def looks(self, solved: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Times within every step, with the acceleration and the force there."""
        grid = refine(solved.t)
        angle, pace = solved.sol(grid)[:2]
        w = (self.unit * pace) ** 2
        table = np.empty((4, grid.size))
        tabulate_motion(self.scene, angle + self.anchor, w, self.sign, table)
        forces = self.scene.rho * (table[1] * w + self.scene.load) + table[0]
        forces[0] = self.sign * abs(forces[0])  # a start on the reversal itself is not one
        return grid, table[2], forces

    def end(self, solved: Any, grid: FloatArray, forces: FloatArray) -> tuple[float, str]:
        """When the piece ends, and how.

        The solver looks at the ends of its steps only and misses two crossings of the
        force inside one, so its own steps are searched again.
        """
        arrived, reversed_, stopped = (times.size > 0 for times in solved.t_events)
        last = float(grid[-1])

        def force_at(x: float) -> float:
            return self.force(solved.sol(x))

        if reversed_:
            forces[-1] = -self.sign * abs(forces[-1])
            turns = [*crossings(force_at, grid, forces), last]
        else:
            # the force may vanish where the piece ends: next to nothing there is rounding
            if abs(forces[-1]) <= NOTHING * np.abs(forces).max():
                forces[-1] = self.sign * abs(forces[-1])
            turns = crossings(force_at, grid, forces)
        if turns:
            beyond = solved.sol(turns[0])[0] >= self.way
            return turns[0], "arrived" if beyond else "reversed"
        return last, "arrived" if arrived else "stopped" if stopped else "horizon"


def _too_many_steps(method: str) -> str:
    other = "" if method == "DOP853" else " or method 'DOP853'"
    return (
        f"method {method!r} needs more than {MOST_STEPS} steps for a piece of "
        f"the motion; choose a larger rtol, a larger max_step{other}"
    )


def _absolute(
    scene: Scene, options: Options, unit: float, middle: float, share: float
) -> tuple[float, float, float]:
    """Absolute tolerances of the scaled state.

    The terminal cycle is where loss and work agree, so the loss is wanted to its own
    digits, however small it is; `middle` is an angle at which to see how small. `share`
    is how much of the unit of speed there is.
    """
    if options.atol is None:
        g, u, dg = transmission_at(scene.path, middle)
        moment = (scene.rho * abs(dg) + abs(g) / unit**2) / (scene.rho + g * g)
        small = 1e-2 * options.rtol
        scales = (small, small * share, small * scene.mu_plus * abs(u) * moment)
    else:
        angle, speed, loss = options.atol
        scales = (angle, speed / unit, loss / unit**2)
    first, second, third = (max(scale, _LEAST) for scale in scales)
    return first, second, third
