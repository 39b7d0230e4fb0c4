"""What is given of an indexing drive: a mechanism at constant driver speed, and its load."""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from escapement.base import validate
from escapement.base.lazy import Lazy
from escapement.base.quantity import Declared, like, quantity
from escapement.mechanisms.protocol import Mechanism, checked
from escapement.mechanisms.wheel_checks import check_lengths
from escapement.model.checks import check_contact, check_load, check_losses, check_pin, refuse_idle
from escapement.model.escapement import STRESSES, Escapement, Inertia

if TYPE_CHECKING:
    import numpy as np
else:
    np = Lazy("numpy")

_HAIR = 1e-9  # rad, by which rounding may lengthen a dwell
_LOAD, _LOCK = "Load on an elastic shaft", "Locking disc"
_SAMPLES = 721  # of a measured table, among which its greatest scatter is looked for


def _same(name: str) -> Any:
    """A number as an escapement has it, 0 unless it is given."""
    return field(default=0.0, metadata=like(Escapement, name))


def _length(what: str, **rule: Any) -> dict[str, Any]:
    return quantity(what, "length", remedy="give the length", **rule)


def refuse_with_curve(locking_radius: Any) -> None:
    """Refuse what a load that changes with the angle leaves without a formula."""
    if np.any(locking_radius):
        rule, remedy = "0 with a load that changes", "give a constant load_torque"
        raise validate.fail("locking_radius", rule, locking_radius, remedy)


@dataclass(frozen=True, repr=False)
class IndexCase(Declared):
    """A mechanism whose driver turns at a constant speed; see `indexing.index` for its numbers."""

    mechanism: Mechanism
    speed: float = field(metadata=quantity(
        "constant driver speed", "speed", exclusive=True, remedy="give the driver speed"
    ))  # fmt: skip
    load_torque: float = field(metadata=like(Escapement, "load_torque"))
    follower_inertia: float = field(metadata=like(Inertia, "follower_inertia"))
    efficiency: float = field(metadata=quantity(
        "efficiency of the drive, in (0, 1]", exclusive=True, maximum=1.0, default=1.0,
        metavar="E", remedy="give the share of the drive's work that arrives, 1 for all of it"
    ))  # fmt: skip
    friction: float = field(metadata=like(Escapement, "friction"))
    load_curve: Any = field(default=None, metadata=like(Escapement, "load_curve"))
    driver_bearing_friction: float = _same("driver_bearing_friction")
    driver_bearing_radius: float = _same("driver_bearing_radius")
    follower_bearing_friction: float = _same("follower_bearing_friction")
    follower_bearing_radius: float = _same("follower_bearing_radius")
    driver_bearing_torque: float = _same("driver_bearing_torque")
    driver_drag: float = _same("driver_drag")
    follower_drag: float = _same("follower_drag")
    driver_viscous: float = _same("driver_viscous")
    follower_viscous: float = _same("follower_viscous")
    pressure_pin_radius: float = _same("pressure_pin_radius")
    pin_length: float = _same("pin_length")
    pin_gap: float = _same("pin_gap")
    pin_material: Any = field(default="steel", metadata=like(Escapement, "pin_material"))
    wheel_material: Any = field(default="steel", metadata=like(Escapement, "wheel_material"))
    pressure_limit: float = field(default=0.0, metadata=quantity(
        "permitted pressure between pin and slot", "pressure", group=STRESSES, needs="pin_length",
        remedy="give the pressure, 0 for none",
    ))  # fmt: skip
    running_time: float = field(default=0.0, metadata=quantity(
        "time for which the drive runs, for the number of load cycles", "time", group=STRESSES,
        slotted=True, instead="efficiency", remedy="give the time, 0 for none",
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
        "radius of the locking disc", group=_LOCK, needs="locking_angle"
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
        self.check_fields()
        wheel: Any = checked(self.mechanism)
        check_losses(self, wheel.path.meshed)
        refuse_idle(self)
        check_lengths(vars(self), wheel.crank_radius, wheel.plain_crank)
        check_contact("rigid" if wheel.clearance else "", wheel, vars(self))
        check_load(self)
        if self.load_curve is not None:
            refuse_with_curve(self.locking_radius)
        if not wheel.takes_clearance and self.locking_radius:
            rule = "0 for a mechanism that is not a Geneva wheel"
            raise validate.fail("locking_radius", rule, self.locking_radius, "leave it out")
        if (value := self.locking_radius) and not wheel.lengths["crank_radius"]:
            rule, remedy = "0 for a mechanism without a length", "give the crank radius"
            raise validate.fail("locking_radius", rule, value, remedy)
        check_pin(vars(self), wheel)
        if wheel.cell_angle > wheel.breaks[-1] - wheel.breaks[0] + _HAIR:
            return
        for name, value in (
            ("clearance", wheel.clearance), ("load_frequency", self.load_frequency)
        ):  # fmt: skip
            if value:
                rule = "0 where the follower never rests, so that no index begins from rest"
                raise validate.fail(name, rule, value, "give fewer pins, or simulate the motion")

    @property
    def inertial(self) -> float:
        """Inertia torque at unit follower acceleration function, I_f omega^2 [N m]."""
        return self.follower_inertia * self.speed * self.speed

    @property
    def half(self) -> float:
        """Driver angle where the first half of the engagement ends: dead centre [rad].

        For a table, or if angles are not counted from dead centre, it is the middle of the cell.
        """
        entry, exit_ = self.mechanism.breaks[0], self.mechanism.breaks[-1]
        centred = entry < 0.0 < exit_ and not self.mechanism.path.table
        return 0.0 if centred else 0.5 * (entry + exit_)

    @property
    def moment_deviation(self) -> float:
        """Greatest standard deviation of the contact moment, from a measured table's scatter [N m].

        0 for any other mechanism. If the moment between two reversals stays within two or three
        of these, the reversals may be due to the scatter.
        """
        mechanism = self.mechanism
        if mechanism.noise == 0.0:
            return 0.0
        theta = np.linspace(mechanism.breaks[0], mechanism.breaks[-1], _SAMPLES)
        return self.inertial * float(mechanism.deviation(theta).dg.max())
