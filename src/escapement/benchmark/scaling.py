"""How the cost grows with engagements, cases and workers.

Engagements and cases by processor time of one core, workers by the wall.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from escapement.benchmark.problems import Problem
from escapement.benchmark.timing import shortest, timed, wall
from escapement.simulation import simulate
from escapement.solver import ENGINES
from escapement.study.sweep import sweep


class Cost(NamedTuple):
    """Shortest time [s] of one size.

    against : "engagements", "cases" or "workers".
    engine : which one.
    size : how many.
    items : engagements or cases computed.
    time : in all [s].
    """

    against: str
    engine: str
    size: int
    items: int
    time: float


def against_engagements(
    problem: Problem, counts: Sequence[int], longest: float, rounds: int
) -> list[Cost]:
    """One motion of each length by each engine, up to runs of `longest` [s]."""
    costs, calls = [], []
    for engine in ENGINES:
        by_item = 0.0
        for count in counts:
            if by_item * count > longest:
                break

            def call(engine: str = engine, count: int = count) -> object:
                return simulate(problem.escapement, count, engine=engine)

            call()
            time, _ = timed(call)
            by_item = time / count
            costs.append(Cost("engagements", engine, count, count, time))
            calls.append(call)
    times = shortest(calls, rounds)
    return [cost._replace(time=time) for cost, time in zip(costs, times, strict=True)]


def against_cases(problem: Problem, counts: Sequence[int], rounds: int) -> list[Cost]:
    """Figures of merit of batches of different frictions on one core."""
    calls = [lambda count=count: _batch(problem, count, 1) for count in counts]
    times = shortest(calls, rounds)
    return [
        Cost("cases", "energy", count, count, time)
        for count, time in zip(counts, times, strict=True)
    ]


def against_workers(
    problem: Problem, workers: Sequence[int], cases: int, rounds: int
) -> list[Cost]:
    """One batch on different numbers of threads."""
    calls = [lambda count=count: _batch(problem, cases, count) for count in workers]
    times = shortest(calls, rounds, wall)
    return [
        Cost("workers", "energy", count, cases, time)
        for count, time in zip(workers, times, strict=True)
    ]


def _batch(problem: Problem, cases: int, workers: int) -> object:
    friction = problem.friction * np.linspace(0.2, 1.0, cases)
    return sweep(problem.escapement, workers=workers, friction=friction)
