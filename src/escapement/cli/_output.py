"""What commands have in common on the way out: JSON, tables, units, notes."""

import sys
from typing import Any

from escapement.text import as_json, plain
from escapement.units import factor

_NOT_GIVEN = {
    "stations": "R2/R1 is no fraction with a denominator of at most 1000, so the output never "
    "stops in the same direction again",
    "critical_friction": "a mesh has no Painleve limit",
}


def print_json(record: dict[str, Any]) -> None:
    """One object on stdout."""
    print(as_json(record), end="")


def not_given(record: dict[str, Any]) -> list[str]:
    """Why keys hold nothing, of those for which there is but one reason."""
    return [
        f"{key} is not given: {why}"
        for key, why in _NOT_GIVEN.items()
        if key in record and plain(record[key]) is None
    ]


def in_units(value: float, quantity: str, system: str) -> float:
    """An SI value in the user's units."""
    return value / factor(quantity, system)


def note(message: str) -> None:
    """A line on stderr."""
    print(f"escapement: {message}", file=sys.stderr)
