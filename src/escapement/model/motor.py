"""An electric motor as the drive: its torque falls in a straight line over its speed."""

from __future__ import annotations

from dataclasses import dataclass

from escapement.base import validate
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
