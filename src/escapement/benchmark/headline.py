"""The comparison in a few numbers: the same problem, the same error, one core."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from escapement.benchmark.candidates import ENERGY
from escapement.benchmark.work_precision import Point, time_at
from escapement.solver import DEFAULT_RTOL

ERROR = 1e-10
"""Error at which contestants are compared [-]."""


class Standing(NamedTuple):
    """A contestant beside `energy` on one problem.

    problem, contestant : names.
    error : at which its time is taken; of `energy`, what a call without a
        tolerance really has [-].
    time : [s]. ratio : over the time of `energy` [-].
    first : preparation and first run in this process [s].
    """

    problem: str
    contestant: str
    error: float
    time: float
    ratio: float
    first: float


def standings(points: Sequence[Point]) -> list[Standing]:
    """All contestants on all problems, fastest first.

    The time of `energy` is that of the call as users make it, at its default
    tolerance, whatever error below `ERROR` that gives; the others are
    interpolated to exactly `ERROR`, in their favour.
    """
    rows = []
    for problem in dict.fromkeys(point.problem for point in points):
        here = [point for point in points if point.problem == problem]
        default = min(
            (point for point in here if point.family == ENERGY),
            key=lambda point: abs(math.log(point.rtol / DEFAULT_RTOL[ENERGY])),
        )
        table = [Standing(problem, ENERGY, default.error, default.time, 1.0, _first(here, ENERGY))]
        for name in dict.fromkeys(point.contestant for point in here):
            if name != ENERGY:
                time = time_at([point for point in here if point.contestant == name], ERROR)
                ratio = time / default.time
                table.append(Standing(problem, name, ERROR, time, ratio, _first(here, name)))
        rows += sorted(table, key=lambda row: math.inf if math.isnan(row.time) else row.time)
    return rows


def _first(points: Sequence[Point], name: str) -> float:
    """First call of a contestant: compiling and loading included."""
    return next(point.first for point in points if point.contestant == name)
