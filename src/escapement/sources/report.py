"""How every source's printed and computed numbers are handed on, printed and drawn."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.sources.printed import Cell, Slip
from escapement.text import print_columns

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    Panels = Mapping[str, Callable[[], Axes | Figure]]
    """File names of figures, and what draws each."""


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
    record: dict[str, Any]
    table: Sequence[Sequence[Any]]
    show: Callable[[], None]
    panels: "Callable[[], Panels]"

    def draw(self, folder: Path) -> None:
        """Fill a folder with figures."""
        # a table alone needs no plotting library
        from escapement.plots import save

        for name, plot in self.panels().items():
            save(plot(), folder / name)


def counts(cells: Sequence[Cell], slips: Sequence[Slip]) -> dict[str, Any]:
    """What JSON says of all cells together, and the slips."""
    return {
        "cells": len(cells),
        "agreeing": sum(cell.agrees for cell in cells),
        "equations": [vars(slip) for slip in slips],
        "message": "printed_error and right_error are null where a slip is a matter of words",
    }


def side_by_side(cells: Sequence[Cell], keys: Mapping[str, str]) -> dict[str, Any]:
    """Cells of one row for JSON: printed and right numbers, errata.

    keys : names of numbers in place of those of their columns.
    """
    named = {keys.get(cell.column, cell.column): cell for cell in cells}
    told = ("column", "printed", "right", "reason")
    return {
        "printed": {key: cell.number for key, cell in named.items()},
        "computed": {key: cell.value for key, cell in named.items()},
        "errata": [{key: getattr(cell, key) for key in told} for cell in cells if not cell.agrees],
    }


def as_table(cells: Sequence[Cell], place: str) -> list[list[Any]]:
    """A header, then a line a cell; `place` is the heading of where it stands."""
    header = [place, "column", "printed", "right", "computed", "agrees", "reason"]
    rows = [
        [
            cell.place, cell.column, cell.printed, cell.right, cell.value,
            "yes" if cell.agrees else "no", cell.reason,
        ]
        for cell in cells
    ]  # fmt: skip
    return [header, *rows]


def print_side_by_side(
    heads: Sequence[str],
    columns: Iterable[str],
    rows: Iterable[tuple[Sequence[Any], Sequence[Cell]]],
) -> None:
    """Print rows of cells, each printed and below it computed, a star at what differs."""
    lines: list[list[Any]] = []
    for head, cells in rows:
        lines.append([*head, "printed", *(f"{cell.printed} " for cell in cells)])
        # a blank keeps digits of one column below each other
        computed = [f"{cell.right}{' ' if cell.agrees else '*'}" for cell in cells]
        lines.append([*[""] * len(head), "computed", *computed])
    print_columns([[*heads, "", *(f"{name} " for name in columns)]], lines)


def print_errata(cells: Sequence[Cell], called: str, place: Callable[[Cell], str]) -> None:
    """How many cells are right; each that is not, where it stands, and why."""
    wrong = [cell for cell in cells if not cell.agrees]
    judged = sum(cell.right is not None for cell in cells)
    print(f"\n{judged - len(wrong)} of {judged} {called} are right to their last digit. Errata:")
    for cell in wrong:
        print(f"  {place(cell)}: {cell.printed} must be {cell.right}\n      {cell.reason}")


def print_slips(slips: Sequence[Slip], tried: str = "") -> None:
    """Each slip of a formula or a sentence; `tried` says on which mechanisms a formula was."""
    print("\nSlips in equations and text, some perhaps the scan's:")
    if tried:
        print(f"  [greatest error of the printed and of the corrected formula for {tried}]")
    for slip in slips:
        error = ""
        if slip.printed_error is not None:
            error = f"  [{slip.printed_error:.2g}; corrected {slip.right_error:.0e}]"
        print(f"  {slip.place}: {slip.printed}\n      must be {slip.right}{error}")
