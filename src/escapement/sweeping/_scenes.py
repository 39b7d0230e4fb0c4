"""Scenes of a plan: what is left of its cases once time is measured in natural units.

There a case is its mechanism, inertia ratio, loss, load ratio and starting speed.
Without a load and from rest torque is a pure change of clock and leaves all of these
alone: cases that differ in nothing else share a scene, and a scene is solved once.
"""

import contextlib
import math
import threading
from concurrent.futures import Future
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement.configuration import StudyPlan
from escapement.errors import InvalidValue
from escapement.model import MOST_UNEQUAL, FloatArray, ratio_in_range
from escapement.simulation import FASTEST
from escapement.status import Status

MOST_SHARED = 1 << 20
"""Scenes that are kept for all blocks of a study: 50 MiB."""

_SLICE = 256  # scenes solved at a time: a few milliseconds, and always the same ones together
_NUMBERS = (
    *("driver_inertia", "follower_inertia"),
    *("torque", "load_torque", "initial_speed"),
)

Figures = tuple[FloatArray, NDArray[np.uint8]]
"""Largest, smallest and mean velocity, period, rise and settling time in natural units,
shape (6, n), and the status, shape (n,)."""


def solve_scenes(plan: StudyPlan, cases: NDArray[np.int64]) -> Figures:
    """Figures of the scenes of some cases, none of them solved twice."""
    columns = plan.columns(cases)
    values = plan.fixed_si | columns
    driver, follower, torque, load, speed, loss = (
        np.broadcast_to(np.asarray(values[name], dtype=float), cases.shape)
        for name in (*_NUMBERS, plan.kind.loss)
    )
    if plan.kind.meshed:
        loss = 1.0 / loss - 1.0
    with np.errstate(all="ignore"):  # what is out of range is told by the status
        scene = np.array([
            driver / follower, loss, load / torque, speed**2 * (follower / torque)
        ])  # fmt: skip
        sound = ratio_in_range(scene[0]) & (scene[2] < MOST_UNEQUAL)
        sound &= scene[3] <= FASTEST**2
    figures = np.full((6, cases.size), np.nan)
    status = np.full(cases.size, Status.INVALID, dtype=np.uint8)
    for rows in _by_mechanism(plan, columns, cases.size):
        rows = rows[sound[rows]]
        if rows.size == 0:
            continue
        # a mechanism that cannot be, or cannot move, is no reason to end the study
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


def _solve_distinct(mechanism: Any, scene: FloatArray, rtol: float) -> Figures:
    """Solve the scenes of one mechanism, shape (4, n): equal ones once."""
    from escapement.engines import _energy_batch, _terminal

    order = np.lexsort(scene)
    ordered = scene[:, order]
    new = np.append(True, (ordered[:, 1:] != ordered[:, :-1]).any(axis=0))
    which = np.empty(order.size, dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    rho, mu, load, w = np.ascontiguousarray(ordered[:, new])
    table, status = _energy_batch.solve(mechanism, rho, mu, load, w, rtol)
    columns = table.T
    period = columns[_terminal.PERIOD]
    figures = np.array([
        columns[_terminal.V_MAX],
        columns[_terminal.V_MIN],
        mechanism.cell_angle / period,
        period,
        columns[_terminal.RISE],
        columns[_terminal.SETTLING],
    ])  # fmt: skip
    return figures[:, which], status[which]


class SharedScenes:
    """The scenes of a plan, each solved when a block first needs it, and kept for all.

    Any number of threads may ask. They are solved in slices of their own, so that what
    is solved together does not depend on who asks first.

    Parameters
    ----------
    plan : StudyPlan
        Whose dimensions beyond `deciding` leave the scene alone.
    deciding : tuple of int
        Dimensions of the plan that a scene depends on.
    """

    def __init__(self, plan: StudyPlan, deciding: tuple[int, ...]) -> None:
        self._plan, self._deciding = plan, deciding
        self._shape = tuple(plan.shape[i] for i in deciding)
        size = math.prod(self._shape)
        self._figures, self._status = np.empty((6, size)), np.empty(size, dtype=np.uint8)
        self._slices: dict[int, Future[None]] = {}
        self._access = threading.Lock()

    def of(self, cases: NDArray[np.int64]) -> Figures:
        """Figures of the scenes of some cases, as `solve_scenes` gives them."""
        places = np.unravel_index(cases, self._plan.shape)
        scenes = np.zeros(cases.size, dtype=np.int64)
        for dimension, length in zip(self._deciding, self._shape, strict=True):
            scenes = scenes * length + places[dimension]
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
        for dimension, place in zip(self._deciding, along, strict=True):
            places[dimension] = place
        return np.ravel_multi_index(places, shape)


def shared_scenes(plan: StudyPlan) -> SharedScenes | None:
    """The scenes that blocks of a plan share; None where sharing saves or suits nothing."""
    deciding = {*plan.kind.parameters, *_NUMBERS, plan.kind.loss}
    if not any(np.any(plan.every(name)) for name in ("load_torque", "initial_speed")):
        deciding -= {"torque", "load_torque", "initial_speed"}
    dimensions = tuple(
        i for i, names in enumerate(plan.varied.values()) if not deciding.isdisjoint(names)
    )
    scenes = math.prod(plan.shape[i] for i in dimensions)
    if scenes == plan.cases or scenes > MOST_SHARED:
        return None
    return SharedScenes(plan, dimensions)
