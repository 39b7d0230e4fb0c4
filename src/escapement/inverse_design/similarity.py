"""The figures of a kind of wheel, in natural units and in SI.

Period, force, size and mass of an escapement without a load follow from those of one with the
follower inertia, the torque and the crank radius 1, by similarity: the period is proportional
to the root of inertia over torque, the force to torque over radius. Without losses but friction in
the slots these figures depend on the ratio of the inertias alone. Rollers, vanes and bearings are
divided by crank radius, follower inertia and torque, and the number that follows from the period is
found by the secant method.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

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
_ROLLERS = 8
"""Ratios of roller and crank radius for which discs are drawn."""
NATURAL = ("period", "scatter", "force", "rise", "jam_margin")
"""Figures of a wheel in natural units."""
_PERIOD = 3.0
"""A usual period in natural units, from which the search for the number that follows begins."""
_ROUNDS, _FEWER = 20, 4
"""Steps of the secant method for one design, and for many."""
_EQUAL, _NEAR = 1e-11, 1e-2
"""Errors of the logarithm of the inertia for a period that are none, and that are small."""
_SLOPES = {"follower_inertia": 1.0, "torque": -1.0, "crank_radius": 0.25}
"""By how much the logarithm of a number grows with that of the inertia for a period."""
Values = dict[str, Any]


class Discs(NamedTuple):
    """The discs of a wheel of crank radius 1, or of several.

    size : length over both discs. wall : their thinnest wall. The others are area and polar second
    moment of each disc.
    """

    size: Any
    wall: Any
    driver_area: Any
    driver_second: Any
    follower_area: Any
    follower_second: Any


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
    return Discs(size, wall, *driver, moments["follower"].area, moments["follower"].second)


@dataclass(frozen=True)
class UnitWheel:
    """A wheel of crank radius 1 with so many slots, as a requirement asks for it."""

    requirement: Requirement
    slots: int
    internal: bool

    def wheel(self, size: float = 1.0, roller: float = 0.0) -> Geneva:
        """The wheel of a crank radius; raises InvalidValue where pins or rollers do not fit."""
        pin = self.requirement.pin * size
        return Geneva(
            self.slots, internal=self.internal, crank_radius=size, pin_radius=pin,
            roller_radius=roller,
        )  # fmt: skip

    @cached_property
    def discs(self) -> PchipInterpolator | Discs:
        """Its discs, over the ratio of roller and crank radius where it has rollers."""
        asked, found = self.requirement, []
        if asked.roller_radius is None:
            return discs_of(self.wheel())
        least = max(asked.roller_radius[0] / asked.crank_radius[-1], 1.01 * asked.pin)
        most = min(asked.roller_radius[-1] / asked.crank_radius[0], 0.99 * self.wheel().widest_pin)
        for ratio in np.geomspace(least, max(most, least * (1.0 + 1e-9)), _ROLLERS):
            with suppress(InvalidValue):  # too large, or not larger than the pin
                found.append((ratio, *discs_of(self.wheel(roller=float(ratio)))))
        if len(found) < 2:
            raise InvalidValue("no roller fits")
        table = np.array(found)
        return PchipInterpolator(table[:, 0], table[:, 1:])

    def _discs_at(self, roller: Any, exact: bool) -> Discs:
        """Its discs for ratios of roller and crank radius, of which `exact` takes one."""
        if not isinstance(curves := self.discs, PchipInterpolator):
            return curves
        if not exact:
            return Discs(*curves(roller, extrapolate=False).T)
        return Discs(*np.array(discs_of(self.wheel(roller=float(roller[0])))))

    @cached_property
    def curves(self) -> PchipInterpolator | None:
        """A row of `NATURAL` over the logarithm of the ratio; None if it hardly moves anywhere."""
        ends = self.requirement.inertia_ratio
        low, high = ends[0], ends[-1]
        ratios = (
            np.geomspace(low, high, RATIOS) if low < high else low * np.array([1.0, 1.0 + 1e-9])
        )
        table = self.exact({"driver_inertia": ratios})
        good = np.isfinite(table).all(axis=1)
        return PchipInterpolator(np.log(ratios[good]), table[good]) if good.sum() > 1 else None

    def exact(self, columns: Values) -> FloatArray:
        """A row of `NATURAL` for each case, logarithms except for the jam margin; NaN where it
        does not move at the least, the middle and the greatest friction.

        columns : numbers of an escapement in natural units, arrays of shape (n,).
        """
        low, high = self.requirement.friction
        three = np.array([low, 0.5 * (low + high), high])
        timer = Escapement(self.wheel(), Inertia(1.0, 1.0), torque=1.0)
        cases: Values = {"method": "list"} | {name: x.tolist() for name, x in columns.items()}
        study = sweep(timer, friction=three, sample=cases, results=_SAMPLED)
        shape = 3, len(cases["driver_inertia"])
        moves = np.asarray(study.results["status"]).reshape(shape) == Status.OK
        period, force, rise, limit = (
            np.where(moves, np.asarray(study.results[name]).reshape(shape), np.nan)
            for name in _SAMPLED
        )
        scatter = np.maximum(0.5 * np.ptp(period, axis=0) / period[1], 1e-12)
        positive = period[1], scatter, force.max(axis=0), rise[1]
        with np.errstate(divide="ignore"):
            return np.column_stack([*map(np.log, positive), 1.0 - high / limit.min(axis=0)])

    def _natural(self, given: Values, exact: bool) -> FloatArray:
        """A row of `NATURAL` for each of many designs, of which no number is missing."""
        losses = self.requirement.losses
        if not (losses or exact):
            assert self.curves is not None
            return np.asarray(self.curves(np.log(given["inertia_ratio"]), extrapolate=False))
        units = {
            "roller_radius": "crank_radius", "driver_bearing_radius": "crank_radius",
            "follower_bearing_radius": "crank_radius", "driver_drag": "follower_inertia",
            "follower_drag": "follower_inertia", "driver_bearing_torque": "torque",
        }  # fmt: skip
        columns = {"driver_inertia": given["inertia_ratio"]}
        for name in losses:
            columns[name] = given[name] / (given[units[name]] if name in units else 1.0)
        table = np.full((columns["driver_inertia"].size, len(NATURAL)), np.nan)
        sound = np.isfinite(np.sum([*columns.values()], axis=0))
        if sound.any():
            table[sound] = self.exact({name: x[sound] for name, x in columns.items()})
        return table

    def values(self, chosen: Values, exact: bool = False, slower: float = 1.0) -> Values:
        """The numbers and figures in SI of designs with these searched numbers.

        Parameters
        ----------
        chosen : numbers of `Requirement.searched`, arrays of shape (n,).
        exact : whether to compute one design instead of interpolating between computed ones.
        slower : factor of the period.
        """
        name, period = self.requirement.follows, slower * self.period
        slope: Any = _SLOPES[name]
        x, before = self._guess(chosen, period), None
        for _ in range(_ROUNDS if exact else _FEWER):
            given = self._completed(chosen | {name: np.exp(x)}, exact)
            table = self._natural(given, exact)
            with np.errstate(all="ignore"):
                needed = given["torque"] * (period / np.exp(table[:, 0])) ** 2
                error = np.log(needed / given["follower_inertia"])
                if before is not None:
                    found = (before[0] - x) / (error - before[1])
                    slope = np.where(found / _SLOPES[name] > 0.0, found, _SLOPES[name])
            if not (np.abs(error) > _EQUAL).any():
                break
            before = x, error
            x = x + np.nan_to_num(slope * error, posinf=0.0, neginf=0.0)  # some do not move
        table[~(np.abs(error) < (_EQUAL if exact else _NEAR))] = np.nan
        return self.in_si(table, given, exact)

    def _guess(self, chosen: Values, period: float) -> FloatArray:
        """Logarithm of the number that follows, roughly."""
        asked, root = self.requirement, (period / _PERIOD) ** 2
        if asked.follows == "follower_inertia":
            return np.asarray(np.log(chosen["torque"] * root))
        middle = math.sqrt(asked.crank_radius[0] * asked.crank_radius[-1])
        first = {"crank_radius": middle + 0.0 * next(iter(chosen.values()))}
        if asked.follows == "crank_radius":
            return np.asarray(np.log(first["crank_radius"]))
        given = self._completed(first | chosen, exact=False)
        lost = 2.0 * chosen.get("driver_bearing_torque", 0.0)
        return np.asarray(np.log(given["follower_inertia"] / root + lost))

    def _completed(self, given: Values, exact: bool) -> Values:
        """The numbers with ratio and inertia of discs of given thickness."""
        radius = given["crank_radius"]
        discs = self._discs_at(given.get("roller_radius", 0.0) / radius, exact)
        scale = radius**4 * self.requirement.density
        driver = given.get("driver_thickness", 0.0) * discs.driver_second * scale
        if "follower_thickness" in given:
            follower = given["follower_thickness"] * discs.follower_second * scale
            ratio = driver / follower if "driver_thickness" in given else given["inertia_ratio"]
            return given | {"follower_inertia": follower, "inertia_ratio": ratio}
        if "driver_thickness" in given:
            given = given | {"follower_inertia": driver / given["inertia_ratio"]}
        return given

    def in_si(self, table: FloatArray, given: Values, exact: bool = True) -> Values:
        """Numbers and figures in SI from rows of `NATURAL`, for given ratio, radius, torque and
        follower inertia."""
        radius, torque, asked = given["crank_radius"], given["torque"], self.requirement
        follower, scale = given["follower_inertia"], radius**4 * asked.density
        discs = self._discs_at(given.get("roller_radius", 0.0) / radius, exact)
        _, scatter, force, rise = np.exp(table.T[:4])
        driver, greatest = given["inertia_ratio"] * follower, force * torque / radius
        thick = follower / (discs.follower_second * scale)
        thick_driver = driver / (discs.driver_second * scale)
        areas = thick_driver * discs.driver_area + thick * discs.follower_area
        modulus = contact_modulus(material(asked.pin_material), material(asked.wheel_material))
        pin = given.get("roller_radius", asked.pin * radius)
        return given | {
            "scatter": scatter,
            "contact_force_max": greatest,
            "pressure_max": hertz_pressure(greatest, modulus, thick, pin),
            "size": discs.size * radius,
            "mass": areas * radius**2 * asked.density,
            "rise_time_98": rise * np.sqrt(follower / torque),
            "driver_inertia": driver,
            "driver_thickness": thick_driver,
            "follower_thickness": thick,
            "thinnest_wall": discs.wall * radius,
            "jam_margin": table.T[4],
        }

    def timer(self, numbers: Values) -> Escapement:
        """The escapement with these numbers, at the middle of the friction."""
        asked, radius, torque = self.requirement, numbers["crank_radius"], numbers["torque"]
        losses = {name: numbers[name] for name in asked.losses}
        wheel = self.wheel(radius, losses.pop("roller_radius", 0.0))
        lost = asked.torque_lost * torque / (2.0 * math.pi * asked.turns) if asked.turns else 0.0
        inertia = Inertia(numbers["driver_inertia"], numbers["follower_inertia"])
        friction = 0.5 * sum(asked.friction)
        return Escapement(wheel, inertia, torque, friction, spring_rate=lost, **losses)

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
        engagements = given.turns * 2.0 * math.pi / self.wheel().cell_angle
        return given.total_time / engagements / slower


def wheels_for(requirement: Requirement) -> list[UnitWheel]:
    """The wheels that a requirement allows and that move at all of its frictions."""
    kinds = (False, True) if requirement.internal is None else (requirement.internal,)
    low, high, *others = map(int, requirement.slots)
    every = {low, high, *others} if others else range(low, high + 1)
    found = []
    for slots, internal in product(sorted(every), kinds):
        set_stage(f"wheels with {slots} slots")
        wheel = UnitWheel(requirement, slots, internal)
        with suppress(InvalidValue):  # pins too thick for so many slots
            if wheel.discs and (requirement.losses or wheel.curves):
                found.append(wheel)
    return found
