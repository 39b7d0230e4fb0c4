"""An electric motor as the drive: its torque falls in a straight line over its speed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from escapement.base import units, validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Numbers, Quantity
from escapement.base.text import Shown


@dataclass(frozen=True, repr=False)
class Motor(Shown):
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

    stall_torque: float
    no_load_speed: float

    _units = {"stall_torque": "N m", "no_load_speed": "rad/s"}  # noqa: RUF012

    def __post_init__(self) -> None:
        for name, remedy in (
            ("stall_torque", "give the torque at rest in N m"),
            ("no_load_speed", "give the speed without a load in rad/s"),
        ):
            vars(self)[name] = validate.positive(name, getattr(self, name), remedy)

    def torque(self, speed: float) -> float:
        """Torque at a speed of the motor [N m]."""
        return self.stall_torque * (1.0 - speed / self.no_load_speed)


_NUMBERS = (
    Quantity(
        long_name="stall torque", unit="torque", exclusive=True, remedy="give the torque at rest"
    ),
    Quantity(
        long_name="no-load speed", unit="speed", exclusive=True,
        remedy="give the speed without a load",
    ),
)  # fmt: skip


class MotorSetting(Numbers):
    """A `Motor`, which files and the command line give by its two numbers."""

    def check(self, label: str, value: Any) -> Motor:
        """`value` as the motor that it is."""
        if not isinstance(value, Motor):
            raise validate.fail(label, "a Motor", value, "give Motor(stall_torque, no_load_speed)")
        return value

    def read(self, label: str, value: Any) -> tuple[float, ...]:
        """Stall torque and no-load speed, in the units of the system."""
        if isinstance(value, str) or not hasattr(value, "__len__") or len(value) != len(_NUMBERS):
            shown = ",".join(map(str, value)) if isinstance(value, list) else value
            rule = "stall torque and no-load speed, with a comma between them"
            raise InvalidValue(f"{label} must be {rule}, got {shown}; give for example 2,300")
        pairs = zip(_NUMBERS, value, strict=True)
        return tuple(
            replace(entry, system=self.system).read(f"{label}, {entry.long_name},", item)
            for entry, item in pairs
        )

    def to_si(self, values: Any) -> Motor:
        """The motor with these numbers."""
        torque, speed = (
            value * units.factor(entry.unit, self.system)
            for value, entry in zip(values, _NUMBERS, strict=True)
        )
        return Motor(torque, speed)


MOTOR = MotorSetting(
    name="motor", long_name="motor of which the torque falls in a straight line over its speed",
    note=", by stall torque and no-load speed", metavar="STALL,NO-LOAD",
    remedy="give stall torque and no-load speed",
)  # fmt: skip
"""A motor as an option of the command line."""
