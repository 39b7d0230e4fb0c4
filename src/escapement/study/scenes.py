"""Solving the scenes of some cases of a plan, equal ones once.

In natural units a case is its mechanism, inertia ratio, losses, load ratio and starting speed.
From rest, without a load, a constant bearing torque and viscous drag, the torque changes only the
unit of time, so cases that differ only in torque have the same scene.
"""

import contextlib
import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.base.errors import InvalidValue
from escapement.base.quantity import quantities
from escapement.base.status import Status
from escapement.dynamics.figure_table import FIGURES, PEAKS, RUN_TIME, TRANSIENT
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines import simulate as simulation
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.wheel_checks import IMPERFECT, LENGTHS
from escapement.model.checks import is_given
from escapement.model.escapement import Escapement, Inertia
from escapement.model.natural import natural, resisting
from escapement.model.numbers import full_torque
from escapement.model.scene import Scene
from escapement.model.train import referred, train_numbers
from escapement.study.checked import check_scenes
from escapement.study.plan import StudyPlan
from escapement.study.subject import ESCAPEMENT

FOLLOWER = "follower_inertia"
TORQUE, SPEED = "torque", "initial_speed"
TORQUES = tuple(entry.name for entry in resisting() if entry.unit in ("torque", "viscous"))
"""Numbers that are compared with the torque; where these and the initial speed are all zero the
torque changes only the unit of time."""
DECIDING = {*quantities(Escapement), *quantities(Inertia), *train_numbers(), SPEED, *LENGTHS}
"""Numbers of the model and of a run that decide a scene."""
NO_LOAD = "no_load_speed"
MOST_SHARED = 1 << 20
"""Scenes that are kept for all blocks of a study: 50 MiB."""

_FORMULAS = ("velocity_mean", "velocity_average_published", "pin_load_frequency")
"""Figures that follow from others."""
_ALONE, _APART, _RUNDOWN, _INTEGRATED = 1e-3, 3e-3, 1e-2, 0.3
"""Rough times [s] of a case that is built as an escapement, of one whose torque or load depends on
angle or speed, of one that runs down, and of one by the reference engine."""
_ALL = "all figures"
_PIN = Scene._fields.index("pin") - Scene._fields.index("rho")
_LIMITS = ("critical_friction", "uniqueness_friction", "jam_margin")
"""Figures that a case has even if it does not move."""

SceneFigures = tuple[FloatArray, NDArray[np.uint8]]
"""The figures of merit `StudyPlan.solved` in natural units, shape (k, n), and the status, shape
(n,)."""


class Scenes(NamedTuple):
    """Different scenes, in the order of their mechanisms.

    cases : the first case of each, shape (n,).
    machine : what varies of the mechanisms but errors of their parts, shape (m, n).
    numbers : of each scene, shape (k, n).
    sound : whether these are in range, shape (n,).
    """

    cases: NDArray[np.int64]
    machine: FloatArray
    numbers: FloatArray
    sound: NDArray[np.bool_]


class SharedScenes(NamedTuple):
    """The different scenes of the cases of a plan, from which each block uses some.

    shape : of the plan's dimensions, 1 where a dimension does not change the scene.
    which : number of the scene at each index of this shape, flat.
    cases : the first case of each scene.
    figures, status : of each scene, as `solve_scenes` gives them; None until it is solved.
    """

    shape: tuple[int, ...]
    which: NDArray[np.int64]
    cases: NDArray[np.int64]
    figures: Any = None
    status: Any = None

    def of(self, plan: StudyPlan, cases: NDArray[np.int64]) -> SceneFigures:
        """Figures of the scenes of consecutive cases, as `solve_scenes` gives them."""
        grid = np.broadcast_to(self.which.reshape(self.shape), plan.shape)
        scenes = grid.flat[int(cases[0]) : int(cases[-1]) + 1]
        return self.figures[:, scenes], self.status[scenes]


def scene_shape(plan: StudyPlan) -> tuple[int, ...]:
    """Sizes of the dimensions of a plan, 1 where a dimension does not change the scene."""
    deciding = {*plan.parameters}
    if not any(is_given(plan.every(x)) for x in (SPEED, NO_LOAD, *TORQUES) if x in deciding):
        deciding -= {TORQUE, SPEED, NO_LOAD, *TORQUES}
    sizes = zip(plan.shape, plan.varied.values(), strict=True)
    return tuple(1 if deciding.isdisjoint(names) else size for size, names in sizes)


def shared_scenes(plan: StudyPlan) -> tuple[SharedScenes, Scenes] | None:
    """The scenes to solve before the blocks of a plan; None if that is useless or impossible."""
    shape = scene_shape(plan)
    if not together(plan) or math.prod(shape) >= min(plan.cases, MOST_SHARED + 1):
        return None
    indices = np.unravel_index(np.arange(math.prod(shape)), shape)
    cases = np.asarray(np.ravel_multi_index(indices, plan.shape))
    found, which = _distinct(plan, cases, shape)
    return SharedScenes(shape, which, found.cases), found


def solve_scenes(plan: StudyPlan, cases: NDArray[np.int64]) -> SceneFigures:
    """Figures of the scenes of some cases, none of them solved twice."""
    found, which = _distinct(plan, cases, scene_shape(plan))
    figures, status = solve_distinct(plan, found)
    return figures[:, which], status[which]


def solve_distinct(plan: StudyPlan, found: Scenes) -> SceneFigures:
    """Figures of different scenes, in their order."""
    cases, machine, scene, sound = found
    figures = np.full((len(plan.solved), cases.size), np.nan)
    status = np.full(cases.size, Status.INVALID, dtype=np.uint8)
    # the mechanism is the primary key of the order, so that its scenes follow each other
    other = np.flatnonzero((np.diff(machine) != 0).any(axis=0)) + 1
    for first, end in pairwise([0, *other.tolist(), cases.size]):
        rows: Any = slice(first, end)
        if not sound[rows].all():
            rows = first + np.flatnonzero(sound[rows])
        # a mechanism that cannot be built, or cannot move, must not end the study
        with contextlib.suppress(InvalidValue):
            if cases[rows].size:
                mechanism: Any = plan.mechanism(int(cases[rows][0]), ideal=True)
                if scene[_PIN, rows].any():
                    rows = np.arange(cases.size)[rows]
                    rows = rows[scene[_PIN, rows] < mechanism.widest_pin]
                figures[:, rows], status[rows] = _solve(
                    plan, mechanism, scene[:, rows], cases[rows]
                )
    check_scenes(plan, _kind(plan, scene), cases, figures, status)
    return figures, status


def _kind(plan: StudyPlan, numbers: FloatArray) -> Any:
    """What decides on the compiled code: the mechanism, and which numbers occur, shape (k, n)."""
    build = plan.build if isinstance(plan.build, type) else type(plan.build)
    return build, plan.perfect, numbers.any(axis=1).tobytes()


def _distinct(
    plan: StudyPlan, cases: NDArray[np.int64], shape: tuple[int, ...]
) -> tuple[Scenes, NDArray[np.int64]]:
    """The scenes of some cases, each once, and which of them each case has.

    shape : `scene_shape` of the plan.
    """
    columns, ratios, w, sound = _in_natural_units(plan, cases, shape)
    scene = [*(ratios[name] for name in Scene._fields if name in ratios), w]
    machine = [name for name in columns if plan.parameters[name].section == "mechanism"]
    # the path of a pin does not depend on its width
    machine = [name for name in machine if name not in LENGTHS]
    errors = [name for name in machine if name.startswith(IMPERFECT)]
    others = [columns[name] for name in machine if name not in errors]
    rows = [*scene, *(columns[name] for name in errors), *others]
    # numbers that are the same in all cases need not be compared
    key = np.array([row for row in rows if _varies(row)] or [np.zeros(cases.size)])
    order = np.lexsort(key)
    ordered = key[:, order]
    new = np.append(True, (ordered[:, 1:] != ordered[:, :-1]).any(axis=0))
    which = np.empty(order.size, dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    first = order[new]
    return Scenes(cases[first], _at(first, others), _at(first, scene), sound[first]), which


def _at(first: NDArray[np.int64], rows: Sequence[Any]) -> FloatArray:
    """The numbers or arrays of rows at some cases, shape (k, n)."""
    table = np.empty((len(rows), first.size))
    table.T[:] = [0.0 if _varies(row) else row for row in rows]
    for i, row in enumerate(rows):
        if _varies(row):
            table[i] = row[first]
    return table


def _varies(row: Any) -> bool:
    """Whether this is an array with a number for each case, and not one number for all."""
    return isinstance(row, np.ndarray) and row.ndim > 0


def _in_natural_units(
    plan: StudyPlan, cases: NDArray[np.int64], shape: tuple[int, ...]
) -> tuple[Any, ...]:
    """What varies over the scenes of some cases [SI], the numbers of these scenes, the squared
    speed at the first entry, and whether their rollers fit on their pins.
    """
    columns = plan.columns(cases)
    for along, given, size in zip(plan.varied.values(), plan.shape, shape, strict=True):
        if size < given:  # any of its values will do
            columns |= {name: columns[name][0] for name in along}
    fixed = {
        name: value
        for name, value in (plan.fixed_si | plan.lengths).items()
        if name in DECIDING and value is not None and name not in columns
    }
    numbers = referred(fixed | {name: columns[name] for name in columns if name in DECIDING})
    ratios, sound = natural(numbers, plan.meshed), np.True_
    w = numbers[SPEED] ** 2 * (numbers[FOLLOWER] / numbers[TORQUE])
    if "roller_radius" in numbers:
        pin, roller = numbers["pin_radius"], numbers["roller_radius"]
        sound = (roller == 0.0) | ((pin > 0.0) & (pin < roller))
    return columns, ratios, w, np.broadcast_to(sound, cases.shape)


def _solve(
    plan: StudyPlan, mechanism: Any, scene: FloatArray, cases: NDArray[np.int64]
) -> SceneFigures:
    """Solve the scenes of one mechanism, shape (k, n), to which these cases belong."""
    from escapement.engines.energy import batch, cycle

    errors = None if plan.perfect else _errors(plan, mechanism, cases)
    table, status = batch.solve(mechanism, scene, plan.solver.tolerance, _extent(plan), errors)
    found = dict(zip(cycle.COLUMNS, table.T, strict=True))
    wanted = {*PEAKS} & {*plan.solved}
    if wanted and plan.perfect:
        given = mechanism, scene, found["handoff_velocity"], plan.solver.tolerance
        # forces are in units of torque over a length that no case changes
        crank = plan.lengths["crank_radius"] or np.nan
        units = {"contact_force_max": 1.0 / crank, "rubbing_max": crank / crank}
        found |= {n: x * units.get(n, 1.0) for n, x in batch.peaks(*given, wanted).items()}
    return _in_order(plan, mechanism, found, cases), status


def _errors(
    plan: StudyPlan, wheel: Any, cases: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Errors of the parts in each case, in units of the crank radius, for `batch.solve`."""
    values, unit = plan.fixed_si | plan.columns(cases), plan.lengths["crank_radius"] or 1.0

    def each(name: str, count: int, scale: float = 1.0) -> FloatArray:
        fixed, factor = values.get(name) or (0.0,) * count, values.get(f"{name}_factor", 1.0)
        found = (factor * values.get(f"{name}_{i}", fixed[i]) for i in range(count))
        return np.stack([np.full(cases.shape, x, dtype=float) for x in found], axis=-1) / scale

    pins = each("pin_angle_errors", wheel.pins), each("crank_radius_errors", wheel.pins, unit)
    slots = each("slot_angle_errors", wheel.slots), each("slot_offsets", wheel.slots, unit)
    longer = np.full(cases.shape, values["centre_distance_error"], dtype=float) / unit
    return longer, np.stack(pins, axis=-1), np.stack(slots, axis=-1)


def _extent(plan: StudyPlan) -> int:
    """How far the motions of a plan are followed from their start."""
    from escapement.engines.energy.case_figures import Extent

    wanted = {*plan.solved}
    if not wanted.isdisjoint(("rise_time_63", "rise_time_98")):
        return Extent.FALLEN
    return Extent.CYCLE if wanted.isdisjoint(TRANSIENT) else Extent.SETTLED


def _in_order(
    plan: StudyPlan, mechanism: Any, found: dict[str, FloatArray], cases: NDArray[np.int64]
) -> FloatArray:
    """The figures that a study keeps, from the kernels and from each case separately."""
    found["velocity_mean"] = mechanism.cell_angle / found["period"]
    found["velocity_average_published"] = 0.5 * (found["velocity_max"] + found["velocity_min"])
    if "pin_load_frequency" in plan.solved:
        pins = math.nan if plan.meshed else mechanism.pins
        found["pin_load_frequency"] = 1.0 / (pins * found["period"])
    others = [name for name in plan.solved if name not in found]
    if others:  # each case is then built as an escapement, which takes longer than to solve it
        handoffs = zip(cases.tolist(), found["handoff_velocity"], strict=True)
        rows = [_rest(plan, case, others, handoff) for case, handoff in handoffs]
        found |= dict(zip(others, np.array(rows).T, strict=True))
    return np.array([found[name] for name in plan.solved])


def _rest(plan: StudyPlan, case: int, names: Sequence[str], handoff: float) -> list[float]:
    """Figures of one scene that the kernels do not compute, in natural units.

    `handoff` is its terminal speed, NaN where there is none.
    """
    from escapement.engines.energy.simulate import simulate

    escapement = plan.escapement(case).held
    clock, torque = escapement.time_unit, escapement.torque_unit
    figures = Figures() if {*names}.isdisjoint(_LIMITS) else simulation.limits(escapement)
    if handoff > 0.0 and not {*names} <= {*_LIMITS}:
        settings: Any = {"initial_speed": handoff / clock, "rtol": plan.solver.tolerance}
        count = len(escapement.scenes)
        cycle = simulate(escapement, engagements=count, duration=None, **settings)
        figures = replace(figures, motion=cycle)
    units = (si_unit(name, clock, torque, full_torque(escapement)) for name in names)
    return [getattr(figures, name) / unit for name, unit in zip(names, units, strict=True)]


def si_unit(name: str, clock: Any, torque: Any, motor_torque: Any) -> Any:
    """Natural unit of a figure [SI]; no case of the study changes the length in it.

    clock, torque, motor_torque : units of time and torque, and the torque of a motor at rest, of
        which its other torques are shares in all cases of one scene.
    """
    kind = FIGURES[name].kind if name in FIGURES else ""
    if name.startswith("motor_torque"):
        return motor_torque
    match kind:
        case "speed" | "frequency":
            return 1.0 / clock
        case "time":
            return clock
        case "acceleration":
            return clock**-2.0
        case "power":
            return torque / clock
        case "torque" | "force" | "energy":
            return torque
    return 1.0


def cost_note(plan: StudyPlan) -> str:
    """Which results make a study long, since they are computed case by case; "" if none does."""
    from escapement.engines.energy.cycle import COLUMNS

    fast = {*COLUMNS, *_FORMULAS, *(PEAKS if plan.perfect else ())}
    slow = [name for name in plan.solved if name not in fast]
    each = _ALONE
    if RUN_TIME in slow:
        slow, each = [RUN_TIME], _RUNDOWN
    elif plan.solver.engine == "ivp":
        slow, each = [_ALL], _INTEGRATED
    elif plan.solver.engine == "energy" and not together(plan):
        slow, each = [_ALL], _APART
    minutes = plan.cases * each / 60.0
    if not slow or plan.subject is not ESCAPEMENT or minutes < 1.0:
        return ""
    names, verb = ", ".join(slow), "are" if len(slow) > 1 or slow == [_ALL] else "is"
    return (
        f"{names} {verb} computed case by case, about {1e3 * each:g} ms for each: some "
        f"{minutes:.0f} minutes on one processor"
    )


def together(plan: StudyPlan) -> bool:
    """Whether many cases are solved at once; otherwise one by one."""
    apart = RUN_TIME in plan.results or plan.fixed_si.get("load_curve") is not None
    apart |= plan.curve is not None and (plan.has_cycle or bool(plan.curve.speed))
    if plan.subject is not ESCAPEMENT or apart:
        return False
    if plan.solver.engine != "energy" or plan.perfect:
        return plan.solver.engine == "energy"
    varied = {name for along in plan.varied.values() for name in along}
    varied &= {name for name in plan.parameters if plan.parameters[name].section == "mechanism"}
    alike = all(name.startswith((*IMPERFECT, *LENGTHS)) for name in varied)
    return alike and isinstance(plan.build, type)
