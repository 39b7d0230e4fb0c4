"""An indexing drive as the engineer of a machine meets it: all figures at constant driver speed.

Times, speeds, torque, power, forces, stresses of the pin, impacts in a slot with clearance, the
ringing of the load after the index, and the torque of the locking disc. Each is computed when it is
first asked for.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.constant_speed.contact import within_cell
from escapement.constant_speed.cycle_figures import contact_states
from escapement.constant_speed.index_torque import IndexTorque
from escapement.constant_speed.knock import NOWHERE, Knock, knock
from escapement.constant_speed.ringing import Ringing, deflections, ringing
from escapement.mechanisms.protocol import FloatArray, Mechanism
from escapement.model.scene import scene_tuple

_NAN = math.nan
_SIZES = ("roller_radius", "pin_radius", "clearance")
_RESISTING = (
    *("driver_bearing_friction", "driver_bearing_radius", "follower_bearing_friction"),
    *("follower_bearing_radius", "driver_bearing_torque", "driver_drag", "follower_drag"),
    *("driver_viscous", "follower_viscous"),
)


class IndexState(NamedTuple):
    """An indexing drive at driver angles `theta`: arrays of one shape.

    theta, phi : driver and follower angle from dead centre [rad].
    phi_dot, phi_ddot : speed and acceleration of the follower [rad/s, rad/s^2].
    torque : of the drive; below zero the follower drives [N m].
    contact_moment : moment of the contact on the follower; its sign is the wall [N m].
    contact_force : magnitude of the force on the pin [N]; NaN without a crank radius.
    deflection : angle of the load less that of the wheel [rad]; 0 on a rigid shaft.
    """

    theta: FloatArray
    phi: FloatArray
    phi_dot: FloatArray
    phi_ddot: FloatArray
    torque: FloatArray
    contact_moment: FloatArray
    contact_force: FloatArray
    deflection: FloatArray


@dataclass(frozen=True, repr=False)
class IndexingDrive(IndexTorque):
    """A mechanism whose driver turns at a constant speed; see `index` for its numbers."""

    # --- impacts ----------------------------------------------------------------------------

    @cached_property
    def knock(self) -> Knock | None:
        """Impacts in the units of `knock.Knock`; None where the pins have no clearance."""
        clearance, scene = self.mechanism.clearance, self._scene
        if not clearance:
            return None
        half = 0.5 * clearance / self._length
        found: Knock = knock(scene.path.numbers, half, scene.load, scene.edges[0], scene.edges[-1])
        return found

    def _impact(self, name: str, factor: float = 1.0) -> float:
        return _NAN if self.knock is None else factor * getattr(self.knock, name)

    @property
    def entry_impact_angle(self) -> float:
        """Where the pin meets the front wall, from dead centre [rad]; NaN without clearance."""
        return self._impact("entry_angle")

    @property
    def entry_impact_speed(self) -> float:
        """Speed at which it does [m/s]."""
        return self._impact("entry_distance", self._length * self.speed) * self._impact(
            "entry_speed"
        )

    @property
    def entry_impact_energy(self) -> float:
        """Energy of the follower that the impact brings to speed, and as much is lost [J]."""
        return 0.5 * self.inertial * self._impact("entry_speed") ** 2

    @property
    def lift_off_angle(self) -> float:
        """Where the pin leaves the front wall, from dead centre [rad]."""
        return self._impact("lift_off")

    @property
    def reversal_impact_angle(self) -> float:
        """Where it meets a wall again; NaN if not before the exit [rad]."""
        return self._impact("reversal_angle")

    @property
    def reversal_flight_time(self) -> float:
        """Time between the two [s]."""
        return (self.reversal_impact_angle - self.lift_off_angle) / self.speed

    @property
    def reversal_impact_speed(self) -> float:
        """Speed at which it meets the wall [m/s]."""
        away = self._impact("reversal_distance", self._length * self.speed)
        return away * self._impact("reversal_speed")

    @property
    def reversal_impact_energy(self) -> float:
        """Energy lost in that impact if it is plastic [J]."""
        return 0.5 * self.inertial * self._impact("reversal_speed") ** 2

    @property
    def ends_in_flight(self) -> bool:
        """Whether the index ends before the pin meets a wall again."""
        found = self.knock
        return found is not None and not math.isnan(found.lift_off) and found.wall == NOWHERE

    # --- ringing of the load ----------------------------------------------------------------

    @cached_property
    def ringing(self) -> Ringing | None:
        """How the load rings, in units of `ringing.Ringing`; None on a rigid shaft."""
        if not self.load_frequency:
            return None
        ratio = 2.0 * math.pi * self.load_frequency / self.speed
        found: Ringing = ringing(self._scene.path, self._edges, ratio, float(self.load_damping))
        return found

    @property
    def deflection_max(self) -> float:
        """Greatest angle between load and wheel, besides that of a constant load [rad]."""
        return _NAN if self.ringing is None else self.ringing.deflection_max

    @property
    def residual_amplitude(self) -> float:
        """Amplitude that is left when the index ends [rad]."""
        return _NAN if self.ringing is None else self.ringing.residual_amplitude

    @property
    def settling_time_load(self) -> float:
        """Time after the index until the amplitude is `load_tolerance` [s]; inf without damping."""
        if self.ringing is None:
            return _NAN
        ratio = self.residual_amplitude / self.load_tolerance
        if ratio <= 1.0:
            return 0.0
        rate = self.load_damping * 2.0 * math.pi * self.load_frequency
        return math.log(ratio) / rate if rate > 0.0 else math.inf

    @property
    def zone(self) -> int:
        """Filemon's: 1 without reversal; 2 where the pin leaves on the wall it entered on; 3 where
        it leaves on the one where the follower drives.
        """
        last = self._edges[-1] - 1e-9 * self._index_angle
        return 1 if not self.reversals.size else 2 if self.at(last).contact_moment > 0.0 else 3

    # --- states -----------------------------------------------------------------------------

    def at(self, theta: ArrayLike) -> IndexState:
        """States at driver angles from dead centre [rad], within one cell.

        Raises
        ------
        InvalidValue
            Where an angle is not finite or lies outside the cell.
        """
        angles = validate.numbers("theta", theta, "give angles")
        engaged, locked = within_cell(self.mechanism, angles)
        flat = np.ascontiguousarray(engaged).reshape(-1)
        table = np.empty((flat.size, 5))
        contact_states(scene_tuple(self._scene), flat, float(self.efficiency), table)
        table[:, :3] *= self.inertial
        table[:, 2] /= self._length
        table[:, 3] *= self.speed
        table[:, 4] *= self.speed**2
        table[locked.reshape(-1)] = self.torque_dwell, 0.0, 0.0 * self._length, 0.0, 0.0
        torque, moment, force, rate, bend = table.T.reshape(5, *angles.shape)
        phi = np.asarray(self.mechanism.follower_angle(engaged), dtype=float)
        return IndexState(
            theta=angles, phi=phi, phi_dot=rate, phi_ddot=bend, torque=torque,
            contact_moment=moment, contact_force=force, deflection=self._deflection(angles),
        )  # fmt: skip

    def _deflection(self, theta: FloatArray) -> FloatArray:
        """Angle of the load less that of the wheel at driver angles [rad]; 0 on a rigid shaft."""
        if not self.load_frequency:
            return np.zeros(theta.shape)
        order = np.argsort(theta, axis=None)
        swing = 2.0 * math.pi * self.load_frequency / self.speed
        found = np.empty(theta.size)
        found[order] = deflections(
            self._scene.path, self._edges, swing, float(self.load_damping), theta.reshape(-1)[order]
        )
        return found.reshape(theta.shape)


def index(
    mechanism: Mechanism,
    speed: float,
    load_torque: float = 0.0,
    *,
    follower_inertia: float,
    efficiency: float = 1.0,
    friction: float = 0.0,
    **settings: Any,
) -> IndexingDrive:
    """An indexing drive at constant driver speed: times, torque, power, forces, impacts, ringing.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry, for example `Geneva(slots=6, pins=1, crank_radius=0.05)`. A `pin_radius`, a
        `roller_radius` and a `clearance` act; forces need the crank radius.
    speed : float
        Driver speed [rad/s], > 0.
    load_torque : float
        Torque that opposes the follower [N m], >= 0. A `load_curve`, as that of `Escapement`, adds
        what it has in the first step: a weight may be in another place in the next one.
    follower_inertia : float
        Follower and everything that turns with it [kg m^2], > 0.
    efficiency, friction : float
        As for `drive_torque`.
    **settings
        Bearings and drag as for `Escapement`; and `pressure_pin_radius`, `pin_length`, `pin_gap`
        [m], `pin_material`, `wheel_material` and `pressure_limit` [Pa] for the stresses of the
        pin, `load_frequency` [Hz], `load_damping` and `load_tolerance` [rad] for a load on an
        elastic shaft, `locking_radius` [m], `locking_friction` and `locking_angle` [rad].

    Returns
    -------
    IndexingDrive
        Figures are computed when they are first asked for. What cannot be given is NaN.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.

    The driver's speed is constant, bodies are rigid but for the load's shaft, and impacts are
    plastic and without friction. Sources: Filemon (1960) for torque and reversals; Hertz's line
    contact for the pressure.
    """
    return IndexingDrive(
        mechanism, speed, load_torque, follower_inertia, efficiency, friction, **settings
    )
