"""The figures of a kind of wheel over the ratio of its inertias, in natural units and in SI.

Period, force, size and mass of an escapement without a load follow from those of one with the
follower inertia, the torque and the crank radius 1, by similarity: the period is proportional
to the root of inertia over torque, the force to torque over radius. So these three numbers need
no search.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.engines import simulate as simulation
from escapement.inverse_design.requirement import Requirement
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement, Inertia
from escapement.outlines.parts import parts_of
from escapement.study.running import sweep

RATIOS = 24
"""Ratios of the inertias at which the figures are computed."""
_SAMPLED = ("period", "contact_force_max", "rise_time_98", "critical_friction")
NATURAL = ("period", "scatter", "force", "rise", "jam_margin")
"""Figures of a wheel in natural units for one ratio of the inertias."""
Values = dict[str, Any]


@dataclass(frozen=True)
class Discs:
    """The discs of a wheel of crank radius 1.

    size : length over both discs. wall : their thinnest wall. driver, follower : area and polar
    second moment of each disc.
    """

    size: float
    wall: float
    driver: tuple[float, float]
    follower: tuple[float, float]


def body_of(wheel: Geneva) -> Discs:
    """The body of a wheel of crank radius 1; raises InvalidValue where a hole leaves no wall."""
    parts = {part.name: part for part in parts_of(wheel)}
    moments = {name: part.moments for name, part in parts.items()}
    discs = [moments[name] for name in ("driver", "locking-disc") if name in moments]
    # corners of the follower lie farthest out; of the driver it is a circle
    out = {name: float(np.abs(parts[name].edge.corners).max()) for name in ("driver", "follower")}
    apart = wheel.centre_distance
    size = max(out["driver"] + apart, out["follower"]) + max(out["follower"], out["driver"] - apart)
    wall = min(part.wall.width for name, part in parts.items() if name != "plate")
    driver = sum(m.area for m in discs), sum(m.second for m in discs)
    return Discs(size, wall, driver, (moments["follower"].area, moments["follower"].second))


@dataclass(frozen=True)
class UnitWheel:
    """A kind of wheel: its figures in natural units as functions of the logarithm of the ratio."""

    slots: int
    internal: bool
    body: Discs
    curves: PchipInterpolator

    def at(self, ratio: Any) -> Values:
        """Figures at ratios of the inertias, by the names in `NATURAL`; NaN outside those known."""
        table = self.curves(np.log(ratio), extrapolate=False)
        found = dict(zip(NATURAL, np.moveaxis(table, -1, 0), strict=True))
        return found | {name: np.exp(found[name]) for name in NATURAL[:4]}


def wheels_for(requirement: Requirement) -> list[UnitWheel]:
    """The wheels that a requirement allows and that move at all of its frictions."""
    found = []
    kinds = (False, True) if requirement.internal is None else (requirement.internal,)
    low, high = map(int, requirement.slots)
    ratios = np.geomspace(requirement.inertia_ratio[0], requirement.inertia_ratio[1], RATIOS)
    if requirement.inertia_ratio[0] == requirement.inertia_ratio[1]:
        ratios = ratios[0] * np.array([1.0, 1.0 + 1e-9])
    for slots in range(low, high + 1):
        for internal in kinds:
            try:
                wheel = unit_wheel(slots, internal, requirement.pin)
                wanted = body_of(wheel)
            except InvalidValue:
                continue  # pins too thick for so many slots
            table = natural_figures(wheel, ratios, requirement)
            good = np.isfinite(table).all(axis=1)
            if good.sum() > 1:
                curves = PchipInterpolator(np.log(ratios[good]), table[good])
                found.append(UnitWheel(slots, internal, wanted, curves))
    return found


def unit_wheel(slots: int, internal: bool, pin: float) -> Geneva:
    """A wheel of crank radius 1."""
    return Geneva(slots, internal=internal, crank_radius=1.0, pin_radius=pin)


def frictions(requirement: Requirement) -> FloatArray:
    """The least, middle and greatest friction."""
    low, high = requirement.friction
    return np.array([low, 0.5 * (low + high), high])


def natural_figures(wheel: Geneva, ratios: FloatArray, requirement: Requirement) -> FloatArray:
    """A row of `NATURAL` for each ratio, logarithms except for the jam margin."""
    timer = Escapement(wheel, Inertia(1.0, 1.0), torque=1.0)
    three = frictions(requirement)
    study = sweep(timer, driver_inertia=ratios, friction=three, results=_SAMPLED)
    shape = ratios.size, 3
    columns = {name: np.asarray(study.results[name]).reshape(shape) for name in _SAMPLED}
    moves = np.asarray(study.results["status"]).reshape(shape) == Status.OK
    return _natural({name: np.where(moves, x, np.nan) for name, x in columns.items()}, three)


def _natural(columns: dict[str, FloatArray], three: FloatArray) -> FloatArray:
    """Rows of `NATURAL` from figures at three frictions, shape (n, 3)."""
    period = columns["period"]
    scatter = 0.5 * np.ptp(period, axis=1) / period[:, 1]
    with np.errstate(divide="ignore"):
        positive = (
            period[:, 1],
            np.maximum(scatter, 1e-12),
            columns["contact_force_max"].max(axis=1),
            columns["rise_time_98"][:, 1],
        )
        rows = [np.log(x) for x in positive]
    margin = 1.0 - three[2] / columns["critical_friction"].min(axis=1)
    return np.column_stack([*rows, margin])


def exact(wheel: Geneva, ratio: float, requirement: Requirement) -> Values:
    """Figures of a wheel of crank radius 1, each friction being simulated; NaN where it jams."""
    three, table = frictions(requirement), []
    for friction in three:
        timer = Escapement(wheel, Inertia(ratio, 1.0), torque=1.0, friction=friction)
        table.append([getattr(simulation.terminal(timer), name) for name in _SAMPLED])
    columns = {name: row[None] for name, row in zip(_SAMPLED, np.transpose(table), strict=True)}
    found = dict(zip(NATURAL, _natural(columns, three)[0].tolist(), strict=True))
    return found | {name: math.exp(found[name]) for name in NATURAL[:4]}


def in_si(
    natural: Values,
    body: Discs,
    slots: Any,
    internal: bool,
    requirement: Requirement,
    point: tuple[Any, Any, Any],
) -> Values:  # fmt: skip
    """Figures in SI of wheels at (inertia ratio, crank radius, torque), numbers or arrays."""
    ratio, radius, torque = point
    follower = torque * (period_of(requirement, slots, internal) / natural["period"]) ** 2
    driver, scale = ratio * follower, radius**4 * requirement.density
    masses = (i * a / j for i, (a, j) in ((driver, body.driver), (follower, body.follower)))
    return {
        "scatter": natural["scatter"],
        "contact_force_max": natural["force"] * torque / radius,
        "size": body.size * radius,
        "mass": sum(masses) / radius**2,
        "rise_time_98": natural["rise"] * np.sqrt(follower / torque),
        "driver_inertia": driver,
        "follower_inertia": follower,
        "driver_thickness": driver / (body.driver[1] * scale),
        "follower_thickness": follower / (body.follower[1] * scale),
        "thinnest_wall": body.wall * radius,
        "jam_margin": natural["jam_margin"] + 0.0 * radius,
    }


def period_of(requirement: Requirement, slots: int, internal: bool) -> float:
    """Period of an engagement at the torque of the start that a requirement needs [s].

    Over a run the period is inversely proportional to the root of the torque, which falls linearly.
    The additional time of a start from rest is corrected when a design is simulated.
    """
    if requirement.period is not None:
        return requirement.period
    assert requirement.turns is not None
    assert requirement.total_time is not None
    cell = Geneva(slots, internal=internal).cell_angle
    lost = requirement.torque_lost
    slower = 2.0 * (1.0 - math.sqrt(1.0 - lost)) / lost if lost else 1.0
    return requirement.total_time / (requirement.turns * 2.0 * math.pi / cell) / slower
