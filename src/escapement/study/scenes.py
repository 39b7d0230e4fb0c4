"""Scenes of a plan: what is left of its cases once time is measured in natural units.

In natural units a case is its mechanism, inertia ratio, loss, load ratio and starting speed.
Without a load and from rest the torque changes the unit of time and none of these five, so
cases that differ in torque alone have the same scene. `solve_scenes` solves equal scenes of
one block once; `SharedScenes` keeps the scenes that several blocks have in common.
"""

import contextlib
import math
import threading
from concurrent.futures import Future
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.errors import InvalidValue
from escapement.model import (
    MOST_UNEQUAL,
    Escapement,
    FloatArray,
    Inertia,
    natural,
    ratio_in_range,
)
from escapement.quantity import quantities
from escapement.scene import Scene
from escapement.status import Status
from escapement.study.plan import StudyPlan

DRIVER, FOLLOWER = "driver_inertia", "follower_inertia"
CLOCKED = TORQUE, LOAD, SPEED = "torque", "load_torque", "initial_speed"
"""Numbers that change only the unit of time where there is neither load nor initial speed."""
DECIDING = {*quantities(Escapement), *quantities(Inertia), SPEED}
"""Numbers of the model and of a run that decide a scene."""
MOST_SHARED = 1 << 20
"""Scenes that are kept for all blocks of a study: 50 MiB."""

_SLICE = 256  # scenes solved at a time: a few milliseconds, and always the same ones together

SceneFigures = tuple[FloatArray, NDArray[np.uint8]]
"""Largest, smallest and mean velocity, period, rise and settling time in natural units,
shape (6, n), and the status, shape (n,)."""


def solve_scenes(plan: StudyPlan, cases: NDArray[np.int64]) -> SceneFigures:
    """Figures of the scenes of some cases, none of them solved twice."""
    columns = plan.columns(cases)
    values = plan.fixed_si | columns
    numbers = {
        name: np.broadcast_to(np.asarray(value, dtype=float), cases.shape)
        for name, value in values.items()
        if name in DECIDING
    }
    with np.errstate(all="ignore"):  # what is out of range is told by the status
        ratios = natural(numbers, plan.kind.meshed)
        w = numbers[SPEED] ** 2 * (numbers[FOLLOWER] / numbers[TORQUE])
        sound = ratio_in_range(ratios["rho"]) & (ratios["load"] < MOST_UNEQUAL)
        sound &= w <= MOST_UNEQUAL**2
    scene = np.array([*(ratios[name] for name in Scene._fields if name in ratios), w])
    figures = np.full((6, cases.size), np.nan)
    status = np.full(cases.size, Status.INVALID, dtype=np.uint8)
    for rows in _by_mechanism(plan, columns, cases.size):
        rows = rows[sound[rows]]
        if rows.size == 0:
            continue
        # a mechanism that cannot be built, or cannot move, must not end the study
        with contextlib.suppress(InvalidValue):
            figures[:, rows], status[rows] = _solve_distinct(
                plan.mechanism(int(cases[rows[0]])), scene[:, rows], plan.solver.tolerance
            )
    return figures, status


def _by_mechanism(plan: StudyPlan, columns: dict[str, NDArray[Any]], size: int) -> list[Any]:
    """Rows that share a mechanism, ascending."""
    varied = [columns[name] for name in plan.kind.parameters if name in columns]
    if not varied:
        return [np.arange(size)]
    _, group = np.unique(np.array(varied), axis=1, return_inverse=True)
    group = group.reshape(-1)
    order = np.argsort(group, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(group[order])) + 1)


def _solve_distinct(mechanism: Any, scene: FloatArray, rtol: float) -> SceneFigures:
    """Solve the scenes of one mechanism, shape (k, n): equal ones once."""
    from escapement.engines.energy import batch, cycle

    order = np.lexsort(scene)
    ordered = scene[:, order]
    new = np.append(True, (ordered[:, 1:] != ordered[:, :-1]).any(axis=0))
    which = np.empty(order.size, dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    table, status = batch.solve(mechanism, ordered[:, new], rtol)
    columns = table.T
    period = columns[cycle.PERIOD]
    figures = np.array([
        columns[cycle.V_MAX],
        columns[cycle.V_MIN],
        mechanism.cell_angle / period,
        period,
        columns[cycle.RISE],
        columns[cycle.SETTLING],
    ])  # fmt: skip
    return figures[:, which], status[which]


class Factor(NamedTuple):
    """One part of a scene, and the dimensions of a plan that decide it.

    dimensions : indices of these dimensions.
    numbers : number of the part's value, counted from 0, at each place along them.
    first : flat index of the first place that has each number.
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

    def of(self, cases: NDArray[np.int64]) -> SceneFigures:
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
            solved.set_exception(error)  # other threads wait for this slice
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
