"""What each source hands to `escapement reproduce`, and how its errata are shown."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from escapement.sources.printed import EquationErratum, PrintedNumber

_HEAD = ("column", "printed", "right", "computed", "agrees", "reason")


@dataclass(frozen=True)
class Reproduction:
    """A source's numbers, recomputed, and the ways to show them.

    name : of its tables, without a suffix.
    record : for JSON.
    table : rows for CSV, a header first.
    show : prints for people.
    draw : fills a folder with figures.
    """

    name: str
    record: dict[str, Any]
    table: Sequence[Sequence[Any]]
    show: Callable[[], None]
    draw: Callable[[Path], None]


def print_errata(
    numbers: Sequence[PrintedNumber], called: str, place: Callable[[Any], str]
) -> None:
    """How many numbers are right; each that is not, where it stands, and why."""
    wrong = [it for it in numbers if not it.agrees]
    right = len(numbers) - len(wrong)
    print(f"\n{right} of {len(numbers)} {called} are right to their last digit. Errata:")
    for it in wrong:
        print(f"  {place(it)}: {it.printed} must be {it.right}")
        print(f"      {it.reason}")


def print_equations(slips: Sequence[EquationErratum]) -> None:
    """Each slip of a formula or a sentence, with the errors of the formulas."""
    for slip in slips:
        print(f"  {slip.place}: {slip.printed}")
        error = ""
        if slip.printed_error is not None and slip.right_error is not None:
            error = f"  [{slip.printed_error:.2g}; corrected {slip.right_error:.0e}]"
        print(f"      must be {slip.right}{error}")


def as_table(numbers: Sequence[PrintedNumber], row: str) -> list[list[Any]]:
    """A header, then a line a number; `row` is what tells its row."""
    return [
        [row, *_HEAD],
        *(
            [
                getattr(it, row), it.column, it.printed, it.right, repr(it.value),
                "yes" if it.agrees else "no", it.reason,
            ]
            for it in numbers
        ),
    ]  # fmt: skip
