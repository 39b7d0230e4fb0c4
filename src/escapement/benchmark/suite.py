"""The whole benchmark: measure, tabulate, draw, write."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from escapement.benchmark import candidates as _contestants
from escapement.benchmark import figures, headline, machine, scaling, scenes, tables
from escapement.benchmark.problems import PROBLEMS, Problem
from escapement.benchmark.work_precision import Point, sweep_tolerances
from escapement.files.atomic import replace_file
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
    solvers=("energy", "ivp", "solve_ivp DOP853 Numba", "heyoka"),
)
"""About twenty seconds: one of SciPy's methods, and not the peer that takes long to compile."""


@dataclass(frozen=True)
class Results:
    """Everything measured, with the machine it was measured on."""

    machine: dict[str, Any]
    quick: bool
    missing: list[str]
    points: list[Point]
    standings: list[headline.Standing]
    scenes: list[scenes.SceneTime]
    costs: list[scaling.Cost]

    def as_dict(self) -> dict[str, Any]:
        """Plain values by name, for JSON."""
        return {
            "machine": self.machine,
            "quick": self.quick,
            "not_installed": self.missing,
            "standings": [row._asdict() for row in self.standings],
            "work_precision": [row._asdict() for row in self.points],
            "scenes": [row._asdict() for row in self.scenes],
            "scaling": [row._asdict() for row in self.costs],
        }


def run(*, quick: bool = False, note: Callable[[str], object] | None = None) -> Results:
    """Measure everything.

    Parameters
    ----------
    quick : bool
        A version of about twenty seconds instead of many minutes.
    note : callable, optional
        Told what is being measured.
    """
    effort, say = (QUICK if quick else FULL), note or (lambda text: None)
    here = machine.describe()
    field = [
        contestant
        for contestant in _contestants.contestants()
        if effort.solvers is None or contestant.name in effort.solvers
    ]
    points: list[Point] = []
    for problem in effort.problems:
        say(f"{len(field)} solvers on problem {problem.name!r}")
        points += sweep_tolerances(
            problem,
            field,
            decades=effort.decades,
            longest=effort.longest,
            rounds=effort.rounds,
        )
    first = effort.problems[0]
    most = max(effort.cases)
    say("kinds of scene")
    kinds = scenes.scene_times(first, most, effort.rounds)
    say("cost against engagements, cases and workers")
    workers = range(1, here["cores"] + 1)
    costs = [
        *scaling.against_engagements(first, effort.engagements, effort.longest, effort.rounds),
        *scaling.against_cases(first, effort.cases, effort.rounds),
        # many blocks for each worker, or the last one's solo counts
        *scaling.against_workers(first, workers, 4 * most, min(effort.rounds, 3)),
    ]
    installed = _contestants.installed_peers()
    return Results(
        machine=here,
        quick=quick,
        missing=[name for name in _contestants.PEERS if name not in installed],
        points=points,
        standings=headline.standings(points),
        scenes=kinds,
        costs=costs,
    )


def write(results: Results, folder: Path) -> list[Path]:
    """Tables as CSV, figures and the machine's description into an existing folder."""
    text = json.dumps(results.machine | {"quick": results.quick}, indent=2) + "\n"
    description = folder / "machine.json"
    replace_file(description, [text.encode()])
    paths = [
        description,
        tables.write_csv(folder / "standings.csv", results.standings),
        tables.write_csv(folder / "work_precision.csv", results.points),
        tables.write_csv(folder / "scenes.csv", results.scenes),
        tables.write_csv(folder / "scaling.csv", results.costs),
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
