"""What commands have in common on the way out: JSON, tables, units, notes."""

import csv
import io
import json
import math
import sys
from collections.abc import Iterable, Sequence
from typing import Any

from escapement.units import factor

_NOT_GIVEN = {
    "stations": "R2/R1 is no fraction with a denominator of at most 1000, so the output never "
    "stops in the same direction again",
    "critical_friction": "a mesh has no Painleve limit",
}


def as_json(record: dict[str, Any]) -> str:
    """One object; what is not a finite number is null."""
    return json.dumps(plain(record), indent=2, allow_nan=False) + "\n"


def as_csv(rows: Iterable[Sequence[Any]]) -> str:
    """A line a row; what does not exist is empty."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def print_json(record: dict[str, Any]) -> None:
    """One object on stdout."""
    print(as_json(record), end="")


def plain(value: Any) -> Any:
    """`value` in JSON's own types, NaN and infinity as None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # NumPy's scalars and arrays
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


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


def print_values(rows: Iterable[tuple[str, Any, str]]) -> None:
    """Name, value and unit, a row each."""
    lines = [(name, show(value), "" if unit == "1" else unit) for name, value, unit in rows]
    wide = max(len(name) for name, _, _ in lines)
    far = max(len(value) for _, value, unit in lines if unit)
    for name, value, unit in lines:
        print(f"{name:<{wide}}  {value:<{far}}  {unit}".rstrip())


def print_columns(header: Iterable[Sequence[str]], rows: Iterable[Sequence[Any]]) -> None:
    """A table with right-aligned columns under a header of one or more lines."""
    cells = [*map(list, header), *([show(value) for value in row] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        print(
            "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        )


def show(value: Any) -> str:
    """A value as a reader wants it: six figures, a dash for what does not exist."""
    value = plain(value)
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def words(key: str) -> str:
    """A JSON key as a table shows it; the unit has a column of its own."""
    return key.removesuffix("_deg").replace("_", " ")


def note(message: str) -> None:
    """A line on stderr."""
    print(f"escapement: {message}", file=sys.stderr)
