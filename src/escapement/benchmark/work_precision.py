"""Run time against measured error: every solver over a sweep of its tolerance.

`run` measures, `write` fills a folder with the tables and the figure.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement import benchmark
from escapement.base.files import replace_file
from escapement.base.text import as_json
from escapement.benchmark.problems import PROBLEMS, MeasuredSolver, Problem, package_solvers
from escapement.engines.solver import DEFAULT_RTOL
from escapement.numerics.interpreted import compile_from_now_on
from escapement.plots import save, style

COMPARED_AT = 1e-10
"""Error at which solvers are compared [-]."""

# The package itself does not measure heyoka; `benchmarks/standings.py` does.
_LOOKS = {
    "energy": (style.BLACK, "o"), "ivp": (style.GREY, "s"), "heyoka": (style.VERMILLION, "^"),
    "DOP853": (style.BLUE, ">"), "RK45": (style.SKY, "v"),
    "RK23": (style.LIGHT_GREY, "<"), "LSODA": (style.GREEN, "X"), "Radau": (style.PURPLE, "P"),
    "BDF": ("#8c6bb1", "*"),
}  # fmt: skip
"""Colour and marker of a package, and of a method of solve_ivp."""
_HOLLOW = ("Taylor, angle",)  # second methods of a package

_FULL: dict[str, Any] = {"decades": 1, "longest": 1.0, "rounds": 5}
"""Effort of a run of many minutes, arguments of `sweep_tolerances`."""
_QUICK: dict[str, Any] = {"decades": 2, "longest": 0.25, "rounds": 2}
"""Effort of a run of ten seconds, on the first problem and with one of SciPy's methods."""
QUICK_SOLVERS = ("energy", "ivp", "solve_ivp DOP853 Numba")


class Point(NamedTuple):
    """One solver at one tolerance.

    problem, solver, family, method, language : names.
    rtol : requested tolerance [-].
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


class Standing(NamedTuple):
    """A solver compared with `energy` on one problem.

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


class Results(NamedTuple):
    """Everything measured, with the machine it was measured on."""

    machine: dict[str, Any]
    quick: bool
    points: list[Point]

    @property
    def standings(self) -> list[Standing]:
        """All solvers on all problems, fastest first."""
        return standings(self.points)

    def as_dict(self) -> dict[str, Any]:
        """Plain values by name, for JSON."""
        return {
            "machine": self.machine,
            "quick": self.quick,
            "standings": [row._asdict() for row in self.standings],
            "work_precision": [row._asdict() for row in self.points],
        }


def run(
    *,
    quick: bool = False,
    further: Sequence[MeasuredSolver] = (),
    note: Callable[[str], object] = lambda text: None,
) -> Results:
    """Measure everything.

    Parameters
    ----------
    quick : bool
        A version of ten seconds instead of many minutes.
    further : sequence of MeasuredSolver
        Solvers to measure besides the package's engines and SciPy's; their families name
        the packages they come from.
    note : callable
        Called with a description of each measurement.
    """
    compile_from_now_on()
    machine = benchmark.describe_machine(list(dict.fromkeys(each.family for each in further)))
    solvers = [each for each in package_solvers() if not quick or each.solver in QUICK_SOLVERS]
    solvers += further
    points: list[Point] = []
    for problem in PROBLEMS[:1] if quick else PROBLEMS:
        note(f"{len(solvers)} solvers on problem {problem.name!r}")
        points += sweep_tolerances(problem, solvers, **(_QUICK if quick else _FULL))
    return Results(machine, quick, points)


def write(results: Results, folder: Path) -> list[Path]:
    """Tables as CSV, the figure and the machine's description into an existing folder."""
    description, picture = folder / "machine.json", folder / "work_precision.svg"
    replace_file(description, [as_json(results.machine | {"quick": results.quick}).encode()])
    save(work_precision_figure(results.points, results.machine), picture)
    return [
        description,
        benchmark.write_csv(folder / "standings.csv", results.standings),
        benchmark.write_csv(folder / "work_precision.csv", results.points),
        picture,
    ]


def sweep_tolerances(
    problem: Problem, solvers: Sequence[MeasuredSolver], decades: int, longest: float, rounds: int
) -> list[Point]:
    """Points of all solvers on one problem.

    Parameters
    ----------
    problem, solvers :
        The problem, and its solvers.
    decades : int
        Tolerances are this many powers of ten apart.
    longest : float
        A solver goes on to tighter tolerances while its runs are shorter [s].
    rounds : int
        Turns of each solver, of which the shortest counts.
    """
    points: list[Point] = []
    runs: list[benchmark.Call] = []
    for solver in solvers:
        for power in range(solver.loosest, solver.tightest - 1, -decades):
            rtol = 10.0**power
            try:
                preparing, call = benchmark.timed(partial(solver.prepare, problem, rtol))
                first, answer = benchmark.timed(call)
            except (ArithmeticError, ValueError):
                continue
            error = problem.error(*answer)
            # a solver that diverged or did not finish (NaN) has no place in the diagram
            if not error < 0.1:
                continue
            time, _ = benchmark.timed(call)
            # an error of exactly zero could not be drawn
            numbers = rtol, max(error, 1e-16), time, preparing + first
            points.append(Point(problem.name, *solver[:4], *numbers))
            runs.append(call)
            if time > longest:
                break
    times = benchmark.shortest(runs, rounds)
    return [point._replace(time=time) for point, time in zip(points, times, strict=True)]


def standings(points: Sequence[Point]) -> list[Standing]:
    """All solvers on all problems, fastest first.

    The time of `energy` is that of a user's call at its default tolerance, whose error is below
    `COMPARED_AT`; the others are interpolated to exactly `COMPARED_AT`, in their favour.
    """
    rows: list[Standing] = []
    for problem, here in groupby(points, key=lambda point: point.problem):
        lines = {name: [*line] for name, line in groupby(here, key=lambda point: point.solver)}
        asked = DEFAULT_RTOL["energy"]
        default = min(lines["energy"], key=lambda point: abs(math.log(point.rtol / asked)))
        table = []
        for name, line in lines.items():
            error, time = COMPARED_AT, time_at(line, COMPARED_AT)
            if name == "energy":
                error, time = default.error, default.time
            # the first call of a solver is where compiling and loading are included
            table.append(Standing(problem, name, error, time, time / default.time, line[0].first))
        rows += sorted(table, key=lambda row: (math.isnan(row.time), row.time))
    return rows


def time_at(points: Sequence[Point], error: float) -> float:
    """Least time of a solver for an error [s]; NaN if it never reaches it.

    Between its best points the logarithms are interpolated, because an intermediate tolerance
    would give an intermediate point.
    """
    errors, times = np.log(sorted((point.error, point.time) for point in points)).T
    # points that no other point beats in both time and error
    front = np.append(True, times[1:] < np.minimum.accumulate(times)[:-1])
    found = np.interp(math.log(error), errors[front], times[front], left=math.nan)
    return float(np.exp(found))


def work_precision_figure(points: Sequence[Point], machine: dict[str, Any]) -> Figure:
    """A panel for each problem: measured error to the right, run time upwards.

    For solve_ivp only the lines with a Numba right-hand side are drawn. The legend has the
    slowest solver first, which is at the top of a panel.
    """
    drawn = [point for point in points if point.language != "Python"]
    names = {point.problem for point in points}
    problems = [problem for problem in PROBLEMS if problem.name in names]
    figure = style.new_figure(style.TWO_COLUMN, 0.6 + 2.9 * len(problems))
    panels = style.new_panels(figure, len(problems))
    panels[0].invert_xaxis()  # this inverts the axis of all panels, which share it
    for ax, problem in zip(panels, problems, strict=True):
        _plot_solvers([point for point in drawn if point.problem == problem.name], ax)
        ax.set_title(problem.title, fontsize=style.LABEL_SIZE)
        ax.label_outer()
    lines = sorted(panels[0].lines, key=lambda line: -np.max(line.get_ydata()))
    style.add_legend(figure, 1, handles=lines, loc="outside right center")
    foot = "solve_ivp with a Numba right-hand side\n" + benchmark.machine_in_a_line(machine)
    figure.supxlabel(foot, fontsize=style.SMALL_SIZE)
    return figure


def _plot_solvers(points: Sequence[Point], ax: Axes) -> None:
    """Run time against measured error, a line for each solver."""
    for name, group in groupby(points, key=lambda point: point.solver):
        line = sorted(group, key=lambda point: -point.rtol)
        first = line[0]
        color, marker = _LOOKS[first.method if first.family == "solve_ivp" else first.family]
        size, width, above = (7, 2, 3) if first.family == "energy" else (5, 1, 2)
        ax.loglog(
            [point.error for point in line], [point.time for point in line], marker, ls="-",
            color=color, mfc="white" if first.method in _HOLLOW else color, ms=size, lw=width,
            zorder=above, label=name.removesuffix(" Numba"),
        )  # fmt: skip
    ax.set(xlabel="Largest relative error", ylabel="Warm run time (s)")
