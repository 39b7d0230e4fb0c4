"""Torque, power, force and stresses of an indexing drive at constant driver speed."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from escapement.base import validate
from escapement.constant_speed.cycle_figures import CycleFigures, cycle_figures, reversals_between
from escapement.constant_speed.index_case import IndexCase
from escapement.constant_speed.input_torque import DriveTorque
from escapement.mechanisms.path import smooth_intervals
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import slide_edges
from escapement.model.escapement import Escapement, Inertia
from escapement.model.materials import (
    contact_modulus,
    hertz_pressure,
    material,
    pin_bending,
    pin_shear,
    radius_for,
)
from escapement.model.scene import Scene, scene_tuple

_NAN = math.nan
_SIZES = ("roller_radius", "pin_radius", "clearance")
_RESISTING = (
    *("driver_bearing_friction", "driver_bearing_radius", "follower_bearing_friction"),
    *("follower_bearing_radius", "driver_bearing_torque", "driver_drag", "follower_drag"),
    *("driver_viscous", "follower_viscous"),
)


@dataclass(frozen=True, repr=False)
class IndexTorque(IndexCase):
    """Motion of the table, torque and power of the drive, force and stresses of the pin."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self._timer  # noqa: B018 - checks the numbers that it shares with an escapement
        clearance = {"clearance": self.mechanism.clearance}
        for name, value in (clearance | {"load_frequency": self.load_frequency}).items():
            if value and not self.dwell_time > 0.0:
                rule = "0 where the follower never rests, so that no index begins from rest"
                raise validate.fail(name, rule, value, "give fewer pins, or simulate the motion")

    # --- the drive in units of I_f, I_f W^2 and 1/W -----------------------------------------

    @cached_property
    def _timer(self) -> Escapement:
        """An escapement of which natural units are those in which the driver's speed is one."""
        numbers = {name: getattr(self, name) for name in _RESISTING if getattr(self, name)}
        return Escapement(
            self.mechanism, Inertia(self.follower_inertia, self.follower_inertia),
            torque=self.inertial, friction=self.friction, load_torque=self._load, **numbers,
        )  # fmt: skip

    @property
    def _load(self) -> float:
        return float(self.load_torque)

    @property
    def _scene(self) -> Scene:
        return self._timer.scene

    @cached_property
    def _edges(self) -> FloatArray:
        """Driver angles between which torque and forces are smooth but for reversals [rad]."""
        scene, parts = self._scene, [smooth_intervals(self._scene.path, self.mechanism.breaks)]
        if not scene.path.table:
            parts.append(slide_edges(scene.path, scene.pin, scene.edges))
        found: FloatArray = np.unique(np.concatenate([*parts, [self.half]]))
        return found

    @cached_property
    def _reversals(self) -> FloatArray:
        found: FloatArray = reversals_between(scene_tuple(self._scene), self._edges)
        return found

    @cached_property
    def _cycle(self) -> CycleFigures:
        cuts = np.unique(np.concatenate([self._edges, self._reversals]))
        given = scene_tuple(self._scene), cuts, self.half, float(self.efficiency)
        result: CycleFigures = cycle_figures(*given)
        return result

    @property
    def _length(self) -> float:
        """The crank radius [m]; NaN where there is none."""
        return _NAN if self.mechanism.crank_radius is None else float(self.mechanism.crank_radius)

    # --- times and motion of the table ------------------------------------------------------

    @property
    def cycle_time(self) -> float:
        """Time from one pin entry to the next [s]."""
        return float(self.mechanism.cell_angle / self.speed)

    @property
    def index_time(self) -> float:
        """Time in which the follower moves [s]."""
        return self.mechanism.motion_ratio * self.cycle_time

    @property
    def dwell_time(self) -> float:
        """Time in which it rests [s]."""
        return (1.0 - self.mechanism.motion_ratio) * self.cycle_time

    @property
    def motion_ratio(self) -> float:
        """Share of the cycle in which it moves [-]."""
        return float(self.mechanism.motion_ratio)

    @property
    def follower_velocity_max(self) -> float:
        """Greatest speed of the follower [rad/s]."""
        return self._cycle.ratio_max * self.speed

    @property
    def follower_acceleration_max(self) -> float:
        """Greatest magnitude of its acceleration [rad/s^2]."""
        return self._cycle.bend_max * self.speed**2

    # --- torque and power -------------------------------------------------------------------

    @property
    def torque_max(self) -> float:
        """Greatest torque of the drive [N m]."""
        return self._cycle.torque_max * self.inertial

    @property
    def torque_max_angle(self) -> float:
        """Where it is, from dead centre [rad]."""
        return self._cycle.torque_max_angle

    @property
    def torque_min(self) -> float:
        """Least torque; below zero the follower drives [N m]."""
        return self._cycle.torque_min * self.inertial

    @property
    def torque_min_angle(self) -> float:
        """Where it is, from dead centre [rad]."""
        return self._cycle.torque_min_angle

    @property
    def torque_dwell(self) -> float:
        """Torque in the dwell: bearing, drag, and the locking disc [N m]."""
        scene = self._scene
        own = (scene.bearing + scene.driver_drag + scene.driver_viscous) * self.inertial
        return (own + (self.locking_torque if self.locking_radius else 0.0)) / self.efficiency

    @property
    def torque_mean(self) -> float:
        """Mean from pin entry to dead centre, Filemon's (10) [N m]; see `Case.half`."""
        return self._cycle.first_half * self.inertial / (self.half - float(self._edges[0]))

    @property
    def torque_mean_index(self) -> float:
        """Mean torque while the follower moves [N m]."""
        return self._cycle.torque_integral * self.inertial / self._index_angle

    @property
    def torque_mean_cycle(self) -> float:
        """Mean torque over the whole cycle, dwell included [N m]."""
        work = self._cycle.torque_integral * self.inertial + self.torque_dwell * self._dwell_angle
        return float(work / self.mechanism.cell_angle)

    @property
    def torque_rms(self) -> float:
        """Root mean square of the torque over the whole cycle [N m]."""
        square = self._cycle.square_integral * self.inertial**2
        square += self.torque_dwell**2 * self._dwell_angle
        return math.sqrt(square / self.mechanism.cell_angle)

    @property
    def _index_angle(self) -> float:
        return float(self._edges[-1] - self._edges[0])

    @property
    def _dwell_angle(self) -> float:
        return float(max(self.mechanism.cell_angle - self._index_angle, 0.0))

    @property
    def power_mean(self) -> float:
        """Mean power over the whole cycle [W]."""
        return self.torque_mean_cycle * self.speed

    @property
    def reversals(self) -> FloatArray:
        """Driver angles from dead centre where the pin changes walls [rad]."""
        return self._reversals

    @property
    def thin(self) -> DriveTorque:
        """The same drive with thin pins, without clearance and bearings, as Filemon has it."""
        wheel: Any = self.mechanism
        sizes = {name: 0.0 for name in _SIZES if getattr(wheel, name)}
        return DriveTorque(
            replace(wheel, **sizes) if sizes else wheel, self.speed, self.load_torque,
            self.follower_inertia, self.efficiency, self.friction,
        )  # fmt: skip

    # --- force and stresses of the pin ------------------------------------------------------

    @property
    def contact_moment_max(self) -> float:
        """Greatest magnitude of the moment on the follower [N m]."""
        return self._cycle.moment_max * self.inertial

    @property
    def contact_moment_max_angle(self) -> float:
        """Where it is, from dead centre [rad]."""
        return self._cycle.moment_max_angle

    @property
    def contact_force_max(self) -> float:
        """Greatest force on the pin [N]; NaN without a crank radius."""
        return self._cycle.force_max * self.inertial / self._length

    @property
    def contact_force_max_angle(self) -> float:
        """Where it is, from dead centre [rad]."""
        return self._cycle.force_max_angle if self._length > 0.0 else _NAN

    @property
    def _stressed_radius(self) -> float:
        """Radius of what presses on the wall [m]; NaN where none is given."""
        wheel = self.mechanism
        radius = self.pressure_pin_radius or wheel.roller_radius or wheel.pin_radius
        return float(radius) or _NAN

    @property
    def _modulus(self) -> float:
        return contact_modulus(material(self.pin_material), material(self.wheel_material))

    @property
    def pressure_max(self) -> float:
        """Greatest pressure between pin and wall [Pa]; NaN without radius and length of the pin."""
        if not self.pin_length:
            return _NAN
        return hertz_pressure(
            self.contact_force_max, self._modulus, self.pin_length, self._stressed_radius
        )

    @property
    def pin_diameter_needed(self) -> float:
        """Diameter of a pin whose pressure is `pressure_limit` under the same force [m]."""
        if not (self.pin_length and self.pressure_limit):
            return _NAN
        force = self.contact_force_max
        return 2.0 * radius_for(force, self._modulus, self.pin_length, self.pressure_limit)

    @property
    def _pin_radius(self) -> float:
        """Radius of the pin itself, also inside a roller [m]."""
        return float(self.mechanism.pin_radius or self.pressure_pin_radius) or _NAN

    @property
    def pin_bending_max(self) -> float:
        """Greatest bending stress of the pin, a cantilever [Pa]."""
        if not self.pin_length:
            return _NAN
        return pin_bending(self.contact_force_max, self.pin_length, self.pin_gap, self._pin_radius)

    @property
    def pin_shear_max(self) -> float:
        """Greatest mean shear stress of the pin [Pa]."""
        return pin_shear(self.contact_force_max, self._pin_radius) if self.pin_length else _NAN

    # --- locking disc -----------------------------------------------------------------------

    @property
    def locking_torque(self) -> float:
        """Friction of the locking disc under the load at rest [N m].

        The disc carries the load by a force through the driver's axis, whose lever about the
        follower is c_d sin(gamma) with the centre distance c_d.
        """
        wheel: Any = self.mechanism
        if not (self.locking_radius and self.locking_angle):
            return _NAN
        lever = wheel.centre_distance * self._length * math.sin(self.locking_angle)
        return float(self.locking_friction * self._load / lever * self.locking_radius)
