"""`design`: the escapements that satisfy a requirement best."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from escapement.base.errors import InvalidValue
from escapement.base.progress import set_stage
from escapement.base.spoken import as_spoken
from escapement.base.text import Shown
from escapement.engines.run_down import rundown
from escapement.inverse_design.front import spread_out, undominated
from escapement.inverse_design.requirement import BOUNDS, RANGES, Requirement
from escapement.inverse_design.similarity import UnitWheel, Values, wheels_for
from escapement.mechanisms.protocol import FloatArray, Mechanism
from escapement.model.escapement import Escapement

SAMPLE = 11
"""Two to this power is the number of points that are tried for each wheel."""
_MARGIN = 3e-3
"""Relative margin to the bounds before a design is computed exactly."""
_STEPS, _FIRST_STEP = 150, 0.1
"""Number of steps that improve one design, and the first of them as share of a range."""
FOIL = 1e-4
"""Discs and walls that are thinner than this cannot be cut [m]."""
_SLOW, _SLOW_STEPS = 7, 40
"""The same as `SAMPLE` and `_STEPS` for designs with losses, which are not interpolated."""
_CORRECTIONS, _ON_TIME = 8, 1e-11
"""Greatest number of corrections of a whole run, and the relative error that needs none."""
_THICK = ("driver_thickness", "follower_thickness")


@dataclass(frozen=True, repr=False)
class Design(Shown):
    """A timer that satisfies a requirement.

    timer : the escapement, at the middle of the friction and with pins.
    values : its figures in SI, by the names of `requirement.BOUNDS`.
    """

    timer: Escapement
    values: dict[str, float]

    @property
    def mechanism(self) -> Mechanism:
        """Its wheel."""
        return self.timer.mechanism

    @property
    def can_be_cut(self) -> bool:
        """Whether its discs and their walls are thicker than foil, `FOIL`."""
        return min(self.values[name] for name in (*_THICK, "thinnest_wall")) >= FOIL


@dataclass(frozen=True, repr=False)
class Designs(Shown):
    """Result of `design`.

    requirement : the given requirement.
    designs : the Pareto front: no design is better than another in all objectives. They are in
        the order of the first objective.
    tried : number of points that were evaluated.
    message : the reason if there is no design.
    """

    requirement: Requirement
    designs: tuple[Design, ...]
    tried: int
    message: str

    @property
    def wish(self) -> Requirement:
        """The former name of `requirement`, which goes with the next release."""
        text = "Designs.wish is called Designs.requirement; use this name"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        return self.requirement


def design(requirement: Requirement, *, count: int = 40, seed: int = 0) -> Designs:
    """Find the timers that satisfy a requirement, none of them better in everything than another.

    Every wheel that the requirement allows is evaluated at a Sobol' sequence of the numbers that
    are searched. The points that satisfy the bounds and are not dominated are improved and then
    simulated. The follower's inertia, or else torque or crank radius, follows from the period.

    Parameters
    ----------
    requirement : Requirement
    count : int
        Greatest number of designs, which then lie far apart.
    seed : int
        Seed of the sequence.

    Returns
    -------
    Designs
        If no design satisfies all bounds, its message names the bound that prevents it, and by
        how much.

    Validity: escapements without a load, with pins of the requirement's width.
    """
    wheels = wheels_for(requirement)
    if not wheels:
        reason = f"no wheel with these slots moves at a friction of {requirement.friction[1]:g}"
        remedy = "all jam, or their pins do not fit; allow less friction or other slots"
        return Designs(requirement, (), 0, f"{reason}: {remedy}")
    # the points are the same for each wheel
    points = _points(requirement, seed)
    tables = [_values(wheel, points) for wheel in wheels]
    tried = len(points) * len(wheels)
    names = {**BOUNDS, **requirement.limits}
    values = {name: np.concatenate([table[name] for table in tables]) for name in names}
    good = np.flatnonzero(misses(values, requirement, _MARGIN).sum(axis=0) == 0.0)
    if not good.size:
        return Designs(requirement, (), tried, _reason(values, requirement))
    costs = np.log(np.column_stack([values[name][good] for name in requirement.objectives]))
    front = undominated(costs)
    front = front[spread_out(costs[front], count)]
    found = []
    for number, case in enumerate(good[front].tolist(), 1):
        set_stage(f"improving design {number} of {front.size}")
        wheel, point = wheels[case // len(points)], points[case % len(points)]
        found.append(_made(wheel, _polished(wheel, point)))
    made = [one for one in found if one is not None]
    if not made:
        reason = "designs that seemed to satisfy the bounds do not satisfy them exactly"
        return Designs(requirement, (), tried, reason)
    costs = np.array([[one.values[name] for name in requirement.objectives] for one in made])
    best = [made[i] for i in sorted(undominated(costs), key=costs[:, 0].__getitem__)]
    return Designs(requirement, tuple(best), tried, "done")


def _points(requirement: Requirement, seed: int) -> FloatArray:
    """Points to try: shares of the ranges and lists that are searched."""
    size = min(SAMPLE, _SLOW) if requirement.losses else SAMPLE
    points: FloatArray = qmc.Sobol(len(requirement.searched), seed=seed).random_base2(size)
    return points


def _chosen(requirement: Requirement, points: FloatArray) -> Values:
    """The numbers at points."""
    found = {}
    for (name, values), share in zip(requirement.searched.items(), points.T, strict=True):
        low, high = values[0], values[-1]
        if len(values) > 2:
            found[name] = np.array(values)[
                np.minimum(share * len(values), len(values) - 1).astype(int)
            ]
        elif low > 0.0:
            found[name] = low * (high / low) ** share
        else:
            found[name] = share * high
    return found


def _values(wheel: UnitWheel, points: FloatArray) -> Values:
    """Figures in SI at points of a wheel; NaN where it does not move."""
    count = len(points)
    found = wheel.values(_chosen(wheel.requirement, points))
    return {name: np.broadcast_to(x, count) for name, x in found.items()}


def misses(values: Values, requirement: Requirement, margin: float = 0.0) -> FloatArray:
    """By how much each bound is missed, as a logarithm, infinite if there is no figure."""
    rows = []
    for name, (low, high) in requirement.limits.items():
        x = np.asarray(values[name], dtype=float)
        if name == "jam_margin":
            rows.append(np.maximum(0.0, np.maximum(low - x, x - high) + margin))
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            below = np.log(low) - np.log(x) if low > 0.0 else np.full_like(x, -math.inf)
            rows.append(np.maximum(0.0, np.maximum(below, np.log(x) - np.log(high)) + margin))
    rows.append(np.where(np.isfinite(values["contact_force_max"]), 0.0, math.inf))
    found = np.array(rows)
    return np.where(np.isnan(found), math.inf, found)


def _reason(values: Values, requirement: Requirement) -> str:
    """The bound that prevents a requirement, and by how much."""
    missed, limits = misses(values, requirement), [*requirement.limits.items()]

    def told(i: int, case: int) -> str:
        return _bound_text(*limits[i], float(values[limits[i][0]][case]))

    is_missed = missed > 0.0
    # of each bound how far it is missed where it is the only one
    alone = np.where(is_missed.sum(axis=0) == is_missed, missed, math.inf)[:-1]
    least = alone.min(axis=1)
    if np.isfinite(least).any():
        i = int(least.argmin())
        return f"{told(i, int(alone[i].argmin()))}, if all other bounds are satisfied"
    nearest = int(missed.sum(axis=0).argmin())
    several = [told(i, nearest) for i in np.flatnonzero(is_missed[:-1, nearest]).tolist()]
    return "; ".join([*several, "no single bound prevents a design: relax several of them"])


def _bound_text(name: str, bound: tuple[float, float], reached: float) -> str:
    """A bound that is missed, and the value that the nearest design reaches."""
    kind, (low, high) = (BOUNDS | RANGES)[name].unit, bound
    rule, limit = ("at most", high) if reached > high else ("at least", low)
    best = "least" if reached > high else "greatest"
    return (
        f"{name} must be {rule} {as_spoken(limit, kind)}, and the {best} is "
        f"{as_spoken(reached, kind)}"
    )


def _polished(wheel: UnitWheel, point: FloatArray) -> FloatArray:
    """A nearby point that is better in every objective, within all bounds."""
    requirement = wheel.requirement
    free = np.array([len(x) == 2 and x[0] < x[1] for x in requirement.searched.values()])
    if not free.any():
        return point

    def costs(x: FloatArray) -> FloatArray:
        whole = point.copy()
        whole[free] = x
        found = _values(wheel, whole[None])
        penalty = 1e3 * float(misses(found, requirement, _MARGIN).sum())
        return np.log([float(found[name][0]) for name in requirement.objectives]) + penalty

    start = costs(point[free])

    def worst(x: FloatArray) -> float:
        gained = costs(np.clip(x, 0.0, 1.0)) - start
        value = float(gained.max() + 0.01 * gained.sum())
        return value if math.isfinite(value) else 1e6

    first, size = point[free], int(free.sum())
    inwards = np.where(first < 0.5, _FIRST_STEP, -_FIRST_STEP)
    options = {
        "maxfev": min(_STEPS, _SLOW_STEPS) if requirement.losses else _STEPS,
        "xatol": 1e-5, "fatol": 1e-6,
        "initial_simplex": np.vstack([first, first + np.diag(inwards)]),
    }  # fmt: skip
    found = minimize(
        worst, first, method="Nelder-Mead", bounds=[(0.0, 1.0)] * size, options=options
    )
    better = point.copy()
    if found.fun < 0.0:
        better[free] = np.clip(found.x, 0.0, 1.0)
    return better


def _made(wheel: UnitWheel, point: FloatArray) -> Design | None:
    """The design at a point, simulated; None where it misses a bound after all."""
    requirement, chosen, slower = wheel.requirement, _chosen(wheel.requirement, point[None]), 1.0
    for _ in range(_CORRECTIONS):
        found = wheel.values(chosen, exact=True, slower=slower)
        numbers = {name: np.asarray(x).item() for name, x in found.items()}
        if not math.isfinite(numbers["scatter"]):
            return None
        timer = wheel.timer(numbers)
        if requirement.turns is None or requirement.total_time is None:
            break
        try:
            run = rundown(timer, turns=requirement.turns).time_of(requirement.turns)
        except InvalidValue:
            return None  # it stops on the way
        share = requirement.total_time / run
        if abs(share - 1.0) < _ON_TIME:
            break
        slower *= share
    missed = misses({name: np.array([x]) for name, x in numbers.items()}, requirement)
    values = {name: numbers[name] for name in BOUNDS}
    return Design(timer, values) if missed.max(initial=0.0) == 0.0 else None
