"""The figures of a kind of wheel over the ratio of its inertias, in natural units and in SI.

Period, force, size and mass of an escapement without a load follow from those of one with the
follower inertia, the torque and the crank radius 1, by similarity: the period is proportional
to the root of inertia over torque, the force to torque over radius. So these three numbers need
no search.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from escapement.base.errors import InvalidValue
from escapement.base.progress import set_stage
from escapement.base.status import Status
from escapement.inverse_design.requirement import Requirement
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement, Inertia
from escapement.model.materials import contact_modulus, hertz_pressure, material
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


def discs_of(wheel: Geneva) -> Discs:
    """The discs of a wheel of crank radius 1; raises InvalidValue where a hole leaves no wall."""
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
    """A wheel of crank radius 1 with so many slots, as a requirement asks for it."""

    requirement: Requirement
    slots: int
    internal: bool

    @cached_property
    def wheel(self) -> Geneva:
        """The wheel; raises InvalidValue where its pins are too thick."""
        pin = self.requirement.pin
        return Geneva(self.slots, internal=self.internal, crank_radius=1.0, pin_radius=pin)

    @cached_property
    def discs(self) -> Discs:
        """Its discs; errors as `discs_of`."""
        return discs_of(self.wheel)

    @cached_property
    def curves(self) -> PchipInterpolator | None:
        """A row of `NATURAL` over the logarithm of the ratio; None if it hardly moves anywhere."""
        low, high = self.requirement.inertia_ratio
        ratios = (
            np.geomspace(low, high, RATIOS) if low < high else low * np.array([1.0, 1.0 + 1e-9])
        )
        table = self.exact(ratios)
        good = np.isfinite(table).all(axis=1)
        return PchipInterpolator(np.log(ratios[good]), table[good]) if good.sum() > 1 else None

    def exact(self, ratios: Any) -> FloatArray:
        """A row of `NATURAL` for each ratio, logarithms except for the jam margin; NaN where it
        does not move at the least, the middle and the greatest friction.
        """
        low, high = self.requirement.friction
        three = np.array([low, 0.5 * (low + high), high])
        timer = Escapement(self.wheel, Inertia(1.0, 1.0), torque=1.0)
        study = sweep(timer, driver_inertia=ratios, friction=three, results=_SAMPLED)
        shape = np.size(ratios), 3
        moves = np.asarray(study.results["status"]).reshape(shape) == Status.OK
        period, force, rise, limit = (
            np.where(moves, np.asarray(study.results[name]).reshape(shape), np.nan)
            for name in _SAMPLED
        )
        scatter = np.maximum(0.5 * np.ptp(period, axis=1) / period[:, 1], 1e-12)
        positive = period[:, 1], scatter, force.max(axis=1), rise[:, 1]
        with np.errstate(divide="ignore"):
            return np.column_stack([*map(np.log, positive), 1.0 - high / limit.min(axis=1)])

    def in_si(self, table: FloatArray, point: tuple[Any, Any, Any]) -> Values:
        """Figures in SI from rows of `NATURAL`, at (inertia ratio, crank radius, torque)."""
        ratio, radius, torque = point
        period, scatter, force, rise = np.exp(table.T[:4])
        density, discs = self.requirement.density, self.discs
        follower = torque * (self.period / period) ** 2
        driver, scale = ratio * follower, radius**4 * density
        masses = (i * a / j for i, (a, j) in ((driver, discs.driver), (follower, discs.follower)))
        thick = follower / (discs.follower[1] * scale)
        given = self.requirement
        modulus = contact_modulus(material(given.pin_material), material(given.wheel_material))
        greatest, pin = force * torque / radius, given.pin * radius
        return {
            "scatter": scatter,
            "contact_force_max": greatest,
            "pressure_max": hertz_pressure(greatest, modulus, thick, pin),
            "size": discs.size * radius,
            "mass": sum(masses) / radius**2,
            "rise_time_98": rise * np.sqrt(follower / torque),
            "driver_inertia": driver,
            "follower_inertia": follower,
            "driver_thickness": driver / (discs.driver[1] * scale),
            "follower_thickness": thick,
            "thinnest_wall": discs.wall * radius,
            "jam_margin": table.T[4] + 0.0 * radius,
        }

    @property
    def period(self) -> float:
        """Period of an engagement at the torque of the start that the requirement needs [s].

        Over a run the period is inversely proportional to the root of the torque, which falls
        linearly. The additional time of a start from rest is corrected when a design is simulated.
        """
        given = self.requirement
        if given.total_time is None or given.turns is None:
            assert given.period is not None
            return given.period
        lost = given.torque_lost
        slower = 2.0 * (1.0 - math.sqrt(1.0 - lost)) / lost if lost else 1.0
        engagements = given.turns * 2.0 * math.pi / self.wheel.cell_angle
        return given.total_time / engagements / slower


def wheels_for(requirement: Requirement) -> list[UnitWheel]:
    """The wheels that a requirement allows and that move at all of its frictions."""
    kinds = (False, True) if requirement.internal is None else (requirement.internal,)
    low, high = map(int, requirement.slots)
    found = []
    for slots, internal in product(range(low, high + 1), kinds):
        set_stage(f"wheels with {slots} slots")
        wheel = UnitWheel(requirement, slots, internal)
        with suppress(InvalidValue):  # pins too thick for so many slots
            if wheel.discs and wheel.curves:
                found.append(wheel)
    return found
