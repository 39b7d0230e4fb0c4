"""Scenes that many cases of a study share, solved once for all of its blocks."""

import math
import threading
from concurrent.futures import Future
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.study.plan import StudyPlan
from escapement.study.scenes import (
    CLOCKED,
    DRIVER,
    FOLLOWER,
    LOAD,
    SPEED,
    Figures,
    solve_scenes,
)

MOST_SHARED = 1 << 20
"""Scenes that are kept for all blocks of a study: 50 MiB."""

_SLICE = 256  # scenes solved at a time: a few milliseconds, and always the same ones together


class Factor(NamedTuple):
    """What one dimension of a plan, or several together, decide of a scene.

    dimensions : which.
    numbers : what is decided, counted from 0, by place along them.
    first : the first place, flat, where each number stands.
    """

    dimensions: tuple[int, ...]
    numbers: NDArray[np.int64]
    first: NDArray[np.int64]


class SharedScenes:
    """The scenes of a plan, each solved when a block first needs it, and kept for all.

    Any number of threads may ask. They are solved in slices of their own, so that what
    is solved together does not depend on who asks first.

    Parameters
    ----------
    plan : StudyPlan
        Whose dimensions beyond those of the factors leave the scene alone.
    factors : list of Factor
        What a scene is made of.
    """

    def __init__(self, plan: StudyPlan, factors: list[Factor]) -> None:
        self._plan, self._factors = plan, factors
        self._shape = tuple(factor.first.size for factor in factors)
        size = math.prod(self._shape)
        self._figures, self._status = np.empty((6, size)), np.empty(size, dtype=np.uint8)
        self._slices: dict[int, Future[None]] = {}
        self._access = threading.Lock()

    def of(self, cases: NDArray[np.int64]) -> Figures:
        """Figures of the scenes of some cases, as `solve_scenes` gives them."""
        places = np.unravel_index(cases, self._plan.shape)
        scenes = np.zeros(cases.size, dtype=np.int64)
        for dimensions, numbers, first in self._factors:
            scenes = scenes * first.size + numbers[tuple(places[i] for i in dimensions)]
        others = []
        for number in np.flatnonzero(np.bincount(scenes // _SLICE)).tolist():
            with self._access:
                solved, mine = self._slices.get(number), number not in self._slices
                if solved is None:
                    solved = self._slices[number] = Future()
            if mine:
                self._solve(number, solved)
            else:
                others.append(solved)
        for solved in others:
            solved.result()
        return self._figures[:, scenes], self._status[scenes]

    def _solve(self, number: int, solved: "Future[None]") -> None:
        begin = number * _SLICE
        scenes = np.arange(begin, min(begin + _SLICE, self._status.size))
        span = slice(begin, begin + scenes.size)
        try:
            self._figures[:, span], self._status[span] = solve_scenes(
                self._plan, self._first_case(scenes)
            )
        except BaseException as error:
            solved.set_exception(error)  # nobody may wait for it for ever
            raise
        solved.set_result(None)

    def _first_case(self, scenes: NDArray[np.int64]) -> NDArray[np.int64]:
        """The first case of each scene."""
        shape = self._plan.shape
        places = [np.zeros(scenes.size, dtype=np.int64) for _ in shape]
        along = np.unravel_index(scenes, self._shape) if self._shape else ()
        for (dimensions, numbers, first), which in zip(self._factors, along, strict=True):
            for i, place in zip(
                dimensions, np.unravel_index(first[which], numbers.shape), strict=True
            ):
                places[i] = place
        return np.ravel_multi_index(places, shape)


def shared_scenes(plan: StudyPlan) -> SharedScenes | None:
    """The scenes that blocks of a plan share; None where sharing saves or suits nothing."""
    deciding = {*plan.parameters}
    resting = not np.any(plan.every(SPEED))
    if resting and not np.any(plan.every(LOAD)):
        deciding -= {*CLOCKED}
    dimensions = [
        i for i, names in enumerate(plan.varied.values()) if not deciding.isdisjoint(names)
    ]
    factors = []
    ratio = _ratio(plan) if resting else None
    if ratio is not None:
        factors.append(ratio)
        dimensions = [i for i in dimensions if i not in ratio.dimensions]
    for i in dimensions:
        every = np.arange(plan.shape[i])
        factors.append(Factor((i,), every, every))
    scenes = math.prod(factor.first.size for factor in factors)
    if scenes == plan.cases or scenes > MOST_SHARED:
        return None
    return SharedScenes(plan, factors)


def _ratio(plan: StudyPlan) -> Factor | None:
    """Of the inertias from rest their ratio alone; None where they are no two dimensions."""
    along = [list(names) for names in plan.varied.values()]
    if [DRIVER] not in along or [FOLLOWER] not in along:
        return None
    driver, follower = plan.every(DRIVER), plan.every(FOLLOWER)
    if driver.size * follower.size > MOST_SHARED:
        return None
    with np.errstate(all="ignore"):
        ratio = driver[:, None] / follower
    _, first, numbers = np.unique(ratio, return_index=True, return_inverse=True)
    dimensions = along.index([DRIVER]), along.index([FOLLOWER])
    return Factor(dimensions, numbers.reshape(ratio.shape), first)
