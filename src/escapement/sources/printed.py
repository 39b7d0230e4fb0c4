"""Printed numbers beside the right ones, and slips in equations and text.

A printed number has so many digits and no more, so the right value is rounded to as many
before the two are compared.
"""

import csv
import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.resources import files
from typing import Any


def read_table(source: str, name: str) -> list[list[str]]:
    """Rows of a data file in the folder of a source, without their header."""
    text = files("escapement.sources").joinpath(source, name).read_text(encoding="utf-8")
    return list(csv.reader(text.splitlines()[1:]))


@dataclass(frozen=True)
class Digits:
    """A printed number: its text, its value, and the unit of its last digit.

    Angles, in degrees and minutes, have a value in degrees.
    """

    text: str
    value: float
    unit: float
    angle: bool = False

    def like(self, value: float, *, cut: bool = False) -> "Digits":
        """`value` with as many digits, rounded or cut off."""
        count = math.floor(value / self.unit + (1e-9 if cut else 0.5))
        if self.angle:
            degrees, minutes = divmod(count, 60)
            return digits(f"{degrees}°{minutes:02}'")
        return digits(f"{count * self.unit:.{round(-math.log10(self.unit))}f}")

    @property
    def figures(self) -> str:
        """The digits alone, leading zeros dropped."""
        return re.sub(r"\D", "", self.text).lstrip("0")


def digits(text: str) -> Digits:
    """A cell as printed: 0.7265, 4°46', or 1.— for a whole number."""
    angle = re.fullmatch(r"(\d+)°(\d+)'", text)
    if angle:
        minutes = 60 * int(angle[1]) + int(angle[2])
        return Digits(text, minutes / 60.0, 1.0 / 60.0, angle=True)
    plain = text.replace("—", "0000")
    places = len(plain.partition(".")[2])
    return Digits(text, float(plain), 10.0**-places)


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
class Erratum:
    """A slip of a paper: where it stands, what it says, what it must say."""

    place: str
    printed: str
    right: str


@dataclass(frozen=True)
class EquationErratum(Erratum):
    """A slip with the size of the error that it makes.

    printed_error, right_error : greatest deviation of either formula from the
        mechanisms it is for; None where it is a matter of words.
    """

    printed_error: float | None
    right_error: float | None


@dataclass(frozen=True)
class FormulaErratum(Erratum):
    """A slip whose formulas can be evaluated.

    as_printed, as_corrected : the formula; None where it is a matter of words.
    """

    as_printed: Callable[..., Any] | None = None
    as_corrected: Callable[..., Any] | None = None

    def tried(self, error: Callable[[Callable[..., Any]], float]) -> EquationErratum:
        """The erratum with its errors; `error` says how far a formula is off."""
        printed, right = (
            None if formula is None else error(formula)
            for formula in (self.as_printed, self.as_corrected)
        )
        return EquationErratum(self.place, self.printed, self.right, printed, right)
