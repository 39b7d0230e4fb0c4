"""What is given of an indexing drive, besides what every drive at constant speed has."""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from escapement.base import validate
from escapement.base.lazy import Lazy
from escapement.base.quantity import like, quantity
from escapement.constant_speed import Case
from escapement.mechanisms.wheel_checks import check_lengths
from escapement.model.checks import check_contact, check_load, check_pin, refuse_idle
from escapement.model.escapement import STRESSES, Escapement

if TYPE_CHECKING:
    import numpy as np
else:
    np = Lazy("numpy")

_HAIR = 1e-9  # rad, by which rounding may lengthen a dwell
_LOAD, _LOCK = "Load on an elastic shaft", "Locking disc"


def _length(what: str, **rule: Any) -> dict[str, Any]:
    return quantity(what, "length", remedy="give the length", **rule)


def refuse_with_curve(locking_radius: Any) -> None:
    """Refuse what a load that changes with the angle leaves without a formula."""
    if np.any(locking_radius):
        rule, remedy = "0 with a load that changes", "give a constant load_torque"
        raise validate.fail("locking_radius", rule, locking_radius, remedy)


@dataclass(frozen=True, repr=False)
class IndexCase(Case):
    """A mechanism whose driver turns at a constant speed; see `indexing.index` for its numbers."""

    load_torque: Any = field(metadata=like(Escapement, "load_torque"))
    load_curve: Any = field(default=None, metadata=like(Escapement, "load_curve"))
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
    pressure_pin_radius: float = field(
        default=0.0, metadata=like(Escapement, "pressure_pin_radius")
    )
    pin_length: float = field(default=0.0, metadata=like(Escapement, "pin_length"))
    pin_gap: float = field(default=0.0, metadata=like(Escapement, "pin_gap"))
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
        super().__post_init__()
        refuse_idle(self)
        wheel: Any = self.mechanism
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
