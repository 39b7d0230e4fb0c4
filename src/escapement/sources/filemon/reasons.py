"""Why a cell of Filemon's Table I is wrong, decided by recomputing it.

No list of cells is kept: a rule is named where it gives the printed digits and
the right value does not. The rules are tried from the strictest to the loosest;
those of four places say only that the printed value is within their reach.
"""

import math
from collections.abc import Mapping
from typing import Any

from escapement.sources.printed import Digits


def why(printed: Digits, right: Digits, value: float, relatives: Mapping[str, Any]) -> str:
    """The rule that turns the right value into the printed one, in a sentence.

    Parameters
    ----------
    printed, right : Digits
        The cell, and what it should be.
    value : float
        The right value, unrounded.
    relatives : mapping
        `reciprocal`, the printed cell this one is the reciprocal of, or None;
        `reciprocal_of`, its column; `with_sines`, the least and greatest value
        that sines off by a unit in their fourth decimal give; `with_lengths`,
        those that L off by half of one gives, or None.
    """
    other, name = relatives["reciprocal"], relatives["reciprocal_of"]
    if other is not None:
        made = 1.0 / other.value
        for how, cut in (("rounded", False), ("cut off", True)):
            if printed.like(made, cut=cut).value == printed.value:
                return (
                    f"reciprocal: 1/{other.text}, of the printed {name}, is {made:.6g}, {how} to "
                    f"{printed.text}"
                )
    if printed.like(value, cut=True).value == printed.value:
        return f"cut off, not rounded: {_shown(value, printed)}"
    low, high = relatives["with_sines"]
    if low - 0.5 * printed.unit <= printed.value <= high + 0.5 * printed.unit:
        return (
            "four-place tables: sin(pi/n) with an error of up to one unit in its fourth decimal "
            f"gives {_shown(low, printed)} to {_shown(high, printed)}"
        )
    if relatives["with_lengths"] is not None:
        low, high = relatives["with_lengths"]
        if low <= printed.value <= high:
            return (
                "four-place arithmetic: L = 1 + c^2 - 2c cos(beta) is a small difference, and half "
                f"a unit in its fourth decimal gives {_shown(low, printed)} to "
                f"{_shown(high, printed)}"
            )
    if other is not None:
        near = printed.like(1.0 / other.value)
        if _transposed(printed, near):
            return f"digits transposed: {near.text}, the reciprocal of the printed {name}"
    if _transposed(printed, right):
        return f"digits transposed: {right.text}"
    slip = _one_digit(printed, right)
    if slip is not None:
        return f"digit slip: {slip[0]} printed for {slip[1]}"
    return "unexplained"


def _shown(value: float, printed: Digits) -> str:
    """A value with two digits more than the cell has."""
    if printed.angle:
        degrees = math.floor(value)
        return f"{degrees}°{60.0 * (value - degrees):05.2f}'"
    return f"{value:.{round(-math.log10(printed.unit)) + 2}f}"


def _transposed(first: Digits, second: Digits) -> bool:
    return first.value != second.value and sorted(first.figures) == sorted(second.figures)


def _one_digit(printed: Digits, right: Digits) -> tuple[str, str] | None:
    """The one digit that stands for another, once or more than once; None for several."""
    if len(printed.text) != len(right.text):
        return None
    pairs = {(a, b) for a, b in zip(printed.text, right.text, strict=True) if a != b}
    return pairs.pop() if len(pairs) == 1 else None
