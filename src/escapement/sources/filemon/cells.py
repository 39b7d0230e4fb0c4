"""Filemon's Table I: 48 printed cells beside what they should be.

Each cell is recomputed from the closed forms of `constant_speed.geneva`. One that
is not the right value to its last printed digit gets the rule that explains it,
found by trying the rules of `reasons` in turn.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from escapement.constant_speed import geneva
from escapement.mechanisms import Geneva
from escapement.sources.filemon.reasons import why
from escapement.sources.printed import Digits, PrintedNumber, as_errata, digits, read_table

COLUMNS = {
    "ratio_max": "i_omega max",
    "beta_max": "beta_max",
    "acceleration_start": "i_epsilon start",
    "acceleration_max": "i_epsilon max",
    "F12": "F12",
    "F23": "F23",
}
"""Columns of Table I and what the paper calls them."""
QUADRATURE_NODES = 400


class WheelRow(NamedTuple):
    """One column of the printed table, as text: beta in degrees and minutes."""

    slots: int
    ratio_max: str
    beta_max: str
    acceleration_start: str
    acceleration_max: str
    F12: str
    F23: str


@dataclass(frozen=True)
class TableCell(PrintedNumber):
    """One cell of the row of `slots`; `printed_value` is its number."""

    slots: int
    printed_value: float


@cache
def printed_rows() -> tuple[WheelRow, ...]:
    """Table I by number of slots, 3 to 10."""
    rows = read_table("filemon", "table_1.csv")
    return tuple(WheelRow(int(slots), *rest) for slots, *rest in rows)


def table_1() -> list[TableCell]:
    """All 48 cells, row after row."""
    return [_cell(row, column) for row in printed_rows() for column in COLUMNS]


def right_values(slots: int, sine: float | None = None) -> dict[str, float]:
    """A row of Table I for any number of slots; beta_max in degrees.

    Parameters
    ----------
    slots : int
        Slots n, >= 3.
    sine : float, optional
        Another c in place of sin(pi/n), as tables of few digits give it.
    """
    start = float(geneva.acceleration_start(slots))
    turned = slots if sine is None else math.pi / math.asin(sine)
    top = float(geneva.acceleration_max(turned))
    return {
        "ratio_max": float(geneva.ratio_max(turned)),
        "beta_max": math.degrees(float(geneva.acceleration_max_angle(turned))),
        "acceleration_start": start,
        "acceleration_max": top,
        "F12": 1.0 / top,
        "F23": 1.0 / start,
    }


def mean_torque_error(slots: Sequence[int] = range(3, 101), ratio: float = 1.0) -> float:
    """Greatest relative deviation of the mean torque (10) from quadrature [-].

    Parameters
    ----------
    slots : sequence of int
        Wheels to compare.
    ratio : float
        F [-].

    Notes
    -----
    Gauss-Legendre over the first half of the engagement, of g (1 + F g') from the
    pin's path: nothing of the closed form enters.
    """
    nodes, weights = np.polynomial.legendre.leggauss(QUADRATURE_NODES)
    worst = 0.0
    for n in slots:
        wheel = Geneva(n, pins=1)
        table = wheel.transmission(0.5 * wheel.breaks[0] * (1.0 - nodes))
        mean = 0.5 * float(weights @ (table.g * (1.0 + ratio * table.dg)))
        d, a = geneva.mean_factors(n)
        worst = max(worst, abs(mean / float(d * (1.0 + ratio * a)) - 1.0))
    return worst


def as_rows(cells: Sequence[TableCell]) -> list[dict[str, Any]]:
    """Cells by number of slots, for JSON: printed and right values, errata."""
    rows: list[dict[str, Any]] = []
    for n in dict.fromkeys(cell.slots for cell in cells):
        row = [cell for cell in cells if cell.slots == n]
        rows.append(
            {
                "slots": n,
                "printed": {_key(cell): cell.printed_value for cell in row},
                "computed": {_key(cell): cell.value for cell in row},
                "errata": as_errata(row),
            }
        )
    return rows


def _key(cell: TableCell) -> str:
    return "beta_max_deg" if cell.column == "beta_max" else cell.column


def _cell(row: WheelRow, column: str) -> TableCell:
    printed = digits(getattr(row, column))
    value = right_values(row.slots)[column]
    right = printed.like(value)
    agrees = right.value == printed.value
    reason = "" if agrees else why(printed, right, value, _relatives(row, column))
    return TableCell(
        column=column,
        printed=printed.text,
        right=right.text,
        value=value,
        agrees=agrees,
        reason=reason,
        slots=row.slots,
        printed_value=printed.value,
    )


def _relatives(row: WheelRow, column: str) -> dict[str, Any]:
    """What else the printed cell may have been made from."""
    source = {"F12": "acceleration_max", "F23": "acceleration_start"}.get(column)
    reciprocal: Digits | None = digits(getattr(row, source)) if source else None
    sine = float(geneva.crank_ratio(row.slots))
    place = round(sine, 4)
    lowest, highest = (right_values(row.slots, place + step)[column] for step in (-1e-4, 1e-4))
    return {
        "reciprocal": reciprocal,
        "reciprocal_of": COLUMNS.get(source or "", ""),
        "with_sines": (min(lowest, highest), max(lowest, highest)),
        "with_lengths": _with_lengths(row.slots) if column == "acceleration_max" else None,
    }


def _with_lengths(slots: int) -> tuple[float, float]:
    """i_epsilon max where L, squared in its denominator, is off by half a fourth decimal."""
    c, b = geneva.crank_ratio(slots), geneva.acceleration_max_angle(slots)
    length = 1.0 + c * c - 2.0 * c * np.cos(b)
    top = float(geneva.acceleration_max(slots))
    low, high = (top * float(length / (length + step)) ** 2 for step in (5e-5, -5e-5))
    return low, high
