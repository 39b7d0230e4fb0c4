"""Tables for people, JSON and CSV for programs."""

import csv
import io
import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any, ClassVar


def as_json(record: Mapping[str, Any]) -> str:
    """One JSON object; a number that is not finite becomes null."""
    return json.dumps(plain(record), indent=2, allow_nan=False) + "\n"


def as_csv(rows: Iterable[Sequence[Any]]) -> str:
    """One line a row; None becomes an empty field."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def csv_lines(columns: Iterable[Any]) -> bytes:
    """Lines of a table of numbers, given as arrays; each text reads as exactly its number."""
    cells = [map(repr, column.tolist()) for column in columns]
    return "".join(",".join(row) + "\n" for row in zip(*cells, strict=True)).encode()


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
    # an empty list has no unit
    lines = [(name, it, "" if it == "none" else unit) for name, it, unit in shown]
    wide = max(len(name) for name, _, _ in lines)
    far = max((len(value) for _, value, unit in lines if unit), default=0)
    for name, value, unit in lines:
        print(f"{name:<{wide}}  {value:<{far}}  {unit}".rstrip())


def print_columns(header: Iterable[Sequence[str]], rows: Iterable[Sequence[Any]]) -> None:
    """Print right-aligned columns under a header of one or more lines."""
    cells = [*map(list, header), *([show(value) for value in row] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        padded = (cell.rjust(width) for cell, width in zip(row, widths, strict=True))
        print("  ".join(padded).rstrip())


def show(value: Any, digits: int = 6) -> str:
    """A value in a table, to some significant figures, or a dash where there is none."""
    value = plain(value)
    if isinstance(value, list):
        return ", ".join(show(one, digits) for one in value) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None:
        return "-"
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def words(key: str) -> str:
    """A JSON key as words, without its unit, which has a column of its own in tables."""
    return key.removesuffix("_deg").replace("_", " ")


_FEW = 4
"""Greatest number of items of a list that are shown each."""


class Shown:
    """Base of dataclasses that print themselves in short, with units, and as a table in notebooks.

    They turn the repr of `dataclass` off.
    """

    _units: ClassVar[Mapping[str, str]] = {}
    """Units of those fields that have one."""
    _most: ClassVar[int] = 300
    """Characters of the repr."""

    def _shown(self) -> Iterable[tuple[str, Any, str]]:
        """Name, value and unit of whatever is shown."""
        names = [field.name for field in fields(self) if field.repr]  # type: ignore[arg-type]
        return [(name, getattr(self, name), self._units.get(name, "")) for name in names]

    def __repr__(self) -> str:
        rows = [f"{name}={_brief(value)} {unit}".rstrip() for name, value, unit in self._shown()]
        text = f"{type(self).__name__}({', '.join(rows)})"
        return text if len(text) <= self._most else text[: self._most - 4] + "...)"

    def _repr_html_(self) -> str:
        from html import escape

        rows = (
            f"<tr><th>{escape(words(name))}</th><td>{escape(f'{_brief(value)} {unit}')}</td></tr>"
            for name, value, unit in self._shown()
        )
        return f"<table><caption>{type(self).__name__}</caption>{''.join(rows)}</table>"


def _brief(value: Any) -> str:
    """A number to six figures, a status by its label, an array by its size and range.

    Of a long list and of a dictionary, the number of items and the names.
    """
    if getattr(value, "ndim", None) == 0:  # a number of NumPy
        value = value.item()
    if getattr(value, "size", 0):
        if value.dtype == bool:
            return f"{value.sum()} of {value.size}"
        if value.dtype.kind == "U":
            return ", ".join(f"{n} {word}" for word, n in Counter(value.tolist()).items())
        known = value[value == value]  # NaN is not equal to itself
        ends = f" from {known.min():.6g} to {known.max():.6g}" if known.size else " without a value"
        return f"{value.size}{ends}"
    if isinstance(value, Mapping):
        return ", ".join(map(str, value)) or "none"
    if isinstance(value, list | tuple) and len(value) > _FEW:
        return f"{len(value)} items"
    return f"{value:.6g}" if isinstance(value, float) else str(getattr(value, "label", value))
