"""`design`: the escapements that satisfy a wish best."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from escapement.base.errors import InvalidValue
from escapement.base.progress import set_stage
from escapement.base.spoken import told
from escapement.base.text import Shown
from escapement.engines.run_down import rundown
from escapement.inverse_design.front import spread_out, undominated
from escapement.inverse_design.similarity import (
    UnitWheel,
    Values,
    exact,
    in_si,
    unit_wheel,
    wheels_for,
)
from escapement.inverse_design.wish import BOUNDS, Wish
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray
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


@dataclass(frozen=True, repr=False)
class Design(Shown):
    """A timer that satisfies a wish.

    timer : the escapement, at the middle of the friction and with pins.
    values : its figures in SI, by the names of `wish.BOUNDS`.
    """

    timer: Escapement
    values: dict[str, float]

    @property
    def can_be_cut(self) -> bool:
        """Whether its discs and their walls are thicker than foil, `FOIL`."""
        thick = "driver_thickness", "follower_thickness", "thinnest_wall"
        return min(self.values[name] for name in thick) >= FOIL


@dataclass(frozen=True, repr=False)
class Designs(Shown):
    """Result of `design`.

    wish : the given wish.
    designs : the Pareto front: no design is better than another in all objectives. They are in
        the order of the first objective.
    tried : number of points that were evaluated.
    message : the reason if there is no design.
    """

    wish: Wish
    designs: tuple[Design, ...]
    tried: int
    message: str


def design(wish: Wish, *, count: int = 40, seed: int = 0) -> Designs:
    """Find the timers that satisfy a wish, none of them better in everything than another.

    Every wheel that the wish allows is evaluated at a Sobol' sequence of inertia ratios, crank
    radii and torques. The points that satisfy the bounds and are not dominated are improved and
    then simulated. The follower's inertia follows from the period, by similarity.

    Parameters
    ----------
    wish : Wish
    count : int
        Greatest number of designs, which then lie far apart.
    seed : int
        Seed of the sequence.

    Returns
    -------
    Designs
        If no design satisfies all bounds, its message names the bound that prevents it, and by
        how much.

    Validity: escapements without a load, with pins of the wish's width and without
    losses other than friction in the slots.
    """
    wheels = wheels_for(wish)
    if not wheels:
        reason = f"no wheel with these slots moves at a friction of {wish.friction[1]:g}"
        remedy = "all jam, or their pins do not fit; allow less friction or other slots"
        return Designs(wish, (), 0, f"{reason}: {remedy}")
    tables = []
    for number, wheel in enumerate(wheels, 1):
        set_stage(f"wheel {number} of {len(wheels)}")
        tables.append(_sampled(wheel, wish, seed))
    owner = np.repeat(np.arange(len(wheels)), [len(places) for places, _ in tables])
    places = np.concatenate([places for places, _ in tables])
    values = {name: np.concatenate([table[name] for _, table in tables]) for name in BOUNDS}
    good = np.flatnonzero(misses(values, wish, _MARGIN).sum(axis=0) == 0.0)
    if not good.size:
        return Designs(wish, (), len(places), _reason(values, wish))
    costs = np.log(np.column_stack([values[name][good] for name in wish.objectives]))
    front = undominated(costs)
    front = front[spread_out(costs[front], count)]
    found = []
    for number, i in enumerate(good[front], 1):
        set_stage(f"improving design {number} of {front.size}")
        found.append(_polished(wheels[owner[i]], places[i], wish))
    made = [made for wheel, place in found if (made := _made(wheel, place, wish))]
    if not made:
        reason = "designs that seemed to satisfy the bounds do not satisfy them exactly"
        return Designs(wish, (), len(places), reason)
    costs = np.array([[one.values[name] for name in wish.objectives] for one in made])
    best = sorted((made[i] for i in undominated(costs)), key=lambda d: d.values[wish.objectives[0]])
    return Designs(wish, tuple(best), len(places), "done")


def _ends(wish: Wish) -> FloatArray:
    """Logarithms of the ends of the ranges, shape (3, 2)."""
    return np.log([getattr(wish, name) for name in _VARIED])


def _sampled(wheel: UnitWheel, wish: Wish, seed: int) -> tuple[FloatArray, Values]:
    """Points of a wheel, logarithms of the varied numbers, and the figures there."""
    shares = qmc.Sobol(len(_VARIED), seed=seed).random_base2(SAMPLE)
    low, high = _ends(wish).T
    places = low + shares * (high - low)
    return places, _values(wheel, places, wish)


def _values(wheel: UnitWheel, places: FloatArray, wish: Wish) -> Values:
    """Figures in SI at points of a wheel."""
    ratio, radius, torque = np.exp(places.T)
    return in_si(
        wheel.at(ratio), wheel.body, wheel.slots, wheel.internal, wish, (ratio, radius, torque)
    )


def misses(values: Values, wish: Wish, margin: float = 0.0) -> FloatArray:
    """By how much each bound is missed, as a logarithm, infinite if there is no figure."""
    rows = []
    for name, (low, high) in wish.bounds.items():
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


def _reason(values: Values, wish: Wish) -> str:
    """The bound that prevents a wish, and by how much."""
    missed = misses(values, wish)
    names = list(wish.bounds)
    alone = []
    for i, name in enumerate(names):
        others = np.delete(missed, i, axis=0).sum(axis=0) == 0.0
        if others.any():
            k = int(np.where(others, missed[i], math.inf).argmin())
            alone.append((missed[i, k], _told(name, wish.bounds[name], float(values[name][k]))))
    if alone:
        return f"{min(alone)[1]}, if all other bounds are satisfied"
    k = int(missed.sum(axis=0).argmin())
    several = [
        _told(name, wish.bounds[name], float(values[name][k]))
        for i, name in enumerate(names)
        if missed[i, k] > 0.0
    ]
    return "; ".join([*several, "no single bound prevents a design: relax several of them"])


def _told(name: str, bound: tuple[float, float], reached: float) -> str:
    """A bound that is missed, and the value that the nearest design reaches."""
    kind, (low, high) = BOUNDS[name].unit, bound
    rule, limit = ("at most", high) if reached > high else ("at least", low)
    best = "least" if reached > high else "greatest"
    return f"{name} must be {rule} {told(limit, kind)}, and the {best} is {told(reached, kind)}"


def _polished(wheel: UnitWheel, place: FloatArray, wish: Wish) -> tuple[UnitWheel, FloatArray]:
    """A nearby point that is better in every objective, within all bounds."""
    low, high = _ends(wish).T
    free = high > low
    if not free.any():
        return wheel, place

    def costs(x: FloatArray) -> FloatArray:
        whole = place.copy()
        whole[free] = x
        found = _values(wheel, whole[None], wish)
        penalty = 1e3 * float(misses(found, wish, _MARGIN).sum())
        return np.log([float(found[name][0]) for name in wish.objectives]) + penalty

    start = costs(place[free])

    def worst(x: FloatArray) -> float:
        gained = costs(np.clip(x, low[free], high[free])) - start
        value = float(gained.max() + 0.01 * gained.sum())
        return value if math.isfinite(value) else 1e6

    limits = list(zip(low[free], high[free], strict=True))
    options = {"maxfev": _STEPS, "xatol": 1e-4, "fatol": 1e-6}
    found = minimize(worst, place[free], method="Nelder-Mead", bounds=limits, options=options)
    better = place.copy()
    if found.fun < 0.0:
        better[free] = np.clip(found.x, low[free], high[free])
    return wheel, better


def _made(wheel: UnitWheel, place: FloatArray, wish: Wish) -> Design | None:
    """The design at a place, simulated; None where it misses a bound after all."""
    ratio, radius, torque = np.exp(place).tolist()
    natural = exact(unit_wheel(wheel.slots, wheel.internal, wish.pin), ratio, wish)
    found = in_si(natural, wheel.body, wheel.slots, wheel.internal, wish, (ratio, radius, torque))
    inertia, turned = found["follower_inertia"], 2.0 * math.pi * (wish.turns or 0.0)
    timer = _timer(wheel, wish, (ratio, radius, torque), float(inertia), turned)
    if wish.total_time is not None and wish.turns is not None:
        run = rundown(timer, turns=wish.turns)
        try:
            share = (wish.total_time / run.time_of(wish.turns)) ** 2
        except InvalidValue:
            return None  # it stops on the way
        timer = _timer(wheel, wish, (ratio, radius, torque), float(inertia) * share, turned)
        lasting = ("driver_inertia", "follower_inertia", "mass", "driver_thickness",
                   "follower_thickness")  # fmt: skip
        found |= {name: found[name] * share for name in lasting}
        found["rise_time_98"] *= math.sqrt(share)
    values = {name: float(x) for name, x in found.items()}
    missed = misses({name: np.array([x]) for name, x in values.items()}, wish)
    return Design(timer, values) if missed.max(initial=0.0) == 0.0 else None


def _timer(
    wheel: UnitWheel, wish: Wish, place: tuple[float, float, float], inertia: float, turned: float
) -> Escapement:
    ratio, radius, torque = place
    mechanism = Geneva(
        wheel.slots, internal=wheel.internal, crank_radius=radius, pin_radius=wish.pin * radius
    )
    return Escapement(
        mechanism,
        Inertia(ratio * inertia, inertia),
        torque=torque,
        friction=0.5 * sum(wish.friction),
        spring_rate=wish.torque_lost * torque / turned if turned else 0.0,
    )
