"""An indexing drive as the engineer of a machine meets it: all figures at constant driver speed.

Times, speeds, torque, power, forces, stresses of the pin, impacts in a slot with clearance, the
ringing of the load after the index, and the torque of the locking disc. Each is computed when it is
first asked for.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.constant_speed.cycle_figures import (
    CycleFigures,
    contact_states,
    cycle_figures,
    join_steps,
)
from escapement.constant_speed.index_case import IndexCase
from escapement.constant_speed.index_loads import IndexLoads
from escapement.constant_speed.knock import NO_KNOCK, Knock, knock
from escapement.constant_speed.ringing import NO_RINGING, Ringing, deflections, ringing
from escapement.dynamics.needs import CONSTANT, NO_CURVE
from escapement.mechanisms.protocol import FloatArray, Mechanism
from escapement.model.escapement import Escapement, Inertia
from escapement.model.motor import Motor
from escapement.model.scene import Scene, packed
from escapement.model.train import Train


class IndexState(NamedTuple):
    """An indexing drive at driver angles `theta`: arrays of one shape.

    theta, phi : driver and follower angle from dead centre [rad].
    phi_dot, phi_ddot : speed and acceleration of the follower [rad/s, rad/s^2].
    torque : of the drive; below zero the follower drives [N m].
    contact_moment : moment of the contact on the follower; its sign is the wall [N m].
    contact_force : magnitude of the force on the pin [N]; NaN without a crank radius.
    deflection : angle of the load minus that of the wheel [rad]; 0 on a rigid shaft.
    """

    theta: FloatArray
    phi: FloatArray
    phi_dot: FloatArray
    phi_ddot: FloatArray
    torque: FloatArray
    contact_moment: FloatArray
    contact_force: FloatArray
    deflection: FloatArray


_HAIR = 1e-12  # share of a cell by which rounding may put an angle beyond an end
RESISTING = (
    *("driver_bearing_friction", "driver_bearing_radius", "follower_bearing_friction"),
    *("follower_bearing_radius", "driver_bearing_torque", "driver_drag", "follower_drag"),
    *("driver_viscous", "follower_viscous"),
)
"""Numbers that an indexing drive has in common with an escapement, besides friction and load."""


@dataclass(frozen=True, repr=False)
class IndexingDrive(IndexLoads, IndexCase):
    """A mechanism whose driver turns at a constant speed; see `index` for its numbers."""

    # --- what is computed, in units of I_f, I_f W^2 and 1/W ---------------------------------

    @cached_property
    def _scenes(self) -> tuple[Scene, ...]:
        """Of an escapement of which natural units are those in which the driver's speed is one.

        There is one for each index after which the load repeats.
        """
        pair, torque, none = self.mechanism.pairs[0], np.array(CONSTANT), np.array(NO_CURVE)
        numbers: Any = {name: float(value) for name, value in self.natural_numbers().items()}
        scene = Scene(*pair[:3], torque, 0.0, none, none, **numbers)
        if self.load_curve is None:
            return (scene,)
        from escapement.model.load_cells import load_cells

        # torque is that of pins on their walls, on which a load is one over the driver angle
        return tuple(
            scene._replace(edges=cell.edges, load_curve=cell.in_units(self.inertial))
            for cell in load_cells(self.load_curve, self.mechanism)
        )

    def driven_by(
        self, motor: Motor, *, driver_inertia: float, gearbox: Train | None = None
    ) -> Escapement:
        """The drive with a motor, which slows down under its load, instead of a constant speed.

        `escapement.terminal` finds its mean speed, its dip and the torque of the motor.

        Parameters
        ----------
        motor : Motor
            Its speed takes the place of that of the drive.
        driver_inertia : float
            Crank and shaft, without the rotor behind a gearbox [kg m^2], > 0.
        gearbox : Train, optional
            As `barrel` of `Escapement`, with the inertia of the rotor. Without one the efficiency
            of the drive is that of a gearbox of ratio 1.

        Raises
        ------
        InvalidValue
            When a number breaks its rule, or the gearbox and the drive both have an efficiency.

        The locking disc is left out.
        """
        if not isinstance(motor, Motor):
            raise validate.fail(
                "motor", "a Motor", motor, "give Motor(stall_torque, no_load_speed)"
            )
        gearbox = gearbox or Train(1.0)
        if self.efficiency != 1.0:
            if gearbox.efficiency != 1.0:
                rule, remedy = "1 with an efficiency of the drive", "leave out one of them"
                raise validate.fail("gearbox efficiency", rule, gearbox.efficiency, remedy)
            gearbox = replace(gearbox, efficiency=self.efficiency)
        train: Any = {} if gearbox == Train(1.0) else {"barrel": gearbox}
        inertia = Inertia(driver_inertia, self.follower_inertia)
        numbers = {name: getattr(self, name) for name in RESISTING if getattr(self, name)}
        return Escapement(
            self.mechanism, inertia, torque=motor, friction=self.friction,
            load_torque=self.load_torque, load_curve=self.load_curve, **numbers, **train,
        )  # fmt: skip

    @property
    def _scene(self) -> Scene:
        return self._scenes[0]

    @property
    def indexes(self) -> int:
        """Indexes after which the load repeats: 1, or those in a turn of the follower."""
        return len(self._scenes)

    @property
    def hardest(self) -> int:
        """Which of its `indexes` needs the greatest torque, from 0."""
        wheel = self.mechanism
        return int((self.torque_max_angle - wheel.breaks[0]) // wheel.cell_angle)

    @cached_property
    def lengths(self) -> dict[str, float]:
        """The lengths of the mechanism [m], 0 where it has none."""
        return self.mechanism.lengths

    @cached_property
    def _found(self) -> tuple[CycleFigures, FloatArray]:
        half, efficiency = self.half, float(self.efficiency)
        found: list[tuple[CycleFigures, FloatArray]]
        found = [cycle_figures(packed(x), x.edges, half, efficiency) for x in self._scenes]
        if len(found) == 1:
            return found[0]
        cell = self.mechanism.cell_angle
        joined = join_steps(np.array([figures for figures, _ in found]), cell)
        reversals = [angles + k * cell for k, (_, angles) in enumerate(found)]
        return CycleFigures(*joined.tolist()), np.concatenate(reversals)

    @cached_property
    def cycle(self) -> CycleFigures:
        """Figures of torque and force in the units of `cycle_figures.CycleFigures`."""
        return self._found[0]

    @property
    def reversals(self) -> FloatArray:
        """Driver angles from dead centre where the pin changes walls [rad]."""
        return self._found[1]

    @cached_property
    def knock(self) -> Knock:
        """Impacts in the units of `knock.Knock`; NaN where the pins have no clearance."""
        if not (clearance := self.mechanism.clearance):
            return NO_KNOCK
        scene = self._scene
        if (load := self.load_curve) is not None:
            from escapement.model.load_cells import over_follower

            load, step = load * (1.0 / self.inertial), float(self.mechanism.follower_step)
            scene = scene._replace(load_curve=over_follower(load, self.indexes, step))
        half = 0.5 * clearance / self.lengths["crank_radius"]
        return Knock(*knock(packed(scene), half, self.indexes))

    @property
    def _swing(self) -> float:
        """Frequency of the load in units of the driver's speed."""
        return 2.0 * math.pi * self.load_frequency / self.speed

    @cached_property
    def ringing(self) -> Ringing:
        """How the load rings, in units of `ringing.Ringing`; NaN on a rigid shaft."""
        if not self.load_frequency:
            return NO_RINGING
        scene = self._scene
        found: Ringing = ringing(scene.path, scene.edges, self._swing, float(self.load_damping))
        return found

    # --- states -----------------------------------------------------------------------------

    def at(self, theta: ArrayLike) -> IndexState:
        """States at driver angles from the first dead centre [rad].

        They lie within one cell, or within those of all `indexes`.

        Raises
        ------
        InvalidValue
            Where an angle is not finite or lies outside the cells.
        """
        angles, wheel = validate.numbers("theta", theta, "give angles"), self.mechanism
        number = np.floor((angles - wheel.breaks[0]) / wheel.cell_angle)
        number = np.clip(number, 0, self.indexes - 1).astype(int)
        within = angles - number * wheel.cell_angle
        engaged, locked = _within_cell(wheel, within)
        flat, which = np.ascontiguousarray(engaged).reshape(-1), number.reshape(-1)
        table = np.empty((flat.size, 5))
        for k, scene in enumerate(self._scenes):
            part = np.empty((np.count_nonzero(which == k), 5))
            contact_states(packed(scene), flat[which == k], float(self.efficiency), part)
            table[which == k] = part
        table[:, :3] *= self.inertial
        table[:, 2] /= self._length
        table[:, 3] *= self.speed
        table[:, 4] *= self.speed**2
        table[locked.reshape(-1)] = self.torque_dwell, 0.0, 0.0 * self._length, 0.0, 0.0
        torque, moment, force, rate, bend = table.T.reshape(5, *angles.shape)
        phi = np.asarray(wheel.follower_angle(engaged), dtype=float)
        phi = phi + number * wheel.follower_step
        return IndexState(
            theta=angles, phi=phi, phi_dot=rate, phi_ddot=bend, torque=torque,
            contact_moment=moment, contact_force=force, deflection=self._deflection(within),
        )  # fmt: skip

    def _deflection(self, theta: FloatArray) -> FloatArray:
        """Angle of the load less that of the wheel at driver angles [rad]; 0 on a rigid shaft."""
        if not self.load_frequency:
            return np.zeros(theta.shape)
        order, scene = np.argsort(theta, axis=None), self._scene
        found, damping = np.empty(theta.size), float(self.load_damping)
        found[order] = deflections(
            scene.path, scene.edges, self._swing, damping, theta.reshape(-1)[order]
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
        to it. If it repeats in a turn of the follower, as that of a weight does, the figures are
        those of all `indexes` of the turn, and angles count from the first dead centre.
    follower_inertia : float
        Follower and everything that turns with it [kg m^2], > 0.
    efficiency : float
        Efficiency of the drive [-], in (0, 1]. Torque is divided by it where the drive works and,
        unlike in Filemon, multiplied where it is driven.
    friction : float
        Coefficient of friction between pin and slot [-], >= 0.
    **settings
        Bearings and drag as for `Escapement`; and `pressure_pin_radius`, `pin_length`, `pin_gap`
        [m], `pin_material`, `wheel_material` and `pressure_limit` [Pa] for the stresses of the
        pin, `running_time` [s] for its load cycles, `load_frequency` [Hz], `load_damping` and
        `load_tolerance` [rad] for a load on an elastic shaft, `locking_radius` [m],
        `locking_friction` and `locking_angle` [rad].

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


def _within_cell(mechanism: Mechanism, theta: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Driver angles, those of the dwell replaced by the exit, and whether each is one of these.

    An angle outside the cell is an error; one that rounding puts beyond an end or the exit counts
    as that.
    """
    entry, exit_ = mechanism.breaks[0], mechanism.breaks[-1]
    end = max(exit_, entry + mechanism.cell_angle)
    hair = _HAIR * (end - entry)
    outside = ~((theta >= entry - hair) & (theta <= end + hair))
    if outside.any():
        raise InvalidValue(
            f"theta must be between pin entry and the end of the cell, {entry!r} to {end!r} "
            f"rad, got {float(theta[outside].flat[0])!r}; count angles from dead centre"
        )
    return np.clip(theta, entry, exit_), theta > exit_ + hair
