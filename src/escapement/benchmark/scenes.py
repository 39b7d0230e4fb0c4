"""Time of each kind of scene, and what its shape made unnecessary."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from escapement.benchmark.problems import Problem
from escapement.benchmark.timing import shortest
from escapement.model import Escapement, Inertia
from escapement.simulation import simulate, terminal
from escapement.study.sweep import sweep


class Scene(NamedTuple):
    """A kind of question.

    name : what is asked.
    left_out : what the engine therefore did not do.
    cases : answers it gives.
    call : asks it once.
    """

    name: str
    left_out: str
    cases: int
    call: Callable[[], Any]


class SceneTime(NamedTuple):
    """A scene and the shortest time of a warm call [s], in all and by case."""

    scene: str
    left_out: str
    cases: int
    time: float
    time_per_case: float


def scene_times(problem: Problem, cases: int, rounds: int) -> list[SceneTime]:
    """Every scene on one problem, its batches `cases` long.

    What takes microseconds takes ten times as many turns, and none beside a batch: on a
    shared machine its shortest time would be left to chance.
    """
    single, batches = _motions(problem.escapement), _batches(problem.escapement, cases)
    times = shortest([scene.call for scene in single], 10 * rounds)
    times += shortest([scene.call for scene in batches], rounds)
    return [
        SceneTime(scene.name, scene.left_out, scene.cases, time, time / scene.cases)
        for scene, time in zip(single + batches, times, strict=True)
    ]


def _motions(timer: Escapement) -> list[Scene]:
    smooth = Escapement(timer.mechanism, timer.inertia, timer.torque)
    loaded = _loaded(timer)
    coast = Escapement(
        timer.mechanism, Inertia(timer.inertia.follower, timer.inertia.follower), timer.torque, 0.1
    )
    return [
        Scene("motion, 20 engagements", "samples, extrema", 1, lambda: simulate(timer)),
        Scene(
            "motion, 10 000 engagements",
            "whatever repeats once the transient is over",
            1,
            lambda: simulate(timer, 10_000),
        ),
        Scene("motion with its extrema", "samples", 1, lambda: simulate(timer).extrema),
        Scene("motion with 2000 samples", "", 1, lambda: simulate(timer).samples),
        Scene("motion without friction", "both sides of the slot", 1, lambda: simulate(smooth)),
        Scene("motion against a load", "samples, extrema", 1, lambda: simulate(loaded)),
        Scene("motion, slow settling", "samples, extrema", 1, lambda: simulate(coast)),
        Scene("terminal cycle", "transient in time, samples", 1, lambda: terminal(timer)),
        Scene(
            "terminal cycle with its peaks",
            "the transient in time",
            1,
            lambda: terminal(timer).acceleration_max,
        ),
    ]


def _batches(timer: Escapement, cases: int) -> list[Scene]:
    loaded = _loaded(timer)
    shares = np.linspace(0.5, 1.0, cases)
    side = max(2, round(cases**0.5))
    powers = 2.0 ** np.linspace(-1.0, 1.0, side)
    drivers, followers = powers * timer.inertia.driver, powers * timer.inertia.follower
    return [
        Scene(
            "friction axis",
            "trajectories, samples",
            cases,
            lambda: sweep(timer, friction=timer.friction * shares),
        ),
        Scene(
            "torque axis",
            "all solves but one: torque is a change of clock",
            cases,
            lambda: sweep(timer, torque=timer.torque * shares),
        ),
        Scene(
            "torque axis against a load",
            "nothing: the load ratio changes",
            cases,
            lambda: sweep(loaded, torque=timer.torque * (0.5 + shares)),
        ),
        Scene(
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
