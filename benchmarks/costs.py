"""Time of each kind of computation, and how it grows with engagements, cases and workers.

``python benchmarks/costs.py [--quick] [-o DIR]``

For computations, engagements and cases the processor time of one core is measured, for workers the
wall time. The long version writes two tables and a figure to benchmarks/results, the quick one only
with ``-o``.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from escapement.base.text import print_columns
from escapement.benchmark import (
    describe_machine,
    machine_in_a_line,
    shortest,
    timed,
    wall,
    write_csv,
)
from escapement.benchmark.problems import PROBLEMS, Problem
from escapement.engines.simulate import simulate, terminal
from escapement.engines.solver import ENGINES
from escapement.model.escapement import Escapement, Inertia
from escapement.plots import save
from escapement.plots.style import BLACK, GREY, SMALL_SIZE, TWO_COLUMN, dress, new_figure
from escapement.study.running import sweep

RESULTS = Path(__file__).resolve().parent / "results"


class Effort(NamedTuple):
    """How much is measured: sizes, longest run [s], and repetitions of each call."""

    engagements: Sequence[int]
    cases: Sequence[int]
    longest: float
    rounds: int


FULL = Effort(
    engagements=(1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 10_000, 100_000),
    cases=(1, 3, 10, 30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000),
    longest=1.0,
    rounds=5,
)
QUICK = Effort((1, 10, 100, 1000), (1, 10, 100, 1000, 10_000), 0.25, 2)


class Question(NamedTuple):
    """A computation that users ask for, here called a question.

    name : the computation in words.
    left_out : parts of the work that the engine does not do for it.
    cases : number of cases that it computes.
    call : computes it once.
    """

    name: str
    left_out: str
    cases: int
    call: Callable[[], Any]


class QuestionTime(NamedTuple):
    """A question (`scene`) and the shortest time of a warm call [s], in all and per case."""

    scene: str
    left_out: str
    cases: int
    time: float
    time_per_case: float


def question_times(problem: Problem, cases: int, rounds: int) -> list[QuestionTime]:
    """Every question on one problem, its batches `cases` long.

    Questions of microseconds are repeated ten times as often, and not between batches: on a shared
    machine their shortest time would otherwise depend on chance.
    """
    single, batches = _motions(problem.escapement), _batches(problem.escapement, cases)
    times = shortest([question.call for question in single], 10 * rounds)
    times += shortest([question.call for question in batches], rounds)
    return [
        QuestionTime(question.name, question.left_out, question.cases, time, time / question.cases)
        for question, time in zip(single + batches, times, strict=True)
    ]


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


def _motions(timer: Escapement) -> list[Question]:
    smooth = Escapement(timer.mechanism, timer.inertia, timer.torque)
    loaded, real, oily = _loaded(timer), _real(timer), _oily(timer)
    coast = Escapement(
        timer.mechanism, Inertia(timer.inertia.follower, timer.inertia.follower), timer.torque, 0.1
    )
    return [
        Question("motion, 20 engagements", "samples, extrema", 1, lambda: simulate(timer)),
        Question(
            "motion, 10 000 engagements",
            "whatever repeats once the transient is over",
            1,
            lambda: simulate(timer, 10_000),
        ),
        Question("motion with its extrema", "samples", 1, lambda: simulate(timer).extrema),
        Question("motion with 2000 samples", "", 1, lambda: simulate(timer).samples),
        Question("motion without friction", "both sides of the slot", 1, lambda: simulate(smooth)),
        Question("motion against a load", "samples, extrema", 1, lambda: simulate(loaded)),
        Question("motion, pins, bearings, air", "viscous drag", 1, lambda: simulate(real)),
        Question("motion with viscous drag", "samples, extrema", 1, lambda: simulate(oily)),
        Question("motion, slow settling", "samples, extrema", 1, lambda: simulate(coast)),
        Question("terminal cycle", "transient in time, samples", 1, lambda: terminal(timer)),
        Question(
            "terminal cycle with its peaks",
            "the transient in time",
            1,
            lambda: terminal(timer).acceleration_max,
        ),
    ]


def _real(timer: Escapement) -> Escapement:
    """The timer with pins, journals and drags of usual size."""
    wheel = replace(timer.mechanism, crank_radius=0.01, pin_radius=0.0005)
    journals = {
        f"{body}_bearing_{what}": value
        for body in ("driver", "follower")
        for what, value in (("friction", 0.15), ("radius", 0.0005))
    }
    drags = {f"{body}_drag": 0.01 * timer.inertia.follower for body in ("driver", "follower")}
    held = 0.05 * timer.torque
    return replace(timer, mechanism=wheel, driver_bearing_torque=held, **journals, **drags)


def _oily(timer: Escapement) -> Escapement:
    """The same with viscous drag on both bodies."""
    unit = (timer.inertia.follower * timer.torque) ** 0.5
    return replace(timer, driver_viscous=0.05 * unit, follower_viscous=0.02 * unit)


def _batches(timer: Escapement, cases: int) -> list[Question]:
    loaded, real = _loaded(timer), _real(timer)
    shares = np.linspace(0.5, 1.0, cases)
    side = max(2, round(cases**0.5))
    powers = 2.0 ** np.linspace(-1.0, 1.0, side)
    drivers, followers = powers * timer.inertia.driver, powers * timer.inertia.follower
    return [
        Question(
            "friction axis, pins, bearings, air",
            "trajectories, samples",
            cases,
            lambda: sweep(real, friction=timer.friction * shares),
        ),
        Question(
            "friction axis",
            "trajectories, samples",
            cases,
            lambda: sweep(timer, friction=timer.friction * shares),
        ),
        Question(
            "torque axis",
            "all solves but one: torque is a change of clock",
            cases,
            lambda: sweep(timer, torque=timer.torque * shares),
        ),
        Question(
            "torque axis against a load",
            "nothing: the load ratio changes",
            cases,
            lambda: sweep(loaded, torque=timer.torque * (0.5 + shares)),
        ),
        Question(
            "grid of both inertias",
            f"pairs of the same ratio: {2 * side - 1} solves for {side * side}",
            side * side,
            lambda: sweep(timer, driver_inertia=drivers, follower_inertia=followers),
        ),
    ]


def _loaded(timer: Escapement) -> Escapement:
    """The timer against a tenth of its torque."""
    return Escapement(
        timer.mechanism, timer.inertia, timer.torque, timer.friction, 0.1 * timer.torque
    )


def _batch(problem: Problem, cases: int, workers: int) -> object:
    friction = problem.friction * np.linspace(0.2, 1.0, cases)
    return sweep(problem.escapement, workers=workers, friction=friction)


def growth(effort: Effort, cores: int) -> list[Cost]:
    """Costs against engagements, cases and workers."""
    problem, most = PROBLEMS[0], max(effort.cases)
    return [
        *against_engagements(problem, effort.engagements, effort.longest, effort.rounds),
        *against_cases(problem, effort.cases, effort.rounds),
        # with few blocks per worker, the time in which the last one works alone would matter
        *against_workers(problem, range(1, cores + 1), 4 * most, min(effort.rounds, 3)),
    ]


def scaling_figure(costs: Sequence[Cost], machine: dict[str, Any]) -> Figure:
    """Cost against engagements, cases and workers."""
    figure = new_figure(TWO_COLUMN, 0.36 * TWO_COLUMN)
    left, middle, right = figure.subplots(1, 3)
    for engine, color, marker in (("energy", BLACK, "o"), ("ivp", GREY, "s")):
        line = [c for c in costs if c.against == "engagements" and c.engine == engine]
        look = {"color": color, "marker": marker, "markersize": 3, "label": engine}
        left.loglog([c.size for c in line], [c.time for c in line], **look)
    left.set(xlabel="Engagements", ylabel="Run time (s)")
    left.legend(fontsize=SMALL_SIZE, frameon=False)
    look = {"color": BLACK, "marker": "o", "markersize": 3}
    line = [cost for cost in costs if cost.against == "cases"]
    middle.loglog([c.size for c in line], [c.time / c.items * 1e6 for c in line], **look)
    middle.set(xlabel="Cases in a batch", ylabel="Time by case (µs)", ylim=(1.0, None))
    line = [cost for cost in costs if cost.against == "workers"]
    sizes = [cost.size for cost in line]
    alone = line[0].items / line[0].time
    right.plot(sizes, [c.items / c.time for c in line], **look)
    right.plot(sizes, [size * alone for size in sizes], color=GREY, ls=":", label="proportional")
    right.set(xlabel="Workers", ylabel="Cases a second", ylim=(0, None), xticks=sizes)
    right.legend(fontsize=SMALL_SIZE, frameon=False)
    for ax in (left, middle, right):
        dress(ax)
    figure.supxlabel(machine_in_a_line(machine), fontsize=6.0)
    return figure


def main() -> None:
    """Measure, print, and fill the folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="seconds, not minutes")
    parser.add_argument("-o", "--output", type=Path, help=f"folder (default: {RESULTS})")
    args = parser.parse_args()
    effort = QUICK if args.quick else FULL
    machine = describe_machine()
    questions = question_times(PROBLEMS[0], max(effort.cases), effort.rounds)
    costs = growth(effort, machine["cores"])
    folder = args.output or (None if args.quick else RESULTS)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        write_csv(folder / "scenes.csv", questions)
        write_csv(folder / "scaling.csv", costs)
        save(scaling_figure(costs, machine), folder / "scaling.svg")
    print_columns(
        [("question", "cases", "time by case", "left out"), ("", "", "us", "")],
        [(row.scene, row.cases, 1e6 * row.time_per_case, row.left_out) for row in questions],
    )
    print()
    print_columns(
        [("against", "engine", "size", "time by item"), ("", "", "", "us")],
        [(row.against, row.engine, row.size, 1e6 * row.time / row.items) for row in costs],
    )


if __name__ == "__main__":
    main()
