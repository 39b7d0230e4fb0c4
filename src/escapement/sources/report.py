"""A source's printed numbers and equations beside the true ones, and their presentation.

In every report, table and legend *printed* is the number in the paper, and *true* is the correct
number, computed again. The true value is rounded to the number of printed digits before the two
are compared. Where they differ, rules are tried, from the strictest to the loosest, until one
gives the printed digits.
"""

import csv
import math
import re
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from itertools import groupby
from typing import Any

from escapement.base.text import print_columns

UNEXPLAINED = "unexplained"
WIDTH = 100
"""Characters of a line."""
Record = dict[str, Any]
"""Content of the JSON, or a part of it."""
Table = Sequence[Sequence[Any]]
"""Rows for CSV, a header first."""
Panels = Mapping[str, Callable[[], Any]]
"""File names of figures, without suffix, and the functions that draw them."""


def read_table(source: str, name: str) -> list[dict[str, str]]:
    """Rows of a data file in the folder of a source, by the names of its columns."""
    text = files("escapement.sources").joinpath(source, name).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


# --- numbers ------------------------------------------------------------------------------


def digits(printed: str) -> tuple[float, float]:
    """Value of a printed number and the unit of its last digit: 0.7265, 21.6° or 4°46'.

    1.— stands for a whole number that is right to four decimals. Angles with minutes have
    a value in degrees.
    """
    angle = re.fullmatch(r"(\d+)°(\d+)'", printed)
    if angle:
        return (60 * int(angle[1]) + int(angle[2])) / 60.0, 1.0 / 60.0
    plain = printed.removesuffix("°").replace("—", "0000")
    return float(plain), 10.0 ** -len(plain.partition(".")[2])


def like(printed: str, value: float, *, cut: bool = False) -> str:
    """`value` with as many digits as are printed, rounded or cut off."""
    unit = digits(printed)[1]
    # a value that is a whole number of units except for its last bit is not cut to the one below
    count = math.floor(value / unit + (1e-9 if cut else 0.5))
    # angles are counted in whole minutes
    if "'" in printed:
        return f"{count // 60}°{count % 60:02}'"
    mark = "°" if printed.endswith("°") else ""
    return f"{count * unit:.{_decimals(unit)}f}{mark}"


def finer(printed: str, value: float) -> str:
    """`value` with two digits more than printed, to show the effect of rounding."""
    if "'" in printed:
        return f"{math.floor(value)}°{60.0 * (value % 1.0):05.2f}'"
    return f"{value:.{_decimals(digits(printed)[1]) + 2}f}"


def gives(printed: str, value: float, *, cut: bool = False) -> bool:
    """Whether `value`, rounded or cut off, is the printed number."""
    return digits(like(printed, value, cut=cut)) == digits(printed)


def _decimals(unit: float) -> int:
    return round(-math.log10(unit))


@dataclass(frozen=True)
class Cell:
    """One printed number beside the true one.

    place : its place: a number of slots, the number of a figure, or words.
    column : which number at that place it is.
    printed, true : text with the same number of digits; `true` is None for a number that
        follows from nothing printed.
    value : the true value, unrounded, or NaN; angles in degrees.
    reason : the rule that explains why they differ, in a sentence; "" where they agree.
    """

    place: Any
    column: str
    printed: str
    true: str | None
    value: float
    reason: str = ""

    @property
    def agrees(self) -> bool:
        """Whether the printed number is right to its last digit, or cannot be judged."""
        return not self.reason

    @property
    def number(self) -> float:
        """The printed number; the true one where the paper prints a name instead."""
        return digits(self.printed)[0] if self.printed[0].isdigit() else self.value


Cells = Sequence[Cell]
Rules = Callable[[str, float], Iterator[str]]
"""From a printed number and the true value to every reason that holds, the strictest first."""


def judge(place: Any, column: str, printed: str, value: float, rules: Rules) -> Cell:
    """Compare a printed number with the true value, which is NaN if it cannot be judged."""
    if math.isnan(value):
        return Cell(place, column, printed, None, value)
    reason = "" if gives(printed, value) else next(rules(printed, value), UNEXPLAINED)
    return Cell(place, column, printed, like(printed, value), value, reason)


def cut_off(printed: str, value: float) -> Iterator[str]:
    """The rule that digits were dropped where they should have been rounded."""
    if gives(printed, value, cut=True):
        yield f"cut off, not rounded: {finer(printed, value)}"


@dataclass(frozen=True)
class Slip:
    """A slip in an equation or a sentence: its place, the printed and the correct text."""

    place: str
    printed: str
    true: str


def read_slips(source: str) -> list[Slip]:
    """Slips of a source; the tests try those that are formulas, as printed and as corrected."""
    rows = read_table(source, "slips.csv")
    return [Slip(row["place"], row["printed"], row["true"]) for row in rows]


# --- a source as a whole ------------------------------------------------------------------


@dataclass(frozen=True)
class Reproduction:
    """A source's numbers, recomputed, and the ways to show them.

    name : of its tables, without a suffix.
    record : for JSON.
    table : rows for CSV, a header first.
    show : prints for people.
    panels : gives the figures; only its call imports matplotlib.
    """

    name: str
    record: Record
    table: Table
    show: Callable[[], None]
    panels: Callable[[], Panels]


def say(text: str) -> None:
    """Print a sentence, folded to `WIDTH`, its further lines indented by four more."""
    indent = " " * (4 + len(text) - len(text.lstrip()))
    print(textwrap.fill(text, WIDTH, subsequent_indent=indent, break_on_hyphens=False))


def by_place(cells: Cells) -> dict[Any, list[Cell]]:
    """Cells in order, those of one place together."""
    return {place: list(found) for place, found in groupby(cells, lambda cell: cell.place)}


def compare(
    cells: Cells, slips: Iterable[Slip], heads: Mapping[Any, Record], keys: dict[str, str]
) -> Record:
    """Content of the JSON: a row of printed and true numbers for each place, errata, and counts.

    heads : further values of a place.
    keys : names of numbers, instead of those of their columns.
    """
    rows = []
    shown_keys = ("column", "printed", "true", "reason")
    for place, found in by_place(cells).items():
        named = {keys.get(cell.column, cell.column): cell for cell in found}
        printed = {key: cell.number for key, cell in named.items()}
        true = {key: cell.value for key, cell in named.items()}
        errata = [
            {key: getattr(cell, key) for key in shown_keys} for cell in found if not cell.agrees
        ]
        rows.append({**heads[place], "printed": printed, "true": true, "errata": errata})
    return {
        "rows": rows,
        "cells": len(cells),
        "agreeing": sum(cell.agrees for cell in cells),
        "equations": [vars(slip) for slip in slips],
    }


def as_table(cells: Cells, place: str) -> Table:
    """A header, then a line for each cell; `place` is the heading of its place."""
    rows: list[list[Any]] = [[place, "column", "printed", "true", "value", "agrees", "reason"]]
    for cell in cells:
        *said, reason = vars(cell).values()
        rows.append([*said, "yes" if cell.agrees else "no", reason])
    return rows


def print_side_by_side(
    heads: dict[str, str], columns: dict[str, str], rows: Iterable[Record], cells: Cells
) -> None:
    """Print rows of cells, each printed and below it true, a star at what differs.

    heads : headings before the cells, and the keys of their values in `rows`.
    columns : headings of the cells by their columns.
    """
    lines: list[list[Any]] = []
    for row, found in zip(rows, by_place(cells).values(), strict=True):
        printed = [f"{cell.printed} " for cell in found]
        # a blank keeps digits of one column below each other
        true = [f"{cell.true}{' ' if cell.agrees else '*'}" for cell in found]
        lines.append([*(row[key] for key in heads.values()), "printed", *printed])
        lines.append([*[""] * len(heads), "true", *true])
    print_columns([[*heads, "", *(f"{name} " for name in columns.values())]], lines)


def print_errata(
    cells: Cells, what: str, place: str, columns: dict[str, str], slips: list[Slip]
) -> None:
    """Print how many cells are right; each wrong one, its place and the reason; and every slip.

    what : name of the cells.
    place : text for the place of a cell and its column, as `columns` calls it.
    """
    judged = [cell for cell in cells if cell.true is not None]
    wrong = [cell for cell in judged if not cell.agrees]
    count = f"{len(judged) - len(wrong)} of {len(judged)}"
    print(f"\n{count} {what} are right to their last digit. Errata:")
    for cell in wrong:
        where = place.format(cell.place, columns[cell.column])
        say(f"  {where}: {cell.printed} must be {cell.true}")
        say(f"      {cell.reason}")
    print_slips(slips)


def print_slips(slips: Iterable[Slip]) -> None:
    """Print every slip."""
    print("\nSlips in equations and text, some perhaps the scan's:")
    for slip in slips:
        say(f"  {slip.place}: {slip.printed}")
        say(f"      must be {slip.true}")
