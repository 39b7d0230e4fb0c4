"""The whole benchmark: measure, tabulate, draw, write."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from escapement.benchmark import costs, figures
from escapement.benchmark.measuring import describe_machine, write_csv
from escapement.benchmark.problems import PROBLEMS, Problem
from escapement.benchmark.solvers import MeasuredSolver, own_solvers
from escapement.benchmark.work_precision import Point, Standing, standings, sweep_tolerances
from escapement.files import replace_file
from escapement.plots import save


@dataclass(frozen=True)
class Effort:
    """How much is measured."""

    problems: Sequence[Problem]
    decades: int
    longest: float
    rounds: int
    engagements: Sequence[int]
    cases: Sequence[int]
    solvers: Sequence[str] | None


FULL = Effort(
    problems=PROBLEMS,
    decades=1,
    longest=1.0,
    rounds=5,
    engagements=(1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 10_000, 100_000),
    cases=(1, 3, 10, 30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000),
    solvers=None,
)
QUICK = Effort(
    problems=PROBLEMS[:1],
    decades=2,
    longest=0.25,
    rounds=2,
    engagements=(1, 10, 100, 1000),
    cases=(1, 10, 100, 1000, 10_000),
    solvers=("energy", "ivp", "solve_ivp DOP853 Numba"),
)
"""About twenty seconds, with one of SciPy's methods."""


@dataclass(frozen=True)
class Results:
    """Everything measured, with the machine it was measured on."""

    machine: dict[str, Any]
    quick: bool
    points: list[Point]
    standings: list[Standing]
    scenes: list[costs.QuestionTime]
    costs: list[costs.Cost]

    def as_dict(self) -> dict[str, Any]:
        """Plain values by name, for JSON."""
        return {
            "machine": self.machine,
            "quick": self.quick,
            "standings": [row._asdict() for row in self.standings],
            "work_precision": [row._asdict() for row in self.points],
            "scenes": [row._asdict() for row in self.scenes],
            "scaling": [row._asdict() for row in self.costs],
        }


def run(
    *,
    quick: bool = False,
    further: Sequence[MeasuredSolver] = (),
    note: Callable[[str], object] | None = None,
) -> Results:
    """Measure everything.

    Parameters
    ----------
    quick : bool
        A version of about twenty seconds instead of many minutes.
    further : sequence of MeasuredSolver
        Solvers to measure beside the package's engines and SciPy's; their families name
        the packages they come from.
    note : callable, optional
        Told what is being measured.
    """
    effort, say = (QUICK if quick else FULL), note or (lambda text: None)
    machine = describe_machine(list(dict.fromkeys(each.family for each in further)))
    chosen = [
        *(
            each
            for each in own_solvers()
            if effort.solvers is None or each.solver in effort.solvers
        ),
        *further,
    ]
    points: list[Point] = []
    for problem in effort.problems:
        say(f"{len(chosen)} solvers on problem {problem.name!r}")
        points += sweep_tolerances(
            problem,
            chosen,
            decades=effort.decades,
            longest=effort.longest,
            rounds=effort.rounds,
        )
    first = effort.problems[0]
    say("kinds of scene")
    scenes = costs.question_times(first, max(effort.cases), effort.rounds)
    say("cost against engagements, cases and workers")
    return Results(
        machine=machine,
        quick=quick,
        points=points,
        standings=standings(points),
        scenes=scenes,
        costs=_growth(effort, machine["cores"]),
    )


def _growth(effort: Effort, cores: int) -> list[costs.Cost]:
    """Costs against engagements, cases and workers."""
    problem, most = effort.problems[0], max(effort.cases)
    return [
        *costs.against_engagements(problem, effort.engagements, effort.longest, effort.rounds),
        *costs.against_cases(problem, effort.cases, effort.rounds),
        # each worker needs many blocks, or the time in which the last works alone counts
        *costs.against_workers(problem, range(1, cores + 1), 4 * most, min(effort.rounds, 3)),
    ]


def write(results: Results, folder: Path) -> list[Path]:
    """Tables as CSV, figures and the machine's description into an existing folder."""
    text = json.dumps(results.machine | {"quick": results.quick}, indent=2) + "\n"
    description = folder / "machine.json"
    replace_file(description, [text.encode()])
    paths = [
        description,
        write_csv(folder / "standings.csv", results.standings),
        write_csv(folder / "work_precision.csv", results.points),
        write_csv(folder / "scenes.csv", results.scenes),
        write_csv(folder / "scaling.csv", results.costs),
    ]
    measured = {point.problem for point in results.points}
    problems = [problem for problem in PROBLEMS if problem.name in measured]
    drawings = {
        "work_precision": figures.work_precision_figure(results.points, problems, results.machine),
        "scaling": figures.scaling_figure(results.costs, results.machine),
    }
    for name, figure in drawings.items():
        paths.append(folder / f"{name}.svg")
        save(figure, paths[-1])
    return paths
