"""The package's own engines, called as a user calls them."""

from collections.abc import Callable

from escapement.benchmark.problems import Problem
from escapement.model import FloatArray
from escapement.simulation import simulate


def prepare(
    problem: Problem, rtol: float, engine: str
) -> Callable[[], tuple[FloatArray, FloatArray]]:
    """A run of `problem` at a tolerance by one of the engines."""
    escapement, engagements = problem.escapement, problem.engagements

    def run() -> tuple[FloatArray, FloatArray]:
        motion = simulate(escapement, engagements, engine=engine, rtol=rtol)
        return motion.handoff_times, motion.handoff_velocities

    return run
