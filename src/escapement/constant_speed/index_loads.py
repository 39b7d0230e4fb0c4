"""Force and stresses of the pin, impacts, ringing and locking of indexing drives.

The formulas hold for the numbers of one drive, and for arrays with those of many.
"""

import math
from functools import cached_property
from typing import Any

import numpy as np

from escapement.constant_speed.index_torque import NAN, IndexTorque, where
from escapement.model.materials import contact_modulus, given, material, pin_stresses, radius_for


class IndexLoads(IndexTorque):
    """What the pin, the load and the locking disc have to stand.

    A subclass has besides `knock` and `ringing`, which hold NaN where there is no clearance and
    where the shaft is rigid. A number that cannot be given is NaN.
    """

    # --- force and stresses of the pin ------------------------------------------------------

    @cached_property
    def _length(self: Any) -> Any:
        """The crank radius [m]; NaN where there is none."""
        return given(self.lengths["crank_radius"])

    @property
    def contact_moment_max(self: Any) -> Any:
        """Greatest magnitude of the moment on the follower [N m]."""
        return self.cycle.moment_max * self.inertial

    @property
    def contact_moment_max_angle(self: Any) -> Any:
        """Where it is, from dead centre [rad]."""
        return self.cycle.moment_max_angle

    @cached_property
    def contact_force_max(self: Any) -> Any:
        """Greatest force on the pin [N]; NaN without a crank radius."""
        return self.cycle.force_max * self.inertial / self._length

    @property
    def contact_force_max_angle(self: Any) -> Any:
        """Where it is, from dead centre [rad]."""
        return self.cycle.force_max_angle + 0.0 * self._length

    @cached_property
    def _stresses(self: Any) -> dict[str, Any]:
        numbers = vars(self) | self.lengths
        return pin_stresses(self.contact_force_max, self.rubbing_max, numbers)

    @property
    def rubbing_max(self: Any) -> Any:
        """Greatest product of the force on the pin and its sliding speed [W]."""
        return self.cycle.rubbing_max * self.inertial * self.speed + 0.0 * self._length

    @property
    def pressure_speed_max(self) -> Any:
        """Greatest mean pressure times sliding speed [W/m^2]; NaN for a roller."""
        return self._stresses["pressure_speed_max"]

    @property
    def pin_load_frequency(self: Any) -> Any:
        """How often each pin is loaded, once in a turn of the driver [1/s]."""
        return self.speed / (2.0 * math.pi)

    @property
    def pin_loads(self: Any) -> Any:
        """How often it is loaded over `running_time`."""
        return self.pin_load_frequency * given(self.running_time)

    @property
    def pressure_max(self) -> Any:
        """Greatest pressure between pin and wall [Pa]; NaN without radius and length of the pin."""
        return self._stresses["pressure_max"]

    @property
    def pin_diameter_needed(self: Any) -> Any:
        """Diameter of a pin whose pressure is `pressure_limit` under the same force [m]."""
        modulus = contact_modulus(material(self.pin_material), material(self.wheel_material))
        force, limit = self.contact_force_max, given(self.pressure_limit)
        return 2.0 * radius_for(force, modulus, given(self.pin_length), limit)

    @property
    def pin_bending_max(self) -> Any:
        """Greatest bending stress of the pin, a cantilever [Pa]."""
        return self._stresses["pin_bending_max"]

    @property
    def pin_shear_max(self) -> Any:
        """Greatest mean shear stress of the pin [Pa]."""
        return self._stresses["pin_shear_max"]

    # --- impacts ----------------------------------------------------------------------------

    @property
    def entry_impact_angle(self: Any) -> Any:
        """Where the pin meets its slot, from dead centre [rad]; NaN without clearance."""
        return self.knock.entry_angle

    @property
    def entry_impact_speed(self: Any) -> Any:
        """Speed at which it does [m/s]."""
        return self.knock.entry_distance * self._length * self.knock.entry_speed * self.speed

    @property
    def entry_impact_energy(self: Any) -> Any:
        """Energy lost in that impact, which is plastic [J]."""
        return 0.5 * self.inertial * self.knock.entry_speed**2

    @property
    def lift_off_angle(self: Any) -> Any:
        """Where the pin leaves this wall, from dead centre [rad]."""
        return self.knock.lift_off

    @property
    def reversal_impact_angle(self: Any) -> Any:
        """Where it meets a wall again; NaN if not before the exit [rad]."""
        return self.knock.reversal_angle

    @property
    def reversal_flight_time(self: Any) -> Any:
        """Time between the two [s]."""
        return (self.knock.reversal_angle - self.knock.lift_off) / self.speed

    @property
    def reversal_impact_speed(self: Any) -> Any:
        """Speed at which it meets the wall [m/s]."""
        return self.knock.reversal_distance * self._length * self.knock.reversal_speed * self.speed

    @property
    def reversal_impact_energy(self: Any) -> Any:
        """Energy lost in that impact if it is plastic [J]."""
        return 0.5 * self.inertial * self.knock.reversal_speed**2

    # --- ringing of the load ----------------------------------------------------------------

    @property
    def deflection_max(self: Any) -> Any:
        """Greatest angle between load and wheel, besides that of a constant load [rad]."""
        return self.ringing.deflection_max

    @property
    def residual_amplitude(self: Any) -> Any:
        """Amplitude that is left when the index ends [rad]."""
        return self.ringing.residual_amplitude

    @cached_property
    def settling_time_load(self: Any) -> Any:
        """Time after the index until the amplitude is `load_tolerance` [s]; inf without damping."""
        ratio = self.residual_amplitude / self.load_tolerance
        rate = 2.0 * math.pi * self.load_damping * self.load_frequency
        needed = np.log(np.maximum(ratio, 1.0)) / given(rate)
        for_ever = (ratio > 1.0) & (rate == 0.0)
        return where(for_ever, math.inf, where(ratio <= 1.0, 0.0, needed))

    @property
    def dwell_left(self) -> Any:
        """Time of the dwell that is left when the load is at rest; below zero it still rings."""
        return self.dwell_time - self.settling_time_load

    # --- locking disc -----------------------------------------------------------------------

    @cached_property
    def locking_torque(self: Any) -> Any:
        """Friction of the locking disc under the load at rest [N m].

        The disc carries the load by a force through the driver's axis, whose lever about the
        follower is c_d sin(gamma) with the centre distance c_d.
        """
        distance = getattr(self.mechanism, "centre_distance", NAN) * self._length
        lever = distance * np.sin(given(self.locking_angle))
        return self.locking_friction * self.load_torque / lever * given(self.locking_radius)
