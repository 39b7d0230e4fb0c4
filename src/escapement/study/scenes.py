"""Solving cases of a plan: equal scenes once, then each case on its own clock.

In natural units a case is its mechanism, inertia ratio, loss, load ratio and starting speed.
Without a load and from rest the torque changes the unit of time and none of these five, so
cases that differ in torque alone have the same scene.
"""

import contextlib
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement import simulation
from escapement.errors import InvalidValue
from escapement.model import MOST_UNEQUAL, Escapement, FloatArray, Inertia, natural, ratio_in_range
from escapement.quantity import quantities
from escapement.scene import Scene
from escapement.status import Status
from escapement.study.plan import StudyPlan
from escapement.study.result import RESULTS

FOLLOWER = "follower_inertia"
CLOCKED = TORQUE, LOAD, SPEED = "torque", "load_torque", "initial_speed"
"""Numbers that change only the unit of time where there is neither load nor initial speed."""
DECIDING = {*quantities(Escapement), *quantities(Inertia), SPEED}
"""Numbers of the model and of a run that decide a scene."""
MOST_SHARED = 1 << 20
"""Scenes that are kept for all blocks of a study: 50 MiB."""

_SPEEDS = ("velocity_max", "velocity_min", "velocity_mean")
_TIMES = ("period", "rise_time", "settling_time")

Columns = dict[str, NDArray[Any]]
"""One array per result, over some cases."""
SceneFigures = tuple[FloatArray, NDArray[np.uint8]]
"""Largest, smallest and mean velocity, period, rise and settling time in natural units,
shape (6, n), and the status, shape (n,)."""


class Sharing(NamedTuple):
    """The scenes that the cases of a plan have in common.

    shape : of the plan's dimensions, 1 where a dimension leaves the scene alone.
    which : number of the scene at each place of this shape, flat.
    cases : the first case of each scene.
    """

    shape: tuple[int, ...]
    which: NDArray[np.int64]
    cases: NDArray[np.int64]


class SharedScenes(NamedTuple):
    """Scenes with their figures, of which any block takes its own."""

    sharing: Sharing
    figures: FloatArray
    status: NDArray[np.uint8]

    def of(self, plan: StudyPlan, cases: NDArray[np.int64]) -> SceneFigures:
        """Figures of the scenes of consecutive cases, as `solve_scenes` gives them."""
        shape, which, _ = self.sharing
        grid = np.broadcast_to(which.reshape(shape), plan.shape)
        scenes = grid.flat[int(cases[0]) : int(cases[-1]) + 1]
        return self.figures[:, scenes], self.status[scenes]


def shared_scenes(plan: StudyPlan) -> Sharing | None:
    """The scenes to solve before the blocks of a plan; None where that saves or suits nothing."""
    deciding = {*plan.parameters}
    if not np.any(plan.every(SPEED)) and not np.any(plan.every(LOAD)):
        deciding -= {*CLOCKED}
    sizes = zip(plan.shape, plan.varied.values(), strict=True)
    shape = tuple(1 if deciding.isdisjoint(names) else size for size, names in sizes)
    if plan.solver.engine != "energy" or not math.prod(shape) < min(plan.cases, MOST_SHARED + 1):
        return None
    places = np.indices(shape).reshape(len(shape), -1)
    cases = np.asarray(np.ravel_multi_index(tuple(places), plan.shape))
    machine, scene, _ = _numbers(plan, cases)
    first, which = _distinct(np.array([*scene, *machine]))
    return Sharing(shape, which, cases[first])


def solve_scenes(plan: StudyPlan, cases: NDArray[np.int64]) -> SceneFigures:
    """Figures of the scenes of some cases, none of them solved twice."""
    machine, scene, sound = _numbers(plan, cases)
    first, which = _distinct(np.array([*scene, *machine]))
    figures = np.full((6, first.size), np.nan)
    status = np.full(first.size, Status.INVALID, dtype=np.uint8)
    # the mechanism is the last key of the order, so that its scenes follow each other
    other = np.any([np.diff(column[first]) != 0 for column in machine], axis=0)
    for rows in np.split(np.arange(first.size), np.flatnonzero(other) + 1):
        rows = rows[sound[first[rows]]]
        if rows.size == 0:
            continue
        # a mechanism that cannot be built, or cannot move, must not end the study
        with contextlib.suppress(InvalidValue):
            mechanism = plan.mechanism(int(cases[first[rows[0]]]))
            figures[:, rows], status[rows] = _solve(
                mechanism, scene[:, first[rows]], plan.solver.tolerance
            )
    return figures[:, which], status[which]


def _numbers(
    plan: StudyPlan, cases: NDArray[np.int64]
) -> tuple[list[NDArray[Any]], FloatArray, NDArray[np.bool_]]:
    """What decides scenes: of the mechanism, the rest (k, n), and whether it is in range."""
    columns = plan.columns(cases)
    numbers = {
        name: np.broadcast_to(np.asarray(value, dtype=float), cases.shape)
        for name, value in (plan.fixed_si | columns).items()
        if name in DECIDING
    }
    with np.errstate(all="ignore"):  # what is out of range is told by the status
        ratios = natural(numbers, plan.kind.meshed)
        w = numbers[SPEED] ** 2 * (numbers[FOLLOWER] / numbers[TORQUE])
        sound = ratio_in_range(ratios["rho"]) & (ratios["load"] < MOST_UNEQUAL)
        sound &= w <= MOST_UNEQUAL**2
    scene = np.array([*(ratios[name] for name in Scene._fields if name in ratios), w])
    return [columns[name] for name in plan.kind.parameters if name in columns], scene, sound


def _distinct(key: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Index of the first of equal columns, in the order of the last key, and which is whose."""
    order = np.lexsort(key)
    ordered = key[:, order]
    new = np.append(True, (ordered[:, 1:] != ordered[:, :-1]).any(axis=0))
    which = np.empty(order.size, dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    return order[new], which


def _solve(mechanism: Any, scene: FloatArray, rtol: float) -> SceneFigures:
    """Solve the scenes of one mechanism, shape (k, n)."""
    from escapement.engines.energy import batch, cycle

    table, status = batch.solve(mechanism, np.ascontiguousarray(scene), rtol)
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
    return figures, status


def evaluate(plan: StudyPlan, start: int, stop: int, shared: SharedScenes | None = None) -> Columns:
    """Results of the cases start <= case < stop; a bad case never ends the study."""
    cases = np.arange(start, stop)
    if plan.solver.engine == "energy":
        found = solve_scenes(plan, cases) if shared is None else shared.of(plan, cases)
        return _on_their_clocks(plan, cases, *found)
    columns = {name: np.full(cases.size, np.nan) for name in RESULTS}
    columns["status"] = np.zeros(cases.size, np.uint8)
    for row, case in enumerate(cases.tolist()):
        _fill(columns, row, plan, case)
    return columns


def _on_their_clocks(
    plan: StudyPlan, cases: NDArray[np.int64], figures: FloatArray, status: NDArray[np.uint8]
) -> Columns:
    """Figures of scenes in SI: the unit of time is the root of I_f / torque."""
    values = plan.fixed_si | plan.columns(cases)
    with np.errstate(all="ignore"):
        square = np.divide(values[FOLLOWER], values[TORQUE])
    bad = np.broadcast_to(~ratio_in_range(square), cases.shape)
    if bad.any():
        figures[:, bad], status[bad] = np.nan, Status.INVALID
        square = np.where(bad, 1.0, square)
    clock = np.sqrt(square)
    columns = {name: line / clock for name, line in zip(_SPEEDS, figures[:3], strict=True)}
    columns |= {name: line * clock for name, line in zip(_TIMES, figures[3:], strict=True)}
    return columns | {"status": status}


def _fill(columns: Columns, row: int, plan: StudyPlan, case: int) -> None:
    """One case by an engine that solves them one by one."""
    speed = plan.values(case)[SPEED]
    try:
        figures = simulation.terminal(
            plan.escapement(case), initial_speed=speed, **plan.solver.given
        )
    except InvalidValue:
        columns["status"][row] = Status.INVALID
    except (ArithmeticError, ValueError, RuntimeError):
        columns["status"][row] = Status.NOT_CONVERGED
    else:
        for name, column in columns.items():
            column[row] = getattr(figures, name)
