"""An indexing drive as the engineer of a machine meets it: all figures at constant driver speed.

Times, speeds, torque, power, forces, stresses of the pin, blows in a slot with clearance, the
ringing of the load after the index, and the torque of the locking disc. Each is computed when it is
first asked for.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import like, quantity, setting
from escapement.constant_speed import Case
from escapement.constant_speed.contact import within_cell
from escapement.constant_speed.cycle_figures import CycleFigures, contact_states, cycle_figures
from escapement.constant_speed.knock import NOWHERE, Knock, knock
from escapement.constant_speed.ringing import Ringing, deflections, ringing
from escapement.mechanisms.path import smooth_intervals
from escapement.mechanisms.protocol import FloatArray, Mechanism
from escapement.mechanisms.slotted import slide_edges
from escapement.model.escapement import Escapement, Inertia
from escapement.model.materials import (
    MATERIALS,
    MaterialSetting,
    contact_modulus,
    hertz_pressure,
    material,
    pin_bending,
    pin_shear,
    radius_for,
)
from escapement.model.scene import Scene, scene_tuple

_NAN = math.nan
_PIN, _LOAD, _LOCK = "Stresses of the pin", "Load on an elastic shaft", "Locking disc"
_RESISTING = (
    *("driver_bearing_friction", "driver_bearing_radius", "follower_bearing_friction"),
    *("follower_bearing_radius", "driver_bearing_torque", "driver_drag", "follower_drag"),
    *("driver_viscous", "follower_viscous"),
)
_MATERIAL = f"a name ({', '.join(MATERIALS)}), or modulus in Pa and Poisson's ratio"


def _material(of: str) -> dict[str, Any]:
    return setting(MaterialSetting(
        long_name=f"material of the {of}, {_MATERIAL}", metavar="NAME", group=_PIN,
        remedy="name a material, or give two numbers, 206e9,0.3", needs="pin_length",
    ))  # fmt: skip


def _length(what: str, **rule: Any) -> dict[str, Any]:
    return quantity(what, "length", remedy="give the length", **rule)


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
class IndexingDrive(Case):
    """A mechanism whose driver turns at a constant speed; see `index` for its numbers."""

    driver_bearing_friction: float = field(
        default=0.0, metadata=like(Escapement, "driver_bearing_friction")
    )
    driver_bearing_radius: float = field(
        default=0.0, metadata=like(Escapement, "driver_bearing_radius")
    )
    follower_bearing_friction: float = field(
        default=0.0, metadata=like(Escapement, "follower_bearing_friction")
    )
    follower_bearing_radius: float = field(
        default=0.0, metadata=like(Escapement, "follower_bearing_radius")
    )
    driver_bearing_torque: float = field(
        default=0.0, metadata=like(Escapement, "driver_bearing_torque")
    )
    driver_drag: float = field(default=0.0, metadata=like(Escapement, "driver_drag"))
    follower_drag: float = field(default=0.0, metadata=like(Escapement, "follower_drag"))
    driver_viscous: float = field(default=0.0, metadata=like(Escapement, "driver_viscous"))
    follower_viscous: float = field(default=0.0, metadata=like(Escapement, "follower_viscous"))
    pressure_pin_radius: float = field(default=0.0, metadata=_length(
        "radius of the pin for its stresses alone", group=_PIN, needs="pin_length",
        note=", by default that of the pin or roller",
    ))  # fmt: skip
    pin_length: float = field(default=0.0, metadata=_length(
        "length of the pin in its slot", group=_PIN
    ))  # fmt: skip
    pin_gap: float = field(default=0.0, metadata=_length(
        "gap between the driver and the slot, for the bending of the pin", group=_PIN,
        needs="pin_length",
    ))  # fmt: skip
    pin_material: Any = field(default="steel", metadata=_material("pin"))
    wheel_material: Any = field(default="steel", metadata=_material("wheel"))
    pressure_limit: float = field(default=0.0, metadata=quantity(
        "permitted pressure between pin and slot", "pressure", group=_PIN, needs="pin_length",
        remedy="give the pressure, 0 for none",
    ))  # fmt: skip
    load_frequency: float = field(default=0.0, metadata=quantity(
        "natural frequency of the load on its shaft, the wheel held", "frequency", metavar="HZ",
        group=_LOAD, remedy="give the frequency, 0 for a rigid shaft",
    ))  # fmt: skip
    load_damping: float = field(default=0.0, metadata=quantity(
        "damping of that vibration, as a share of critical damping", maximum=1.0, below=True,
        metavar="ZETA", group=_LOAD, needs="load_frequency", remedy="give a share, 0 for none",
    ))  # fmt: skip
    load_tolerance: float = field(default=1e-3, metadata=quantity(
        "angle within which the load must come to rest", "angle", exclusive=True, metavar="A",
        group=_LOAD, needs="load_frequency", remedy="give the angle",
    ))  # fmt: skip
    locking_radius: float = field(default=0.0, metadata=_length(
        "radius of the locking disc", group=_LOCK
    ))  # fmt: skip
    locking_friction: float = field(default=0.0, metadata=quantity(
        "coefficient of friction on the locking disc", metavar="MU", group=_LOCK,
        needs="locking_radius", remedy="give a coefficient of friction",
    ))  # fmt: skip
    locking_angle: float = field(default=0.0, metadata=quantity(
        "angle at the driver's axis from the line of centres to where the disc carries the load",
        "angle", metavar="A", group=_LOCK, needs="locking_radius", maximum=math.pi / 2,
        remedy="give the angle",
    ))  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if callable(self.load_torque):
            raise InvalidValue(
                "load_torque must be a number for index, got a function; drive_torque takes it"
            )
        self._timer  # noqa: B018 - checks the numbers that it shares with an escapement

    # --- the drive in units of I_f, I_f W^2 and 1/W -----------------------------------------

    @cached_property
    def _timer(self) -> Escapement:
        """An escapement of which natural units are those in which the driver's speed is one."""
        numbers = {name: getattr(self, name) for name in _RESISTING if getattr(self, name)}
        return Escapement(
            self.mechanism, Inertia(self.follower_inertia, self.follower_inertia),
            torque=self.inertial, friction=self.friction, load_torque=self.load_torque, **numbers,
        )  # fmt: skip

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
    def _found(self) -> tuple[CycleFigures, FloatArray]:
        result: tuple[CycleFigures, FloatArray] = cycle_figures(
            scene_tuple(self._scene), self._edges, self.half, float(self.efficiency)
        )
        return result

    @property
    def _cycle(self) -> CycleFigures:
        return self._found[0]

    @property
    def _length(self) -> float:
        """The crank radius [m]; NaN where there is none."""
        return _NAN if self.mechanism.crank_radius is None else float(self.mechanism.crank_radius)

    # --- times and motion of the table ------------------------------------------------------

    @property
    def cycle_time(self) -> float:
        """Time from one pin entry to the next [s]."""
        return self.mechanism.cell_angle / self.speed

    @property
    def index_time(self) -> float:
        """Time in which the follower moves [s]."""
        return self.mechanism.motion_ratio * self.cycle_time

    @property
    def dwell_time(self) -> float:
        """Time in which it rests [s]."""
        return (1.0 - self.mechanism.motion_ratio) * self.cycle_time

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
        return work / self.mechanism.cell_angle

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
        return max(self.mechanism.cell_angle - self._index_angle, 0.0)

    @property
    def power_max(self) -> float:
        """Greatest power of the drive [W]."""
        return self.torque_max * self.speed

    @property
    def power_mean(self) -> float:
        """Mean power over the whole cycle [W]."""
        return self.torque_mean_cycle * self.speed

    @property
    def reversals(self) -> FloatArray:
        """Driver angles from dead centre where the pin changes walls [rad]."""
        return self._found[1]

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

    # --- blows ------------------------------------------------------------------------------

    @cached_property
    def knock(self) -> Knock | None:
        """Blows in the units of `knock.Knock`; None where the pins have no clearance."""
        clearance, scene = self.mechanism.clearance, self._scene
        if not clearance:
            return None
        half = 0.5 * clearance / self._length
        found: Knock = knock(scene.path.numbers, half, scene.load, scene.edges[0], scene.edges[-1])
        return found

    def _blow(self, name: str, factor: float = 1.0) -> float:
        return _NAN if self.knock is None else factor * getattr(self.knock, name)

    @property
    def entry_impact_angle(self) -> float:
        """Where the pin meets the front wall, from dead centre [rad]; NaN without clearance."""
        return self._blow("entry_angle")

    @property
    def entry_impact_speed(self) -> float:
        """Speed at which it does [m/s]."""
        return self._blow("entry_distance", self._length * self.speed) * self._blow("entry_speed")

    @property
    def entry_impact_energy(self) -> float:
        """Energy of the follower that the blow brings to speed, and as much is lost [J]."""
        return 0.5 * self.inertial * self._blow("entry_speed") ** 2

    @property
    def lift_off_angle(self) -> float:
        """Where the pin leaves the front wall, from dead centre [rad]."""
        return self._blow("lift_off")

    @property
    def reversal_impact_angle(self) -> float:
        """Where it meets a wall again; NaN if not before the exit [rad]."""
        return self._blow("reversal_angle")

    @property
    def reversal_flight_time(self) -> float:
        """Time between the two [s]."""
        return (self.reversal_impact_angle - self.lift_off_angle) / self.speed

    @property
    def reversal_impact_speed(self) -> float:
        """Speed at which it meets the wall [m/s]."""
        away = self._blow("reversal_distance", self._length * self.speed)
        return away * self._blow("reversal_speed")

    @property
    def reversal_impact_energy(self) -> float:
        """Energy lost in that blow if it is plastic [J]."""
        return 0.5 * self.inertial * self._blow("reversal_speed") ** 2

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
        return IndexState(angles, phi, rate, bend, torque, moment, force, self._deflection(angles))

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
        return self.locking_friction * self.load_torque / lever * self.locking_radius


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
    """An indexing drive at constant driver speed: times, torque, power, forces, blows, ringing.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry, for example `Geneva(slots=6, pins=1, crank_radius=0.05)`. A `pin_radius`, a
        `roller_radius` and a `clearance` act; forces need the crank radius.
    speed : float
        Driver speed [rad/s], > 0.
    load_torque : float
        Torque that opposes the follower [N m], >= 0.
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

    The driver's speed is constant, bodies are rigid but for the load's shaft, and blows are plastic
    and without friction. Sources: Filemon (1960) for torque and reversals; Hertz' line contact.
    """
    return IndexingDrive(
        mechanism, speed, load_torque, follower_inertia, efficiency, friction, **settings
    )
