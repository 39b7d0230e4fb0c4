"""Numbers in messages, in the system of units that the user chose."""

from escapement.base.units import SYSTEMS, factor, printed

_system = SYSTEMS[0]


def speak(system: str) -> None:
    """Choose the system in which messages give numbers; the command line takes the user's."""
    global _system
    _system = system


class Spoken(str):
    """A number with its unit, as messages give it."""

    __repr__ = str.__str__


def told(value: float, quantity: str) -> Spoken:
    """An SI value with its unit in the system that messages speak: "0.002 m", "0.0787402 in"."""
    unit = printed(quantity, _system)
    return Spoken(f"{value / factor(quantity, _system):.6g} {unit}".rstrip())
