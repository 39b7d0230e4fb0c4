"""Results as text: CSV files, and tables a terminal can show."""

import csv
import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from escapement.files.atomic import replace_file

Rows = Sequence[Any]
"""Named tuples of one kind."""


def as_csv(rows: Rows) -> str:
    """A header and a line per row; what does not exist is an empty field."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(rows[0]._fields)
    writer.writerows([_short(value) for value in row] for row in rows)
    return text.getvalue()


def write_csv(path: Path, rows: Rows) -> Path:
    """Replace `path` by the rows as CSV."""
    replace_file(path, [as_csv(rows).encode()])
    return path


def aligned(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table with names to the left and numbers to the right."""
    cells = [list(header), *([_shown(value) for value in row] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = []
    for row in cells:
        first, *rest = zip(row, widths, strict=True)
        line = first[0].ljust(first[1])
        lines.append("  ".join([line, *(cell.rjust(width) for cell, width in rest)]).rstrip())
    return "\n".join(lines) + "\n"


def _short(value: Any) -> Any:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return value


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return "-" if math.isnan(value) else f"{value:.3g}"
    return str(value)
