"""`design`: the escapements that satisfy a requirement best."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from escapement.base.errors import InvalidValue
from escapement.base.progress import set_stage
from escapement.base.spoken import as_spoken
from escapement.base.text import Shown
from escapement.engines.run_down import rundown
from escapement.inverse_design.front import spread_out, undominated
from escapement.inverse_design.requirement import BOUNDS, Requirement
from escapement.inverse_design.similarity import UnitWheel, Values, wheels_for
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray, Mechanism
from escapement.model.escapement import Escapement, Inertia

SAMPLE = 11
"""Two to this power is the number of points that are tried for each wheel."""
_MARGIN = 3e-3
"""Relative margin to the bounds before a design is computed exactly."""
_STEPS = 150
"""Number of steps that improve one design."""
FOIL = 1e-4
"""Discs and walls that are thinner than this cannot be cut [m]."""
_VARIED = ("inertia_ratio", "crank_radius", "torque")
_THICK = ("driver_thickness", "follower_thickness")
_OF_INERTIA = ("driver_inertia", "follower_inertia", "mass", *_THICK)
"""Figures that are proportional to the inertias."""


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

    Every wheel that the requirement allows is evaluated at a Sobol' sequence of inertia ratios,
    crank radii and torques. The points that satisfy the bounds and are not dominated are improved
    and then simulated. The follower's inertia follows from the period, by similarity.

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

    Validity: escapements without a load, with pins of the requirement's width and without
    losses other than friction in the slots.
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
    values = {name: np.concatenate([table[name] for table in tables]) for name in BOUNDS}
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


def _ends(requirement: Requirement) -> FloatArray:
    """Logarithms of the ends of the ranges, shape (3, 2)."""
    return np.log([getattr(requirement, name) for name in _VARIED])


def _points(requirement: Requirement, seed: int) -> FloatArray:
    """Points to try: logarithms of the varied numbers."""
    low, high = _ends(requirement).T
    shares = qmc.Sobol(len(_VARIED), seed=seed).random_base2(SAMPLE)
    points: FloatArray = low + shares * (high - low)
    return points


def _values(wheel: UnitWheel, points: FloatArray) -> Values:
    """Figures in SI at points of a wheel, interpolated; NaN beyond the ratios at which it moves."""
    assert wheel.curves is not None
    table = wheel.curves(points[:, 0], extrapolate=False)
    ratio, radius, torque = np.exp(points.T)
    return wheel.in_si(table, (ratio, radius, torque))


def misses(values: Values, requirement: Requirement, margin: float = 0.0) -> FloatArray:
    """By how much each bound is missed, as a logarithm, infinite if there is no figure."""
    rows = []
    for name, (low, high) in requirement.bounds.items():
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
    missed, names = misses(values, requirement), list(requirement.bounds)

    def told(i: int, case: int) -> str:
        return _bound_text(names[i], requirement.bounds[names[i]], float(values[names[i]][case]))

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
    kind, (low, high) = BOUNDS[name].unit, bound
    rule, limit = ("at most", high) if reached > high else ("at least", low)
    best = "least" if reached > high else "greatest"
    return (
        f"{name} must be {rule} {as_spoken(limit, kind)}, and the {best} is "
        f"{as_spoken(reached, kind)}"
    )


def _polished(wheel: UnitWheel, point: FloatArray) -> FloatArray:
    """A nearby point that is better in every objective, within all bounds."""
    requirement = wheel.requirement
    low, high = _ends(requirement).T
    free = high > low
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
        gained = costs(np.clip(x, low[free], high[free])) - start
        value = float(gained.max() + 0.01 * gained.sum())
        return value if math.isfinite(value) else 1e6

    limits = list(zip(low[free], high[free], strict=True))
    options = {"maxfev": _STEPS, "xatol": 1e-4, "fatol": 1e-6}
    found = minimize(worst, point[free], method="Nelder-Mead", bounds=limits, options=options)
    better = point.copy()
    if found.fun < 0.0:
        better[free] = np.clip(found.x, low[free], high[free])
    return better


def _made(wheel: UnitWheel, point: FloatArray) -> Design | None:
    """The design at a point, simulated; None where it misses a bound after all."""
    requirement, (ratio, radius, torque) = wheel.requirement, np.exp(point).tolist()
    found = wheel.in_si(wheel.exact([ratio])[0], (ratio, radius, torque))
    turns, total = requirement.turns, requirement.total_time
    timer = Escapement(
        Geneva(
            wheel.slots, internal=wheel.internal, crank_radius=radius,
            pin_radius=requirement.pin * radius,
        ),
        Inertia(found["driver_inertia"], found["follower_inertia"]),
        torque=torque,
        friction=0.5 * sum(requirement.friction),
        spring_rate=requirement.torque_lost * torque / (2.0 * math.pi * turns) if turns else 0.0,
    )  # fmt: skip
    if turns is not None and total is not None:
        try:
            share = (total / rundown(timer, turns=turns).time_of(turns)) ** 2
        except InvalidValue:
            return None  # it stops on the way
        found["rise_time_98"] *= math.sqrt(share)
        found |= {name: found[name] * share for name in _OF_INERTIA}
        # a thicker disc has longer pins
        found["pressure_max"] /= math.sqrt(share)
        inertia = Inertia(found["driver_inertia"], found["follower_inertia"])
        timer = replace(timer, inertia=inertia)
    values = {name: float(x) for name, x in found.items()}
    missed = misses({name: np.array([x]) for name, x in values.items()}, requirement)
    return Design(timer, values) if missed.max(initial=0.0) == 0.0 else None
