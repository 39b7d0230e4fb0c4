"""solve_ivp, piece by piece, with the events a careful user would give it.

Each smooth piece is integrated on its own up to a terminal event with a direction, so no
step crosses a kink and no root at the start of a piece fires again. Position and speed at
an event are those of the dense output, as solve_ivp returns them.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from escapement.benchmark import equations
from escapement.benchmark.equations import Piece, pieces_of
from escapement.benchmark.problems import Problem
from escapement.model import FloatArray

Answer = tuple[FloatArray, FloatArray]

METHODS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")

_RIGHT_HAND_SIDES: dict[str, tuple[Any, Any]] = {
    "Python": (equations.derivative, equations.reversal),
    "Numba": (equations.compiled_derivative, equations.compiled_reversal),
}


def prepare(problem: Problem, rtol: float, method: str, language: str) -> Callable[[], Answer]:
    """A run of `problem` at a tolerance, by a method, with the equation in a language."""
    derivative, reversal = _RIGHT_HAND_SIDES[language]
    pieces = [(piece, _event(piece, reversal)) for piece in pieces_of(problem)]
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


def _event(piece: Piece, reversal: Any) -> Any:
    """The terminal event that ends a piece."""
    end = piece.end

    def arrive(t: float, y: FloatArray, *_: float) -> float:
        return y[0] - end

    def reverse(t: float, y: FloatArray, *parameters: float) -> float:
        return reversal(t, y, *parameters)

    event: Any = reverse if end is None else arrive
    event.terminal = True
    event.direction = -1.0 if end is None else 1.0
    return event
