"""Evaluating consecutive cases of a plan, with no scene solved twice.

In natural units a case is its mechanism, inertia ratio, loss, load ratio and
starting speed. Without a load and from rest torque is a pure change of clock and
leaves all of these alone, as do inertias in the same ratio: cases that share
them share one solve.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement import simulation
from escapement.configuration import StudyPlan
from escapement.errors import InvalidValue
from escapement.status import Status
from escapement.store import RESULTS

Columns = dict[str, NDArray[Any]]
"""One array per result, over consecutive cases."""


def evaluate(plan: StudyPlan, start: int, stop: int) -> Columns:
    """Results of the cases start <= case < stop: a bad one never ends the study."""
    if plan.solver.engine == "energy":
        return _in_one_batch(plan, start, stop)
    block = _empty(stop - start)
    for row, case in enumerate(range(start, stop)):
        _fill(block, row, plan, case)
    return block


def _empty(size: int) -> Columns:
    return {
        name: np.full(size, np.nan if name != "status" else 0, result.dtype)
        for name, result in RESULTS.items()
    }


def _fill(block: Columns, row: int, plan: StudyPlan, case: int) -> None:
    try:
        figures = simulation.terminal(
            plan.escapement(case),
            initial_speed=plan.values(case)["initial_speed"],
            **plan.solver.given,
        )
    except InvalidValue:
        block["status"][row] = Status.INVALID
        return
    except (ArithmeticError, ValueError, RuntimeError):
        block["status"][row] = Status.NOT_CONVERGED
        return
    for name, column in block.items():
        column[row] = getattr(figures, name)


def _in_one_batch(plan: StudyPlan, start: int, stop: int) -> Columns:
    """All cases of a block, one batch for each mechanism in it."""
    places = np.unravel_index(np.arange(start, stop), plan.shape)
    columns = plan.columns(start, stop)
    block = _empty(stop - start)
    by_mechanism = [
        (place, size)
        for name, place, size in zip(plan.axes, places, plan.shape, strict=True)
        if name in plan.kind.parameters
    ]
    wheel = _mixed_radix(by_mechanism, stop - start)
    for value in np.unique(wheel):
        rows = np.nonzero(wheel == value)[0]
        try:
            mechanism = plan.escapement(start + int(rows[0])).mechanism
        except InvalidValue:
            block["status"][rows] = Status.INVALID
            continue
        fixed = plan.values(start + int(rows[0]))
        values = {
            name: columns[name][rows] if name in columns else np.full(rows.size, fixed[name])
            for name in (plan.kind.loss, *_NUMBERS)
        }
        chosen = {name: (place[rows], size) for name, place, size in
                  zip(plan.axes, places, plan.shape, strict=True)}  # fmt: skip
        solved = _solve(mechanism, values, _scenes(values, chosen), simulation.rtol_of(plan.solver))
        for name, column in solved.items():
            block[name][rows] = column
    return block


_NUMBERS = (
    "torque",
    "load_torque",
    "driver_inertia",
    "follower_inertia",
    "initial_speed",
)


def _mixed_radix(parts: list[tuple[NDArray[Any], int]], size: int) -> NDArray[np.int64]:
    """One number per case that tells combinations of places apart."""
    key = np.zeros(size, dtype=np.int64)
    for place, length in parts:
        key = key * length + place
    return key


def _scenes(values: Columns, places: dict[str, tuple[NDArray[Any], int]]) -> NDArray[np.int64]:
    """A number per case that is the same where the scene is."""
    size = values["torque"].size
    timed = bool(values["load_torque"].any() or values["initial_speed"].any())
    names = [
        "friction",
        "efficiency",
        "load_torque",
        "initial_speed",
        *(["torque"] if timed else []),
    ]
    inertias = [name for name in ("driver_inertia", "follower_inertia") if name in places]
    parts = [places[name] for name in names if name in places]
    if len(inertias) == 2 and not timed:
        _, ratio = np.unique(
            values["driver_inertia"] / values["follower_inertia"], return_inverse=True
        )
        parts.append((ratio, size))
    else:
        parts += [places[name] for name in inertias]
    if math.prod(length for _, length in parts) >= 2**62:
        return np.arange(size, dtype=np.int64)
    return _mixed_radix(parts, size)


def _solve(mechanism: Any, values: Columns, scenes: NDArray[np.int64], rtol: float) -> Columns:
    """Solve each scene once and put every case on its own clock."""
    from escapement.engines import _cycle, _energy_batch

    _, first, scene_of_case = np.unique(scenes, return_index=True, return_inverse=True)
    driver, follower = values["driver_inertia"], values["follower_inertia"]
    torque = values["torque"]
    clock = np.sqrt(follower / torque)
    ratio = driver / follower
    load = values["load_torque"] / torque
    start = (values["initial_speed"] * clock) ** 2
    meshed = "efficiency" in values
    loss = 1.0 / values["efficiency"] - 1.0 if meshed else values["friction"].astype(float)
    table, status = _energy_batch.solve(
        mechanism, ratio[first], loss[first], load[first], start[first], rtol
    )
    columns = table[scene_of_case].T
    period = columns[_cycle.PERIOD] * clock
    return {
        "velocity_max": columns[_cycle.V_MAX] / clock,
        "velocity_min": columns[_cycle.V_MIN] / clock,
        "velocity_mean": mechanism.cell_angle / period,
        "period": period,
        "rise_time": columns[_cycle.RISE] * clock,
        "settling_time": columns[_cycle.SETTLING] * clock,
        "status": status[scene_of_case],
    }
