"""Motion, torque and power of indexing drives at constant driver speed, and Filemon's figures.

The formulas hold for the numbers of one drive, and for arrays with those of many.
"""

import math
from functools import cached_property
from typing import Any

import numpy as np

from escapement.model.materials import given
from escapement.model.natural import natural

NAN = math.nan
_CONSTANT = 1e-12  # share of g below which g' is rounding, as in a table of constant ratio
_NOTHING = 1e-11  # share of its greatest value below which a deceleration at the exit is rounding


def where(condition: Any, value: Any, other: Any) -> Any:
    """As `numpy.where`; for a single condition one of both values itself."""
    if isinstance(condition, np.ndarray):
        return np.where(condition, value, other)
    return value if condition else other


class IndexTorque:
    """Motion of the table, torque and power of the drive.

    A subclass has the numbers of `index_case.IndexCase`, each a number or an array; the
    `mechanism`, which all drives have in common, and its `lengths` [m]; and `cycle`, the figures
    that `cycle_figures` returns.
    """

    def natural_numbers(self: Any) -> dict[str, Any]:
        """Numbers of the scene in units of I_f, I_f W^2 and 1/W."""
        # the efficiency of this case is that of the drive, and gears have none of their own
        others = {"torque": self.inertial, "driver_inertia": self.follower_inertia}
        others["efficiency"] = 1.0
        return natural({**vars(self), **self.lengths, **others}, self.mechanism.meshed)

    # --- times and motion of the table ------------------------------------------------------

    @property
    def cycle_time(self: Any) -> Any:
        """Time from one pin entry to the next [s]."""
        return self.mechanism.cell_angle / self.speed

    @property
    def motion_ratio(self: Any) -> Any:
        """Share of the cycle in which the follower moves [-]."""
        return float(self.mechanism.motion_ratio)

    @property
    def index_time(self) -> Any:
        """Time in which the follower moves [s]."""
        return self.motion_ratio * self.cycle_time

    @property
    def dwell_time(self) -> Any:
        """Time in which it rests [s]."""
        return (1.0 - self.motion_ratio) * self.cycle_time

    @property
    def follower_velocity_max(self: Any) -> Any:
        """Greatest speed of the follower [rad/s]."""
        return self.cycle.ratio_max * self.speed

    @property
    def follower_acceleration_max(self: Any) -> Any:
        """Greatest magnitude of its acceleration [rad/s^2]."""
        return self.cycle.bend_max * self.speed**2

    # --- torque and power -------------------------------------------------------------------

    @property
    def torque_max(self: Any) -> Any:
        """Greatest torque of the drive [N m]."""
        return self.cycle.torque_max * self.inertial

    @property
    def torque_max_angle(self: Any) -> Any:
        """Where it is, from dead centre [rad]."""
        return self.cycle.torque_max_angle

    @property
    def torque_min(self: Any) -> Any:
        """Least torque; below zero the follower drives [N m]."""
        return self.cycle.torque_min * self.inertial

    @property
    def torque_min_angle(self: Any) -> Any:
        """Where it is, from dead centre [rad]."""
        return self.cycle.torque_min_angle

    @cached_property
    def torque_dwell(self: Any) -> Any:
        """Torque in the dwell: bearing, drag, and the locking disc [N m]."""
        drag = (self.driver_drag * self.speed + self.driver_viscous) * self.speed
        unlocked, locked = self.driver_bearing_torque + drag, self.locking_torque
        return (unlocked + where(locked == locked, locked, 0.0)) / self.efficiency

    @cached_property
    def torque_mean(self: Any) -> Any:
        """Mean from pin entry to dead centre, Filemon's (10) [N m]; see `Case.half`."""
        return self.cycle.first_half * self.inertial / (self.half - self.mechanism.breaks[0])

    @property
    def torque_mean_index(self: Any) -> Any:
        """Mean torque while the follower moves [N m]."""
        return self.cycle.torque_integral * self.inertial / self._index_angle

    @property
    def torque_mean_cycle(self: Any) -> Any:
        """Mean torque over the whole cycle, dwell included [N m]."""
        work = self.cycle.torque_integral * self.inertial + self.torque_dwell * self._dwell_angle
        return work / self.mechanism.cell_angle

    @property
    def torque_rms(self: Any) -> Any:
        """Root mean square of the torque over the whole cycle [N m]."""
        square = self.cycle.square_integral * self.inertial**2
        square = square + self.torque_dwell**2 * self._dwell_angle
        return np.sqrt(square / self.mechanism.cell_angle)

    @property
    def _index_angle(self: Any) -> float:
        return float(self.mechanism.breaks[-1] - self.mechanism.breaks[0])

    @property
    def _dwell_angle(self: Any) -> float:
        return float(max(self.mechanism.cell_angle - self._index_angle, 0.0))

    @property
    def power_max(self: Any) -> Any:
        """Greatest power of the drive [W]."""
        return self.torque_max * self.speed

    @property
    def power_mean(self: Any) -> Any:
        """Mean power over the whole cycle [W]."""
        return self.torque_mean_cycle * self.speed

    @property
    def power_mean_to_dead_centre(self: Any) -> Any:
        """Mean power over the first half of the index, Filemon's N2 = M_2av omega_2 [W]."""
        return self.torque_mean * self.speed

    @property
    def torque_max_over_mean(self) -> Any:
        """Filemon's s, the overload that a motor must stand; NaN where the mean is not above 0."""
        mean = self.torque_mean
        return self.torque_max / where(mean > 0.0, mean, NAN)

    # --- reversals of the pin ---------------------------------------------------------------

    @property
    def inertia_ratio(self: Any) -> Any:
        """Filemon's F = I_f omega^2/M_load [-]; NaN without a load, or with one that changes."""
        return self.inertial / given(self.load_torque) + self._changing

    @property
    def _changing(self: Any) -> float:
        """NaN with a load that changes with the angle, for which there are no such limits, or 0."""
        return 0.0 if self.load_curve is None else NAN

    @property
    def zone(self: Any) -> Any:
        """Filemon's: 1 without reversal; 2 where the pin leaves on the wall it entered on; 3 where
        it leaves on the one where the follower drives.
        """
        count, side = self.cycle.reversals, self.cycle.last_side
        return where(count == 0.0, 1, where(side > 0.0, 2, 3))

    @cached_property
    def reversal_limits(self: Any) -> tuple[float, float]:
        """F12 and F23, Filemon's (8) and (9) for any mechanism; infinite where there is none [-].

        Up to F = F12 a drive with no other resistance than its load has no reversal; from F23 on
        its pin leaves on the wall where the follower drives.
        """
        of_one = (self.cycle.bend_min, self.cycle.bend_exit, self.cycle.ratio_max)
        # they are those of the mechanism, which all drives have in common
        deepest, last, ratio = (float(x[0]) if isinstance(x, np.ndarray) else x for x in of_one)
        if -deepest <= _CONSTANT * ratio:
            return math.inf, math.inf
        return -1.0 / deepest, -1.0 / last if last < _NOTHING * deepest else math.inf

    @cached_property
    def _inertial_limit(self: Any) -> Any:
        """Greatest I_f omega^2 without a reversal [N m]."""
        limit = self.reversal_limits[0]
        # no inertia is too great for a mechanism that never slows its follower, even without load
        bound = limit if math.isinf(limit) else limit * self.load_torque
        return bound + self._changing

    @property
    def greatest_speed(self: Any) -> Any:
        """Greatest speed of the driver without a reversal under the load alone [rad/s]."""
        return np.sqrt(self._inertial_limit / self.follower_inertia)

    @property
    def greatest_follower_inertia(self: Any) -> Any:
        """Greatest inertia of the follower without a reversal under the load alone [kg m^2]."""
        return self._inertial_limit / self.speed**2

    @property
    def least_load_torque(self: Any) -> Any:
        """Least load without a reversal where nothing else resists the follower [N m]."""
        return self.inertial / self.reversal_limits[0] + self._changing
