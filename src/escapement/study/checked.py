"""Cases that kernels solve many at a time, checked by their energy balance.

The kernels of a study compute figures of merit and no balance. Of every slice some scenes are
computed once more by `escapement.terminal`, which simulates the cycle and whose energy balance
decides on the status. If one of them is wrong, all scenes of the slice are checked. A process
checks the first scenes of each kind, and then one of so many, however small its studies are.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement.base.status import Status
from escapement.dynamics.energy_balance import TOLERATED
from escapement.engines import simulate as simulation
from escapement.mechanisms.protocol import FloatArray
from escapement.study.plan import StudyPlan

EVERY = 2048
"""Of so many scenes of a kind one is checked, which takes as long as some hundred others."""
ALIKE = 1e-6
"""Relative difference of two results that count as equal [-]."""
_solved: dict[Any, int] = {}
"""Scenes of each kind that this process has solved since one of them was checked."""
_COMPARED = {"velocity_max": 1, "velocity_min": 1, "velocity_mean": 1, "period": -1}
"""Results that are compared, and the power of the unit of time that makes them dimensionless."""


def check_scenes(
    plan: StudyPlan,
    kind: Any,
    cases: NDArray[np.int64],
    figures: FloatArray,
    status: NDArray[np.uint8],
) -> None:
    """Check some of the scenes of a slice, and all of them if one is wrong.

    Parameters
    ----------
    plan : StudyPlan
    kind : hashable
        What the scenes have in common; the first ones of a kind are always checked.
    cases : ndarray, shape (n,)
        A case of each scene.
    figures, status : ndarray, shapes (k, n) and (n,)
        As `scenes.solve_scenes` gives them. A wrong scene becomes NOT_CONVERGED, without figures.
    """
    _judge_known(plan, figures, status)
    sound = np.flatnonzero(status == Status.OK)
    some = _sample(sound, _due(kind, sound.size), figures, int(cases[0]))
    if all(_is_right(plan, cases[i], figures[:, i]) for i in some):
        return
    _solved.pop(kind, None)  # the next ones are checked at once
    for i in sound:
        if not _is_right(plan, cases[i], figures[:, i]):
            figures[:, i], status[i] = np.nan, Status.NOT_CONVERGED


def _due(kind: Any, count: int) -> int:
    """How many scenes to check when so many of a kind were solved."""
    if count == 0:
        return 0
    due, rest = divmod(_solved.get(kind, EVERY) + count, EVERY)
    _solved[kind] = rest
    return due


def _judge_known(plan: StudyPlan, figures: FloatArray, status: NDArray[np.uint8]) -> None:
    """Judge all scenes by the residual of their energy balance, where it is a result."""
    names = plan.solved
    if "energy_residual" in names:
        row = names.index("energy_residual")
        limit = max(TOLERATED, plan.solver.tolerance)
        wrong = (status == Status.OK) & ~(np.abs(figures[row]) <= limit)
        others = np.arange(len(names)) != row
        figures[np.ix_(others, wrong)], status[wrong] = np.nan, Status.NOT_CONVERGED


def _sample(
    sound: NDArray[np.intp], count: int, figures: FloatArray, first: int
) -> NDArray[np.intp]:
    """So many scenes to check: those with the greatest or the least figures, in turn."""
    if count == 0:
        return sound[:0]
    rows = figures[:, sound][~np.isnan(figures[:, sound]).any(axis=1)]
    extremes = np.concatenate([rows.argmax(axis=1), rows.argmin(axis=1), [sound.size // 2]])
    return np.asarray(sound[np.unique(np.roll(extremes, -first)[:count])])


def _is_right(plan: StudyPlan, case: Any, figures: FloatArray) -> bool:
    """Whether `terminal` computes the same figures for the scene of a case, and they balance."""
    escapement, speed = plan.escapement(int(case)), plan.values(int(case))["initial_speed"]
    found = simulation.terminal(escapement, initial_speed=speed, **plan.solver.given)
    if found.outcome is Status.INVALID:
        return True  # the numbers of this case are out of range, which says nothing of its scene
    if found.status is not Status.OK:
        return False
    limit = max(ALIKE, plan.solver.tolerance)
    return all(
        abs(value / (getattr(found, name) * escapement.time_unit ** _COMPARED[name]) - 1.0) <= limit
        for name, value in zip(plan.solved, figures.tolist(), strict=True)
        if name in _COMPARED
    )
