"""Cases that kernels solve many at a time, checked by their energy balance.

The kernels of a study compute figures of merit and no balance. Of every slice some scenes are
computed once more by `escapement.terminal`, which simulates the cycle and whose energy balance
decides on the status. If one of them is wrong, all scenes of the slice are checked.
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
"""Of so many scenes one is checked, which takes as long as some fifty others."""
ALIKE = 1e-6
"""Relative difference of two results that count as equal [-]."""
_COMPARED = {"velocity_max": 1, "velocity_min": 1, "velocity_mean": 1, "period": -1}
"""Results that are compared, and the power of the unit of time that makes them dimensionless."""


def check_scenes(
    plan: StudyPlan, cases: NDArray[np.int64], figures: FloatArray, status: NDArray[np.uint8]
) -> None:
    """Check some of the scenes of a slice, and all of them if one is wrong.

    Parameters
    ----------
    plan : StudyPlan
    cases : ndarray, shape (n,)
        A case of each scene.
    figures, status : ndarray, shapes (k, n) and (n,)
        As `scenes.solve_scenes` gives them. A wrong scene becomes NOT_CONVERGED, without figures.
    """
    _judge_known(plan, figures, status)
    if all(_is_right(plan, cases[i], figures[:, i]) for i in _sample(cases, figures, status)):
        return
    for i in np.flatnonzero(status == Status.OK):
        if not _is_right(plan, cases[i], figures[:, i]):
            figures[:, i], status[i] = np.nan, Status.NOT_CONVERGED


def _judge_known(plan: StudyPlan, figures: FloatArray, status: NDArray[np.uint8]) -> None:
    """Judge all scenes by the residual of their energy balance, where it is a result."""
    names = _names(plan)
    if "energy_residual" in names:
        row = names.index("energy_residual")
        limit = max(TOLERATED, plan.solver.tolerance)
        wrong = (status == Status.OK) & ~(np.abs(figures[row]) <= limit)
        others = np.arange(len(names)) != row
        figures[np.ix_(others, wrong)], status[wrong] = np.nan, Status.NOT_CONVERGED


def _names(plan: StudyPlan) -> list[str]:
    """The results of a study but the status, as `figures` has them."""
    return [name for name in plan.results if name != "status"]


def _sample(
    cases: NDArray[np.int64], figures: FloatArray, status: NDArray[np.uint8]
) -> NDArray[np.intp]:
    """Scenes to check: some with the greatest or the least figures, others in every slice.

    A slice of fewer than `EVERY` scenes has one only at the start of a study.
    """
    sound = np.flatnonzero(status == Status.OK)
    count = sound.size // EVERY + bool(sound.size and cases.min() == 0)
    if count == 0:
        return sound[:0]
    rows = figures[:, sound][~np.isnan(figures[:, sound]).any(axis=1)]
    extremes = np.concatenate([rows.argmax(axis=1), rows.argmin(axis=1), [sound.size // 2]])
    return np.asarray(sound[np.unique(np.roll(extremes, -int(cases[0]))[:count])])


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
        for name, value in zip(_names(plan), figures.tolist(), strict=True)
        if name in _COMPARED
    )
