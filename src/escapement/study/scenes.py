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
from escapement.model import MOST_UNEQUAL, FloatArray, ratio_in_range
from escapement.simulation import FASTEST
from escapement.status import Status
from escapement.study.plan import StudyPlan

DRIVER, FOLLOWER = "driver_inertia", "follower_inertia"
CLOCKED = TORQUE, LOAD, SPEED = "torque", "load_torque", "initial_speed"
"""What a scene depends on through the clock alone where there is neither load nor start."""
NUMBERS = DRIVER, FOLLOWER, *CLOCKED

Figures = tuple[FloatArray, NDArray[np.uint8]]
"""Largest, smallest and mean velocity, period, rise and settling time in natural units,
shape (6, n), and the status, shape (n,)."""


def solve_scenes(plan: StudyPlan, cases: NDArray[np.int64]) -> Figures:
    """Figures of the scenes of some cases, none of them solved twice."""
    columns = plan.columns(cases)
    values = plan.fixed_si | columns
    driver, follower, torque, load, speed, loss = (
        np.broadcast_to(np.asarray(values[name], dtype=float), cases.shape)
        for name in (*NUMBERS, plan.kind.loss)
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
    from escapement.engines.energy import batch, cycle

    order = np.lexsort(scene)
    ordered = scene[:, order]
    new = np.append(True, (ordered[:, 1:] != ordered[:, :-1]).any(axis=0))
    which = np.empty(order.size, dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    rho, mu, load, w = np.ascontiguousarray(ordered[:, new])
    table, status = batch.solve(mechanism, rho, mu, load, w, rtol)
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
