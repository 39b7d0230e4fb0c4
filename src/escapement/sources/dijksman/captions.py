"""The mechanisms of Dijksman's figures 6 to 9: printed proportions beside the right ones.

A printed number that is not right to its last digit gets the rule that explains it,
found by recomputing it from the rounded ratio of times.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

from escapement.mechanisms import GearDriven
from escapement.sources.printed import Digits, PrintedNumber, as_errata, digits, read_table

COLUMNS = {"alpha": "alpha", "V": "V", "MC": "MC/R0", "M0C": "M0C/R0"}
"""Printed proportions and what a table calls them; alpha in degrees."""


class Caption(NamedTuple):
    """The caption of one figure; proportions as text."""

    figure: int
    curve: str
    stations: int
    lobes: int
    gear_ratio: int
    slots: int
    alpha: str
    V: str
    MC: str
    M0C: str

    @property
    def mechanism(self) -> GearDriven:
        """The mechanism that the caption names."""
        return GearDriven(self.stations, self.lobes, self.curve)


@dataclass(frozen=True)
class Proportion(PrintedNumber):
    """One number of the caption of `figure`."""

    figure: int


@cache
def printed_figures() -> tuple[Caption, ...]:
    """The captions of figures 6 to 9."""
    return tuple(
        Caption(int(number), curve, int(n), int(m), int(k), int(slots), *text)
        for number, curve, n, m, k, slots, *text in read_table("dijksman", "figures.csv")
    )


def proportions() -> list[Proportion]:
    """Every printed proportion, figure after figure."""
    return [_compare(figure, column) for figure in printed_figures() for column in COLUMNS]


def right_values(mechanism: GearDriven) -> dict[str, float]:
    """alpha [deg], V, MC/R0 and M0C/R0 of a mechanism with one pin."""
    return {
        "alpha": math.degrees(mechanism.alpha),
        "V": mechanism.motion_ratio,
        "MC": mechanism.arm_over_fixed,
        "M0C": mechanism.entry_radius_over_fixed,
    }


def as_rows(cells: Sequence[Proportion]) -> list[dict[str, Any]]:
    """Figures for JSON: what is printed, what is computed, errata."""
    rows: list[dict[str, Any]] = []
    for printed in printed_figures():
        own = [cell for cell in cells if cell.figure == printed.figure]
        mechanism = printed.mechanism
        rows.append(
            {
                "figure": printed.figure, "curve": printed.curve, "stations": printed.stations,
                "lobes": printed.lobes, "gear_ratio": float(mechanism.gear_ratio),
                "slots": mechanism.slots, "slots_printed": printed.slots,
                "printed": {_key(cell): _number(cell) for cell in own},
                "computed": {_key(cell): cell.value for cell in own},
                "errata": as_errata(own),
            }
        )  # fmt: skip
    return rows


def _key(cell: Proportion) -> str:
    keys = {"alpha": "alpha_deg", "MC": "arm_over_fixed", "M0C": "entry_radius_over_fixed"}
    return keys.get(cell.column, "motion_ratio")


def _number(cell: Proportion) -> float:
    return cell.value if cell.printed == "M0M" else _digits(cell.printed).value


def _digits(text: str) -> Digits:
    """A printed number; angles in whole minutes, or in degrees with decimals."""
    return digits(text) if "'" in text else digits(text.removesuffix("°"))


def _compare(figure: Caption, column: str) -> Proportion:
    mechanism = figure.mechanism
    value, text = right_values(mechanism)[column], getattr(figure, column)
    if text == "M0M":  # the caption gives the name of a length, not its value
        agrees = math.isclose(value, mechanism.carrier_over_fixed, rel_tol=1e-14)
        return Proportion(column, text, f"{value:g}", value, agrees, "", figure.figure)
    printed = _digits(text)
    right = printed.like(value)
    agrees = right.value == printed.value
    reason = "" if agrees else _why(figure, column, printed)
    mark = "°" if text.endswith("°") else ""
    return Proportion(column, text, right.text + mark, value, agrees, reason, figure.figure)


def _why(figure: Caption, column: str, printed: Digits) -> str:
    """The rule that gives the printed number, in a sentence."""
    mechanism = figure.mechanism
    for places in (len(figure.V.partition(".")[2]), 4):
        rounded = round(mechanism.motion_ratio, places)
        for off in (0.0, 10.0**-places):
            made = _from_ratio(mechanism, rounded + off)[column]
            if printed.like(made).value == printed.value:
                text = f"V = {rounded + off:.{places}f}"
                how = f", a unit in the last digit above {rounded:g}" if off else ", rounded"
                return f"computed from {text}{how}: {made:.6g}"
    return "unexplained"


def _from_ratio(mechanism: GearDriven, ratio: float) -> dict[str, float]:
    """Proportions as (9) and (15) give them from a ratio of times."""
    k = float(mechanism.gear_ratio)
    alpha = 2.0 * math.pi * ratio / abs(k)
    end = alpha + 2.0 * math.pi / mechanism.stations
    return {
        "alpha": math.degrees(alpha),
        "V": ratio,
        "MC": abs(math.sin(end) / (2.0 * math.sin(0.5 * k * alpha))),
        "M0C": math.cos(0.5 * end),
    }
