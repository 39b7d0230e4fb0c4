"""Cost of each kind of question, and how it grows with engagements, cases and workers.

Questions, engagements and cases are timed by the processor time of one core, workers by
the wall.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from escapement.benchmark.measuring import shortest, timed, wall
from escapement.benchmark.problems import Problem
from escapement.model import Escapement, Inertia
from escapement.simulation import simulate, terminal
from escapement.solver import ENGINES
from escapement.study.sweep import sweep


class Question(NamedTuple):
    """A question that users ask of the package.

    name : what is asked.
    left_out : what the engine therefore did not do.
    cases : answers it gives.
    call : asks it once.
    """

    name: str
    left_out: str
    cases: int
    call: Callable[[], Any]


class QuestionTime(NamedTuple):
    """A question (`scene`) and the shortest time of a warm call [s], in all and by case."""

    scene: str
    left_out: str
    cases: int
    time: float
    time_per_case: float


def question_times(problem: Problem, cases: int, rounds: int) -> list[QuestionTime]:
    """Every question on one problem, its batches `cases` long.

    What takes microseconds takes ten times as many turns, and none beside a batch: on a
    shared machine its shortest time would be left to chance.
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
    loaded = _loaded(timer)
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
        Question("motion, slow settling", "samples, extrema", 1, lambda: simulate(coast)),
        Question("terminal cycle", "transient in time, samples", 1, lambda: terminal(timer)),
        Question(
            "terminal cycle with its peaks",
            "the transient in time",
            1,
            lambda: terminal(timer).acceleration_max,
        ),
    ]


def _batches(timer: Escapement, cases: int) -> list[Question]:
    loaded = _loaded(timer)
    shares = np.linspace(0.5, 1.0, cases)
    side = max(2, round(cases**0.5))
    powers = 2.0 ** np.linspace(-1.0, 1.0, side)
    drivers, followers = powers * timer.inertia.driver, powers * timer.inertia.follower
    return [
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
