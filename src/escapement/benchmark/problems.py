"""The problems that all solvers solve, their equation, and the solvers that are measured.

Four slots, four pins and Meyer's inertias (1973, Appendix E) under 0.10 in-lbf, twenty
engagements from rest. The answer is the time and the driver speed at each handoff; the
error is the largest relative difference from a reference of twenty digits.

The package's engines get an `Escapement`. A solver without the package gets the textbook's
equation in natural units (inertia of the follower, torque, `clock`). Between entry, dead centre,
the one reversal and the exit the side s of the slot and the direction of sliding are fixed, so p
= g + kappa u with kappa = s mu sign(u):

    theta_ddot = (1 - p g' w) / (rho + g p),      w = theta_dot^2

With n = a cos - 1, L = a^2 + 1 - 2 a cos, g = n/L, u = a sin/L and g' = -(a^2 - 1) u/L
(Meyer 1-7, 1-8) one division is left. The same source serves Python and Numba; the contact
function, whose zero is the reversal, is multiplied by L^2.

A solver turns a problem and a tolerance into a function that runs it once. Costs that occur only
once in repeated runs (building, compiling) belong to the preparation and the first call;
everything else belongs to the run. solve_ivp gets each smooth piece on its own, up to a terminal
event with a direction, so no step crosses a kink and no root at the start of a piece fires again.
Position and speed at an event are those of the dense output, as solve_ivp returns them.
"""

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from escapement.base.units import INCH_POUND
from escapement.engines.simulate import simulate
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement, Inertia
from escapement.numerics.jit import jit

REFERENCE = "reference.json"
"""Data file of this package, written by `benchmarks/make_reference.py`."""


@dataclass(frozen=True)
class Problem:
    """A motion from rest with a known answer.

    Parameters
    ----------
    name, title : str
        Its names in files and in figures.
    friction : float
        Coefficient of friction [-].
    slots : int
        Slots of an external wheel in continuous engagement.
    driver_inertia, follower_inertia : float
        Moments of inertia [kg m^2].
    torque : float
        Driving torque [N m].
    engagements : int
        Handoffs that are compared.
    """

    name: str
    title: str
    friction: float
    slots: int = 4
    driver_inertia: float = 3e-6 * INCH_POUND
    follower_inertia: float = 50e-6 * INCH_POUND
    torque: float = 0.10 * INCH_POUND
    engagements: int = 20

    @cached_property
    def escapement(self) -> Escapement:
        """The problem as the package states it."""
        inertia = Inertia(self.driver_inertia, self.follower_inertia)
        return Escapement(Geneva(self.slots), inertia, self.torque, self.friction)

    @cached_property
    def numbers(self) -> tuple[float, float, float, float]:
        """Centre distance, inertia ratio, friction and half the engagement angle [rad].

        A solver needs only these if the follower's inertia, the torque and `clock` are its units.
        """
        turn = math.pi / self.slots
        ratio = self.driver_inertia / self.follower_inertia
        return 1.0 / math.sin(turn), ratio, self.friction, math.pi / 2.0 - turn

    @property
    def clock(self) -> float:
        """Unit of time of `numbers`, sqrt(I_f / torque) [s]."""
        return math.sqrt(self.follower_inertia / self.torque)

    @cached_property
    def reference(self) -> FloatArray:
        """Handoff times [s] and, in a second row, speeds [rad/s], correctly rounded."""
        text = files(__package__).joinpath(REFERENCE).read_text(encoding="utf-8")
        record = json.loads(text)[self.name]
        # text of twenty digits
        return np.array([record["handoff_times"], record["handoff_velocities"]], dtype=float)

    def error(self, times: FloatArray, speeds: FloatArray) -> float:
        """Largest relative error of handoff times and speeds [-]; NaN where one is missing."""
        if len(times) != self.engagements:
            return math.nan
        return float(np.abs(np.array([times, speeds]) / self.reference - 1.0).max())


PROBLEMS = (
    Problem("meyer", r"four slots, $\mu$ = 0.35", 0.35),
    # the Painleve limit is 0.406079, so the reduced inertia falls to a hundredth
    Problem("near-limit", r"$\mu$ = 0.402, 99 % of the Painlevé limit", 0.402),
)


Answer = tuple[FloatArray, FloatArray]
"""Handoff times [s] and handoff velocities [rad/s]."""
TimedRun = Callable[[], Answer]

METHODS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
"""Methods of solve_ivp."""


SmoothPiece = tuple[tuple[float, float, float], float | None, float | None]
"""A smooth piece of an engagement: its a, rho and kappa, and the driver angles at which it starts
and ends, None for the reversal, whose angle is not known before."""


def pieces_of(problem: Problem) -> list[SmoothPiece]:
    """The pieces of an engagement: to dead centre, to the reversal, and to the handoff."""
    a, rho, mu, end = problem.numbers
    return [((a, rho, -mu), -end, 0.0), ((a, rho, mu), 0.0, None), ((a, rho, -mu), None, end)]


def derivative(t, y, a, rho, kappa):
    """Right-hand side for y = (theta, theta_dot)."""
    theta, speed = y[0], y[1]
    n = a * math.cos(theta) - 1.0
    q = a * a - 1.0
    length = q - 2.0 * n
    slide = a * math.sin(theta)
    p = n + kappa * slide
    square = length * length
    force = square * length + q * p * slide * speed * speed
    return speed, force / (length * (rho * square + n * p))


def reversal(t, y, a, rho, kappa):
    """A function that falls through zero at the pin reversal: X times a positive number."""
    theta, speed = y[0], y[1]
    n = a * math.cos(theta) - 1.0
    q = a * a - 1.0
    return n * (q - 2.0 * n) - rho * q * a * math.sin(theta) * speed * speed


_EQUATIONS = {"Python": (derivative, reversal), "Numba": (jit(derivative), jit(reversal))}


class MeasuredSolver(NamedTuple):
    """A solver that can be measured.

    solver : its name, unique.
    family : "energy", "ivp", "solve_ivp", or the package it comes from.
    method, language : given if a family has several of them.
    loosest, tightest : powers of ten of the tolerances it accepts.
    prepare : makes a run of a problem at a tolerance.
    """

    solver: str
    family: str
    method: str
    language: str
    loosest: int
    tightest: int
    prepare: Callable[[Problem, float], TimedRun]


def package_solvers() -> Iterator[MeasuredSolver]:
    """Both engines, and each method of solve_ivp with the equation in each language."""
    for engine, tightest in (("energy", -13), ("ivp", -12)):
        prepare: Callable[[Problem, float], TimedRun] = partial(_prepare_engine, engine=engine)
        yield MeasuredSolver(engine, engine, "", "Numba", -4, tightest, prepare)
    for method in METHODS:
        for language in _EQUATIONS:
            prepare = partial(_prepare_solve_ivp, method=method, language=language)
            name = f"solve_ivp {method} {language}"
            yield MeasuredSolver(name, "solve_ivp", method, language, -3, -13, prepare)


def _prepare_engine(problem: Problem, rtol: float, engine: str) -> TimedRun:
    """A run by one of the package's engines, called as a user calls it."""
    escapement, engagements = problem.escapement, problem.engagements

    def run() -> Answer:
        motion = simulate(escapement, engagements, engine=engine, rtol=rtol)
        return motion.handoff_times, motion.handoff_velocities

    return run


def _prepare_solve_ivp(problem: Problem, rtol: float, method: str, language: str) -> TimedRun:
    """A run by a method of solve_ivp, with the equation in a language."""
    equation, reverses = _EQUATIONS[language]
    pieces = [(*piece, _event(piece[-1], reverses)) for piece in pieces_of(problem)]
    solve = partial(solve_ivp, equation, method=method, rtol=rtol, atol=rtol)

    def run() -> Answer:
        x, theta, speed = 0.0, 0.0, 0.0
        answer = []
        for _ in range(problem.engagements):
            for parameters, start, _end, event in pieces:
                state = (theta if start is None else start, speed)
                solved = solve((x, math.inf), state, events=event, args=parameters)
                if solved.status != 1:
                    raise ArithmeticError(solved.message)
                x = solved.t_events[0][0]
                theta, speed = solved.y_events[0][0]
            answer.append((x * problem.clock, speed / problem.clock))
        times, speeds = np.array(answer).T
        return times, speeds

    return run


def _event(end: float | None, reverses: Any) -> Any:
    """The terminal event that ends a piece: its last angle, or the reversal."""

    def event(t, y, *parameters):
        return reverses(t, y, *parameters) if end is None else y[0] - end

    marked: Any = event
    marked.terminal, marked.direction = True, -1.0 if end is None else 1.0
    return marked
