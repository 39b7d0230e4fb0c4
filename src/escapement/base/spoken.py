"""The system of units that the user chose: messages, figures and reports give numbers in it."""

from escapement.base.units import SYSTEMS, factor, printed

_system = SYSTEMS[0]


def speak(system: str) -> None:
    """Choose the system for messages, figures and reports; the command line takes the user's."""
    global _system
    _system = system


def spoken() -> str:
    """The system of messages, figures and reports; SI unless the command line chose another."""
    return _system


class Spoken(str):
    """A number with its unit, as messages give it."""

    __repr__ = str.__str__


def as_spoken(value: float, quantity: str, figures: int = 6) -> Spoken:
    """An SI value with its unit in the system that messages speak: "0.002 m", "0.0787402 in"."""
    unit = printed(quantity, _system)
    return Spoken(f"{value / factor(quantity, _system):.{figures}g} {unit}".rstrip())


def spoken_length(value: float) -> Spoken:
    """As `as_spoken`, of a length."""
    return as_spoken(value, "length")


def drawn_unit() -> tuple[float, str]:
    """The unit of lengths on drawings [m] and its name: millimetres, or inches."""
    return (factor("length", _system), "in") if _system == SYSTEMS[1] else (1e-3, "mm")


def on_drawing(length: float) -> Spoken:
    """A length as drawings give it: "2 mm", "0.0787402 in"."""
    size, unit = drawn_unit()
    return Spoken(f"{length / size:.6g} {unit}")
