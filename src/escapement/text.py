"""Tables for people, JSON and CSV for programs, and headings of columns of angles."""

import csv
import io
import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

UNITS = {"deg": 2.0 * math.pi / 360.0, "rad": 1.0}
"""Units of angles, in rad."""
NAMES = {
    "input": ("input", "in", "driver", "theta", "phi1"),
    "output": ("output", "out", "follower", "phi", "phi3"),
}
"""Headings by which the columns of driver and follower are known."""
_SPELLINGS = {
    "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg",
    "rad": "rad", "radian": "rad", "radians": "rad",
}  # fmt: skip
FOREIGN = re.compile(r"(?:[mµμu]rad|grad|gon|turn|rev|revolution|arcmin|arcsec)s?", re.IGNORECASE)
"""Units of angles that are recognised in order to refuse them."""


def name_and_unit(field: str) -> tuple[str, str | None]:
    """Name of a column in small letters, and its unit: of `UNITS`, `FOREIGN`, or None."""
    *words, last = re.findall(r"[^\W_]+|°", field.lower()) or [""]
    unit = _SPELLINGS.get(last) or (last if FOREIGN.fullmatch(last) else None)
    return "".join(words if unit else [*words, last]), unit


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
    lines = [(name, show(value), "" if unit == "1" else unit) for name, value, unit in rows]
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
