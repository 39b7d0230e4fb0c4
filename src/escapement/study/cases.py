"""Results of cases: from their scenes, each with its own unit of time, or one by one."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement.base import units
from escapement.base.errors import InvalidValue
from escapement.base.quantity import declared
from escapement.base.status import Status
from escapement.dynamics.figure_table import RUN_TIME
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines import simulate as simulation
from escapement.engines.run_down import ROUNDING, rundown
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement
from escapement.model.materials import NEEDED, pin_stresses
from escapement.model.train import referred
from escapement.study import scenes
from escapement.study.index_cases import evaluate_drives
from escapement.study.plan import StudyPlan
from escapement.study.subject import DRIVE

Columns = dict[str, NDArray[Any]]
"""One array per result, over some cases."""


def evaluate(
    plan: StudyPlan, start: int, stop: int, shared: scenes.SharedScenes | None = None
) -> Columns:
    """Results of the cases start <= case < stop; a bad case never ends the study."""
    cases = np.arange(start, stop)
    if plan.subject is DRIVE:
        return _in_its_units(plan, evaluate_drives(plan, cases))
    if scenes.together(plan):
        found = scenes.solve_scenes(plan, cases) if shared is None else shared.of(plan, cases)
        return _on_their_clocks(plan, cases, *found)
    alone = [_alone(plan, case) for case in cases.tolist()]
    columns = {name: np.array([getattr(it, name) for it in alone], "<f8") for name in plan.results}
    return _in_its_units(plan, columns)


def _on_their_clocks(
    plan: StudyPlan, cases: NDArray[np.int64], figures: FloatArray, status: NDArray[np.uint8]
) -> Columns:
    """Figures of scenes in SI: the unit of time is the root of I_f / torque."""
    given = plan.fixed_si | plan.columns(cases)
    values = referred(given)
    clock = np.sqrt(np.divide(values[scenes.FOLLOWER], values[scenes.TORQUE]))
    torques = values[scenes.TORQUE], given[scenes.TORQUE]
    found = {
        name: line * scenes.si_unit(name, clock, *torques)
        for name, line in zip(plan.solved, figures, strict=True)
    }
    found["status"] = status
    if not NEEDED.keys().isdisjoint(plan.results):
        numbers = {name: entry.default for name, entry in declared(Escapement).items()}
        numbers |= {name: x for name, x in given.items() if x is not None}
        force, rubbing = (found.get(name, np.nan) for name in dict.fromkeys(NEEDED.values()))
        found |= pin_stresses(force, rubbing, plan.lengths | numbers)
    return _in_its_units(plan, found)


def _in_its_units(plan: StudyPlan, found: Columns) -> Columns:
    """Results in the units and types of the file, from those in SI."""
    system = plan.configuration["units"]
    return {
        name: (found[name] / units.factor(result.kind, system)).astype(result.dtype, copy=False)
        for name, result in plan.results.items()
    }


def solved(plan: StudyPlan, values: Mapping[str, Any], **solver: Any) -> Figures:
    """Figures of a case with these values of its settings in SI, its run time if that is asked for.

    Raises
    ------
    InvalidValue
        When the values are not possible together.
    """
    escapement, speed = plan.built(values), values[scenes.SPEED] or 0.0
    found = simulation.terminal(escapement, initial_speed=speed, **solver)
    if RUN_TIME in plan.results:
        turns = values["turns"]
        run = rundown(escapement, turns=turns, initial_speed=speed)
        arrives = run.end_turns >= turns * (1.0 - ROUNDING)
        vars(found)[RUN_TIME] = run.time_of(turns) if arrives else math.nan
    return found


def _alone(plan: StudyPlan, case: int) -> Figures:
    """One case by an engine that solves them one by one."""
    given = plan.solver.given
    if plan.solver.engine == "contact":
        # on an axis that begins with zero clearance, each case has the engine that it needs
        del given["engine"]
    try:
        found = solved(plan, plan.values(case), **given)
        found.energy_residual  # noqa: B018 - the status depends on it
        return found
    except InvalidValue:
        return Figures(status=Status.INVALID)
    except (ArithmeticError, ValueError, RuntimeError):
        return Figures(status=Status.NOT_CONVERGED)
