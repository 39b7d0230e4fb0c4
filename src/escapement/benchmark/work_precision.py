"""Run time against measured error: every contestant over a sweep of its tolerance."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

from escapement.benchmark.candidates import Answer, Contestant
from escapement.benchmark.problems import Problem
from escapement.benchmark.timing import shortest, timed


class Point(NamedTuple):
    """One contestant at one tolerance.

    problem, contestant, family, method, language : names.
    rtol : tolerance asked for [-].
    error : measured, see `Problem.error` [-].
    time : of a warm run, the shortest seen [s].
    first : preparation and first run in this process [s].
    """

    problem: str
    contestant: str
    family: str
    method: str
    language: str
    rtol: float
    error: float
    time: float
    first: float


def sweep_tolerances(
    problem: Problem,
    field: Sequence[Contestant],
    *,
    decades: int,
    longest: float,
    rounds: int,
) -> list[Point]:
    """Points of all contestants on one problem.

    Parameters
    ----------
    problem : Problem
        What they solve.
    field : sequence of Contestant
        Who takes part.
    decades : int
        Tolerances are this many powers of ten apart.
    longest : float
        A contestant goes on to tighter tolerances while its runs are shorter [s].
    rounds : int
        Turns of each, of which the shortest counts.
    """
    points: list[Point] = []
    runs: list[Callable[[], Answer]] = []
    for contestant in field:
        for rtol in contestant.tolerances[::decades]:
            point, run = _try(contestant, problem, rtol)
            if run is None:
                continue
            points.append(point)
            runs.append(run)
            if point.time > longest:
                break
    times = shortest(runs, rounds)
    return [point._replace(time=time) for point, time in zip(points, times, strict=True)]


def _try(
    contestant: Contestant, problem: Problem, rtol: float
) -> tuple[Point, Callable[[], Answer] | None]:
    """A point timed roughly, and its run; None for a run that fails."""
    point = Point(problem.name, *contestant[:4], rtol, math.nan, math.nan, math.nan)
    try:
        preparing, run = timed(lambda: contestant.prepare(problem, rtol))
        first, answer = timed(run)
    except (ArithmeticError, ValueError):
        return point, None
    error = problem.error(*answer)
    if not error < 0.1:
        return point, None
    again, _ = timed(run)
    return point._replace(error=max(error, 1e-16), time=again, first=preparing + first), run


def time_at(points: Sequence[Point], error: float) -> float:
    """Least time of a contestant for an error [s]; NaN where it never gets there.

    Between its best points the logarithms are interpolated: a tolerance between the
    ones tried would have given what lies between.
    """
    best = _front(points)
    if not best or best[-1].error > error:
        return math.nan
    if best[0].error <= error:
        return best[0].time
    for loose, tight in pairwise(best):
        if tight.error <= error:
            share = math.log(loose.error / error) / math.log(loose.error / tight.error)
            return loose.time * (tight.time / loose.time) ** share
    raise AssertionError("the front falls below the error and never crosses it")


def _front(points: Sequence[Point]) -> list[Point]:
    """Points that no other beats in both time and error, by falling error."""
    front: list[Point] = []
    for point in sorted(points, key=lambda point: (point.error, point.time)):
        if not front or point.time < front[-1].time:
            front.append(point)
    return front[::-1]
