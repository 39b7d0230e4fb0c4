"""The solvers that are measured: the package's two engines and SciPy's solve_ivp.

Each turns a problem and a tolerance into a function that runs it once. What a
user who repeats runs would pay once (building, compiling) belongs to the preparation and
the first call; everything else to the run.

solve_ivp gets each smooth piece on its own, up to a terminal event with a direction, so no
step crosses a kink and no root at the start of a piece fires again. Position and speed at
an event are those of the dense output, as solve_ivp returns them.
"""

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from escapement.benchmark import problems
from escapement.benchmark.problems import Problem, SmoothPiece
from escapement.model import FloatArray
from escapement.simulation import simulate

Answer = tuple[FloatArray, FloatArray]
"""Handoff times [s] and handoff velocities [rad/s]."""
TimedRun = Callable[[], Answer]

METHODS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
"""Those of solve_ivp."""

_EQUATIONS: dict[str, tuple[Any, Any]] = {
    "Python": (problems.derivative, problems.reversal),
    "Numba": (problems.compiled_derivative, problems.compiled_reversal),
}


class MeasuredSolver(NamedTuple):
    """A solver that can be measured.

    solver : its name, unique.
    family : "energy", "ivp", "solve_ivp", or the package it comes from.
    method, language : where a family has several.
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

    @property
    def tolerances(self) -> list[float]:
        """From loose to tight, a decade apart."""
        return [10.0**k for k in range(self.loosest, self.tightest - 1, -1)]


def own_solvers() -> Iterator[MeasuredSolver]:
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
    derivative, reversal = _EQUATIONS[language]
    pieces = [(piece, _event(piece, reversal)) for piece in problems.pieces_of(problem)]
    options = {"method": method, "rtol": rtol, "atol": rtol}

    def run() -> Answer:
        x, theta, speed = 0.0, 0.0, 0.0
        times, speeds = [], []
        for _ in range(problem.engagements):
            for piece, event in pieces:
                start = theta if piece.start is None else piece.start
                solved = solve_ivp(
                    derivative,
                    (x, math.inf),
                    (start, speed),
                    events=event,
                    args=piece.parameters,
                    **options,
                )
                if solved.status != 1:
                    raise ArithmeticError(solved.message)
                x = solved.t_events[0][0]
                theta, speed = solved.y_events[0][0]
            times.append(x)
            speeds.append(speed)
        return np.array(times) * problem.clock, np.array(speeds) / problem.clock

    return run


def _event(piece: SmoothPiece, reversal: Any) -> Any:
    """The terminal event that ends a piece."""
    end = piece.end

    def arrive(t: float, y: FloatArray, *_: float) -> Any:
        return y[0] - end

    def reverse(t: float, y: FloatArray, *parameters: float) -> Any:
        return reversal(t, y, *parameters)

    event: Any = reverse if end is None else arrive
    event.terminal = True
    event.direction = -1.0 if end is None else 1.0
    return event
