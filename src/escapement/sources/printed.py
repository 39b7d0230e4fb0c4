"""Printed numbers beside the right ones, and slips in equations.

A printed number has so many digits and no more, so the right value is rounded to as many
before the two are compared. Where they differ, rules are tried, from the strictest to the
loosest, until one gives the printed digits.
"""

import csv
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from escapement.model import FloatArray

UNEXPLAINED = "unexplained"


def read_table(source: str, name: str) -> list[dict[str, str]]:
    """Rows of a data file in the folder of a source, by the names of its columns."""
    text = files("escapement.sources").joinpath(source, name).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


@dataclass(frozen=True)
class Digits:
    """A printed number: its text, its value, and the unit of its last digit.

    Angles in degrees and minutes have a value in degrees.
    """

    text: str
    value: float
    unit: float

    def like(self, value: float, *, cut: bool = False) -> "Digits":
        """`value` with as many digits, rounded or cut off."""
        # what is a whole number of units but for the last bit is not cut to the number below
        count = math.floor(value / self.unit + (1e-9 if cut else 0.5))
        # angles are counted in whole minutes
        if "'" in self.text:
            return digits(f"{count // 60}°{count % 60:02}'")
        mark = "°" if self.text.endswith("°") else ""
        return digits(f"{count * self.unit:.{self._places}f}{mark}")

    def finer(self, value: float) -> str:
        """`value` with two digits more, to show what rounding did."""
        if "'" in self.text:
            return f"{math.floor(value)}°{60.0 * (value % 1.0):05.2f}'"
        return f"{value:.{self._places + 2}f}"

    @property
    def _places(self) -> int:
        return round(-math.log10(self.unit))


def digits(text: str) -> Digits:
    """A number as printed: 0.7265, 21.6°, 4°46', or 1.— for a whole number."""
    angle = re.fullmatch(r"(\d+)°(\d+)'", text)
    if angle:
        return Digits(text, (60 * int(angle[1]) + int(angle[2])) / 60.0, 1.0 / 60.0)
    # 1.— stands for a number that is right to four decimals
    plain = text.removesuffix("°").replace("—", "0000")
    return Digits(text, float(plain), 10.0 ** -len(plain.partition(".")[2]))


@dataclass(frozen=True)
class Cell:
    """One printed number beside the right one.

    place : where it stands: a number of slots, the number of a figure, or words.
    column : which number of that place it is.
    printed, right : text with the same number of digits; `right` is None for a number that
        follows from nothing printed.
    value : the right value, unrounded, or NaN; angles in degrees.
    reason : the rule that explains why they differ, in a sentence; "" where they agree.
    """

    place: Any
    column: str
    printed: str
    right: str | None
    value: float
    reason: str = ""

    @property
    def agrees(self) -> bool:
        """Whether the printed number is right to its last digit, or cannot be judged."""
        return not self.reason

    @property
    def number(self) -> float:
        """The printed number; the right one where the paper prints a name instead."""
        return digits(self.printed).value if self.printed[0].isdigit() else self.value


def judge(
    place: Any,
    column: str,
    printed: str,
    value: float,
    rules: Callable[[Digits, Digits], Iterator[str]],
) -> Cell:
    """Set the right value beside a printed number.

    rules : from the printed and the right digits to every reason that holds, the strictest
        first.
    """
    shown = digits(printed)
    right = shown.like(value)
    agrees = right.value == shown.value
    reason = "" if agrees else next(rules(shown, right), UNEXPLAINED)
    return Cell(place, column, printed, right.text, value, reason)


def cut_off(printed: Digits, value: float) -> Iterator[str]:
    """The rule that digits were dropped where they should have been rounded."""
    if printed.like(value, cut=True).value == printed.value:
        yield f"cut off, not rounded: {printed.finer(value)}"


@dataclass(frozen=True)
class Slip:
    """A slip in an equation or a sentence: where it stands, what it says, what it must say.

    printed_error, right_error : greatest deviation of the printed and of the corrected
        formula; None where the slip is a matter of words.
    """

    place: str
    printed: str
    right: str
    printed_error: float | None = None
    right_error: float | None = None


def read_slips(source: str, deviations: Mapping[str, tuple[FloatArray, FloatArray]]) -> list[Slip]:
    """Slips of a source, with the errors of those that are formulas.

    deviations : by the name in the file's column `formula`, by how much the printed and the
        corrected formula are off, in each of the mechanisms that they are tried on.
    """
    slips = []
    for row in read_table(source, "slips.csv"):
        errors = [float(np.abs(off).max()) for off in deviations.get(row["formula"], ())]
        slips.append(Slip(row["place"], row["printed"], row["right"], *errors))
    return slips
