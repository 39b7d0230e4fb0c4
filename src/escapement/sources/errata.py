"""What is compared in every source: printed numbers, and slips of equations and text."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class PrintedNumber:
    """One printed number beside the right one.

    column : which of its row's numbers it is.
    printed, right : text with the same number of digits.
    value : the right value; angles in degrees.
    agrees : whether the printed number is right to its last digit.
    reason : else the rule that explains it, in a sentence; "" where it agrees.
    """

    column: str
    printed: str
    right: str
    value: float
    agrees: bool
    reason: str


def as_errata(numbers: Iterable[PrintedNumber]) -> list[dict[str, str]]:
    """Those that are wrong, for JSON."""
    keys = ("column", "printed", "right", "reason")
    return [{key: getattr(it, key) for key in keys} for it in numbers if not it.agrees]


@dataclass(frozen=True)
class EquationErratum:
    """One slip of a paper.

    place : where it stands.
    printed, right : what it says and what it must say.
    printed_error, right_error : greatest deviation of either formula from the
        mechanisms it is for; None where it is a matter of words.
    """

    place: str
    printed: str
    right: str
    printed_error: float | None
    right_error: float | None


@dataclass(frozen=True)
class Slip:
    """A slip as it is noted down, its formulas to be tried out.

    place, printed, right : as in `EquationErratum`.
    as_printed, as_corrected : the formula; None where it is a matter of words.
    """

    place: str
    printed: str
    right: str
    as_printed: Callable[..., Any] | None = None
    as_corrected: Callable[..., Any] | None = None

    def tried(self, error: Callable[[Callable[..., Any]], float]) -> EquationErratum:
        """The erratum, `error` telling how far a formula is off."""
        printed, right = (
            None if formula is None else error(formula)
            for formula in (self.as_printed, self.as_corrected)
        )
        return EquationErratum(self.place, self.printed, self.right, printed, right)
