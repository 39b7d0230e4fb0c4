"""Tables for people, JSON and CSV for programs."""

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any


def as_json(record: Mapping[str, Any]) -> str:
    """One JSON object; a number that is not finite becomes null."""
    return json.dumps(plain(record), indent=2, allow_nan=False) + "\n"


def as_csv(rows: Iterable[Sequence[Any]]) -> str:
    """One line a row; None becomes an empty field."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def plain(value: Any) -> Any:
    """`value` as types that JSON has, with None for NaN and infinity."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # a scalar or an array of NumPy
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def print_values(rows: Iterable[tuple[str, Any, str]]) -> None:
    """Print name, value and unit, one row each."""
    shown = [(name, show(value), unit) for name, value, unit in rows]
    # neither a pure number nor an empty list has a unit
    lines = [(name, it, "" if unit == "1" or it == "none" else unit) for name, it, unit in shown]
    wide = max(len(name) for name, _, _ in lines)
    far = max((len(value) for _, value, unit in lines if unit), default=0)
    for name, value, unit in lines:
        print(f"{name:<{wide}}  {value:<{far}}  {unit}".rstrip())


def print_columns(header: Iterable[Sequence[str]], rows: Iterable[Sequence[Any]]) -> None:
    """Print right-aligned columns under a header of one or more lines."""
    cells = [*map(list, header), *([show(value) for value in row] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        print(
            "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        )


def show(value: Any) -> str:
    """A value in a table: six significant figures, or a dash where there is none."""
    value = plain(value)
    if value is None:
        return "-"
    if isinstance(value, list):
        return ", ".join(map(show, value)) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def words(key: str) -> str:
    """A JSON key as words, without its unit, which has a column of its own in tables."""
    return key.removesuffix("_deg").replace("_", " ")
