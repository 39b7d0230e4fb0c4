"""Filemon (1960): the 48 cells of Table I, printed against computed.

Every cell follows from the closed forms of `constant_speed.geneva`. Why one is wrong is
decided by recomputing it, and no list of cells is kept: a rule is named where it gives the
printed digits and the right value does not. The rules of four places say only that the
printed value is within their reach.
"""

import math
from collections.abc import Iterator, Sequence
from functools import cache, partial

import numpy as np

from escapement.constant_speed import geneva
from escapement.mechanisms import Geneva
from escapement.sources import report
from escapement.sources.filemon.slips import equations
from escapement.sources.printed import Cell, Digits, cut_off, digits, judge, read_table

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
_RECIPROCALS = {"F12": "acceleration_max", "F23": "acceleration_start"}
_SINE, _LENGTH = 1e-4, 5e-5  # errors of a sine and of L in arithmetic of four decimals


@cache
def printed_rows() -> dict[int, dict[str, str]]:
    """Table I by number of slots, 3 to 10, as text: beta in degrees and minutes."""
    return {int(row["slots"]): row for row in read_table("filemon", "table_1.csv")}


def table_1() -> list[Cell]:
    """All 48 cells, row after row."""
    return [cell for slots in printed_rows() for cell in _row(slots)]


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
    # a wheel with as many slots, not a whole number, has just this sine
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
    # the torque is smooth over half an engagement, where the sum converges at once
    for n in slots:
        wheel = Geneva(n, pins=1)
        table = wheel.transmission(0.5 * wheel.breaks[0] * (1.0 - nodes))
        mean = 0.5 * float(weights @ (table.g * (1.0 + ratio * table.dg)))
        d, a = geneva.mean_factors(n)
        worst = max(worst, abs(mean / float(d * (1.0 + ratio * a)) - 1.0))
    return worst


def reproduce(units: str) -> report.Reproduction:
    """All 48 cells recomputed: pure numbers and angles, whatever the units."""
    rows = {slots: _row(slots) for slots in printed_rows()}
    cells, slips, error = table_1(), equations(), mean_torque_error()
    keys = {"beta_max": "beta_max_deg"}
    compared = [{"slots": n, **report.side_by_side(row, keys)} for n, row in rows.items()]
    record = {"rows": compared, **report.counts(cells, slips), "mean_torque_error": error}

    def show() -> None:
        print("Filemon (1960), Table I: printed, and below it computed; * differs\n")
        report.print_side_by_side("n", COLUMNS.values(), [([n], row) for n, row in rows.items()])
        report.print_errata(cells, "cells", lambda it: f"n = {it.place}, {COLUMNS[it.column]}")
        report.print_slips(slips, "3 to 10 slots, relative")
        print(f"\nMean torque (10) against quadrature, n = 3 to 100: relative error {error:.1e}")

    lines = report.as_table(cells, "slots")
    return report.Reproduction("filemon_table_1", record, lines, show, _panels)


def _panels() -> "report.Panels":
    """Figures 3 to 12 and 15; the nomograms 13 and 16, to be printed, as PDF."""
    from escapement.sources.filemon.figures import FIGURES
    from escapement.sources.filemon.nomograms import NOMOGRAMS, plot_nomogram

    sheets = {f"{name}.pdf": partial(plot_nomogram, sheet) for name, sheet in NOMOGRAMS.items()}
    panels = {f"{number}.png": plot for number, plot in FIGURES.items()} | sheets
    return {f"filemon_figure_{name}": plot for name, plot in panels.items()}


def _row(slots: int) -> list[Cell]:
    """The cells of a row of Table I."""
    row, values = printed_rows()[slots], right_values(slots)
    return [
        judge(slots, column, row[column], values[column], partial(_why, slots, column))
        for column in COLUMNS
    ]


def _why(slots: int, column: str, printed: Digits, right: Digits) -> Iterator[str]:
    """Rules that give the printed digits, from the strictest to the loosest."""
    if column in _RECIPROCALS:
        source = _RECIPROCALS[column]
        other = digits(printed_rows()[slots][source])
        made = 1.0 / other.value
        for how, cut in (("rounded", False), ("cut off", True)):
            if printed.like(made, cut=cut).value == printed.value:
                yield (
                    f"reciprocal: 1/{other.text}, of the printed {COLUMNS[source]}, is "
                    f"{made:.6g}, {how} to {printed.text}"
                )
        near = printed.like(made).text
        if sorted(printed.text) == sorted(near):
            yield f"digits transposed: {near}, the reciprocal of the printed {COLUMNS[source]}"
    yield from cut_off(printed, right_values(slots)[column])
    sine = round(float(geneva.crank_ratio(slots)), 4)
    low, high = sorted(right_values(slots, sine + off)[column] for off in (-_SINE, _SINE))
    # the printed value was itself rounded once more
    if low - 0.5 * printed.unit <= printed.value <= high + 0.5 * printed.unit:
        yield (
            "four-place tables: sin(pi/n) with an error of up to one unit in its fourth decimal "
            f"gives {printed.finer(low)} to {printed.finer(high)}"
        )
    low, high = _with_lengths(slots)
    if column == "acceleration_max" and low <= printed.value <= high:
        yield (
            "four-place arithmetic: L = 1 + c^2 - 2c cos(beta) is a small difference, and half "
            f"a unit in its fourth decimal gives {printed.finer(low)} to {printed.finer(high)}"
        )
    # both texts have as many characters, because `right` was given the digits of `printed`
    wrong = {(a, b) for a, b in zip(printed.text, right.text, strict=True) if a != b}
    # one digit may stand for another more than once
    if len(wrong) == 1:
        yield "digit slip: {} printed for {}".format(*wrong.pop())


def _with_lengths(slots: int) -> tuple[float, float]:
    """i_epsilon max where L, squared in its denominator, is off by half a fourth decimal."""
    c, b = geneva.crank_ratio(slots), geneva.acceleration_max_angle(slots)
    length = 1.0 + c * c - 2.0 * c * np.cos(b)
    top = float(geneva.acceleration_max(slots))
    low, high = (top * float(length / (length + off)) ** 2 for off in (_LENGTH, -_LENGTH))
    return low, high
