"""An electric motor as the drive: its torque falls in a straight line over its speed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from escapement.base import units
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Declared, Numbers, quantities, quantity


@dataclass(frozen=True, repr=False)
class Motor(Declared):
    """A motor with a straight line of torque over speed.

    At the speed W it gives stall_torque (1 - W/no_load_speed). Beyond the no-load speed it brakes.

    Parameters
    ----------
    stall_torque : float
        Torque at rest [N m], > 0.
    no_load_speed : float
        Speed at which it gives no torque [rad/s], > 0.

    Raises
    ------
    InvalidValue
        When a number breaks its rule.

    Notes
    -----
    A motor with permanent magnets at a constant voltage has such a line, and its current is
    proportional to its torque. The inertia of the rotor belongs to the driver, or to the barrel
    of a gearbox. The line is the same as a constant torque with the viscous drag
    stall_torque/no_load_speed.
    """

    stall_torque: float = field(metadata=quantity(
        "stall torque", "torque", exclusive=True, remedy="give the torque at rest"
    ))  # fmt: skip
    no_load_speed: float = field(metadata=quantity(
        "no-load speed", "speed", exclusive=True, remedy="give the speed without a load"
    ))  # fmt: skip

    def __post_init__(self) -> None:
        self.check_fields()

    def torque(self, speed: float) -> float:
        """Torque at a speed of the motor [N m]."""
        return self.stall_torque * (1.0 - speed / self.no_load_speed)


class MotorSetting(Numbers):
    """A `Motor`, which files and the command line give by its two numbers."""

    def read(self, label: str, value: Any) -> tuple[float, ...]:
        """Stall torque and no-load speed, in the units of the system."""
        entries = quantities(Motor).values()
        if isinstance(value, str) or not hasattr(value, "__len__") or len(value) != len(entries):
            shown = ",".join(map(str, value)) if isinstance(value, list) else value
            rule = "stall torque and no-load speed, with a comma between them"
            raise InvalidValue(f"{label} must be {rule}, got {shown}; give for example 2,300")
        return tuple(
            replace(entry, system=self.system).read(f"{label}, {entry.long_name},", item)
            for entry, item in zip(entries, value, strict=True)
        )

    def to_si(self, values: Any) -> Motor:
        """The motor with these numbers."""
        pairs = zip(values, quantities(Motor).values(), strict=True)
        return Motor(*(value * units.factor(entry.unit, self.system) for value, entry in pairs))


MOTOR = MotorSetting(
    name="motor", long_name="motor of which the torque falls in a straight line over its speed",
    note=", by stall torque and no-load speed", metavar="STALL,NO-LOAD",
    remedy="give stall torque and no-load speed",
)  # fmt: skip
"""A motor as an option of the command line."""
