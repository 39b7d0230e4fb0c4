"""Scenes of a plan: what is left of its cases once time is measured in natural units.

There a case is its mechanism, inertia ratio, loss, load ratio and starting speed.
Without a load and from rest torque is a pure change of clock and leaves all of these
alone: cases that differ in nothing else share a scene, and a scene is solved once.
"""

import contextlib
from typing import Any

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
from escapement.simulation import FASTEST
from escapement.status import Status
from escapement.study.plan import StudyPlan

DRIVER, FOLLOWER = "driver_inertia", "follower_inertia"
CLOCKED = TORQUE, LOAD, SPEED = "torque", "load_torque", "initial_speed"
"""What a scene depends on through the clock alone where there is neither load nor start."""
DECIDING = {*quantities(Escapement), *quantities(Inertia), SPEED}
"""Numbers of the model and of a run that decide a scene."""

Figures = tuple[FloatArray, NDArray[np.uint8]]
"""Largest, smallest and mean velocity, period, rise and settling time in natural units,
shape (6, n), and the status, shape (n,)."""


def solve_scenes(plan: StudyPlan, cases: NDArray[np.int64]) -> Figures:
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
        sound &= w <= FASTEST**2
    scene = np.array([*(ratios[name] for name in Scene._fields if name in ratios), w])
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
