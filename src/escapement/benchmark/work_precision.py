"""Run time against measured error: every solver over a sweep of its tolerance."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from escapement.benchmark.measuring import shortest, timed
from escapement.benchmark.problems import Problem
from escapement.benchmark.solvers import MeasuredSolver, TimedRun
from escapement.solver import DEFAULT_RTOL

COMPARED_AT = 1e-10
"""Error at which solvers are compared [-]."""


class Point(NamedTuple):
    """One solver at one tolerance.

    problem, solver, family, method, language : names.
    rtol : tolerance asked for [-].
    error : measured, see `Problem.error` [-].
    time : of a warm run, the shortest seen [s].
    first : preparation and first run in this process [s].
    """

    problem: str
    solver: str
    family: str
    method: str
    language: str
    rtol: float
    error: float
    time: float
    first: float


def sweep_tolerances(
    problem: Problem,
    solvers: Sequence[MeasuredSolver],
    *,
    decades: int,
    longest: float,
    rounds: int,
) -> list[Point]:
    """Points of all solvers on one problem.

    Parameters
    ----------
    problem : Problem
        What they solve.
    solvers : sequence of MeasuredSolver
        The solvers to measure.
    decades : int
        Tolerances are this many powers of ten apart.
    longest : float
        A solver goes on to tighter tolerances while its runs are shorter [s].
    rounds : int
        Turns of each, of which the shortest counts.
    """
    points: list[Point] = []
    runs: list[TimedRun] = []
    for solver in solvers:
        for rtol in solver.tolerances[::decades]:
            point, run = _try(solver, problem, rtol)
            if run is None:
                continue
            points.append(point)
            runs.append(run)
            if point.time > longest:
                break
    times = shortest(runs, rounds)
    return [point._replace(time=time) for point, time in zip(points, times, strict=True)]


def _try(solver: MeasuredSolver, problem: Problem, rtol: float) -> tuple[Point, TimedRun | None]:
    """A point timed roughly, and its run; None for a run that fails."""
    point = Point(problem.name, *solver[:4], rtol, math.nan, math.nan, math.nan)
    try:
        preparing, run = timed(lambda: solver.prepare(problem, rtol))
        first, answer = timed(run)
    except (ArithmeticError, ValueError):
        return point, None
    error = problem.error(*answer)
    if not error < 0.1:
        return point, None
    again, _ = timed(run)
    return point._replace(error=max(error, 1e-16), time=again, first=preparing + first), run


class Standing(NamedTuple):
    """A solver beside `energy` on one problem.

    problem, solver : names.
    error : at which its time is taken; of `energy`, what a call without a
        tolerance really has [-].
    time : [s]. ratio : over the time of `energy` [-].
    first : preparation and first run in this process [s].
    """

    problem: str
    solver: str
    error: float
    time: float
    ratio: float
    first: float


def standings(points: Sequence[Point]) -> list[Standing]:
    """All solvers on all problems, fastest first.

    The time of `energy` is that of the call as users make it, at its default
    tolerance, whatever error below `COMPARED_AT` that gives; the others are
    interpolated to exactly `COMPARED_AT`, in their favour.
    """
    rows = []
    for problem in dict.fromkeys(point.problem for point in points):
        here = [point for point in points if point.problem == problem]
        default = min(
            (point for point in here if point.family == "energy"),
            key=lambda point: abs(math.log(point.rtol / DEFAULT_RTOL["energy"])),
        )
        table = [
            Standing(problem, "energy", default.error, default.time, 1.0, _first(here, "energy"))
        ]
        for name in dict.fromkeys(point.solver for point in here):
            if name != "energy":
                time = time_at([point for point in here if point.solver == name], COMPARED_AT)
                ratio = time / default.time
                table.append(Standing(problem, name, COMPARED_AT, time, ratio, _first(here, name)))
        rows += sorted(table, key=lambda row: math.inf if math.isnan(row.time) else row.time)
    return rows


def _first(points: Sequence[Point], name: str) -> float:
    """First call of a solver: compiling and loading included."""
    return next(point.first for point in points if point.solver == name)


def time_at(points: Sequence[Point], error: float) -> float:
    """Least time of a solver for an error [s]; NaN where it never gets there.

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
            return loose.time * math.pow(tight.time / loose.time, share)
    raise AssertionError("the front falls below the error and never crosses it")


def _front(points: Sequence[Point]) -> list[Point]:
    """Points that no other beats in both time and error, by falling error."""
    front: list[Point] = []
    for point in sorted(points, key=lambda point: (point.error, point.time)):
        if not front or point.time < front[-1].time:
            front.append(point)
    return front[::-1]
