"""Filemon (1960): the 48 cells of Table I and every slip, printed and true.

Every cell follows from the closed forms of `constant_speed.geneva`. The reason for a wrong cell
is found by computation, and no list of cells is kept: a rule is named if it gives the printed
digits and the true value does not. The rules of four places say only that the printed value can
result from such an error.
"""

import math
from collections.abc import Iterator
from functools import cache, partial

import numpy as np

from escapement.constant_speed import geneva
from escapement.sources import report
from escapement.sources.report import Cell, cut_off, digits, finer, gives, judge, like

COLUMNS = {
    "ratio_max": "i_omega max", "beta_max": "beta_max", "acceleration_start": "i_epsilon start",
    "acceleration_max": "i_epsilon max", "F12": "F12", "F23": "F23",
}  # fmt: skip
"""Columns of Table I and their names in the paper."""
_SINE, _LENGTH = 1e-4, 5e-5  # errors of a sine and of L in arithmetic of four decimals


@cache
def printed_rows() -> dict[int, dict[str, str]]:
    """Table I by number of slots, 3 to 10, as text: beta in degrees and minutes."""
    return {int(row["slots"]): row for row in report.read_table("filemon", "table_1.csv")}


def table_1() -> list[Cell]:
    """All 48 cells, row after row."""
    cells = []
    for slots, row in printed_rows().items():
        for column, value in true_values(slots).items():
            cells.append(judge(slots, column, row[column], value, partial(_why, slots, column)))
    return cells


def true_values(slots: int, sine: float | None = None) -> dict[str, float]:
    """A row of Table I for any number of slots; beta_max in degrees.

    Parameters
    ----------
    slots : int
        Slots n, >= 3.
    sine : float, optional
        Another c instead of sin(pi/n), as from tables with few digits.
    """
    # a wheel with this number of slots, not a whole number, has exactly this sine
    half_pitch = slots if sine is None else math.pi / math.asin(sine)
    start, top = geneva.acceleration_start(slots), geneva.acceleration_max(half_pitch)
    steepest = math.degrees(geneva.acceleration_max_angle(half_pitch))
    values = [geneva.ratio_max(half_pitch), steepest, start, top, 1.0 / top, 1.0 / start]
    return dict(zip(COLUMNS, np.array(values).tolist(), strict=True))


def reproduce(units: str | None = None) -> report.Reproduction:
    """All 48 cells recomputed: pure numbers and angles, independent of the units."""
    cells, slips = table_1(), report.read_slips("filemon")
    heads = {n: {"slots": n} for n in printed_rows()}
    record = report.compare(cells, slips, heads, {"beta_max": "beta_max_deg"})

    def show() -> None:
        print("Filemon (1960), Table I: printed, and below it true; * differs\n")
        report.print_side_by_side({"n": "slots"}, COLUMNS, record["rows"], cells)
        report.print_errata(cells, "cells", "n = {}, {}", COLUMNS, slips)

    lines = report.as_table(cells, "slots")
    return report.Reproduction("filemon_table_1", record, lines, show, _panels)


def _panels() -> report.Panels:
    """Figures 3 to 12 and 15, and the nomograms 13 and 16."""
    from escapement.sources.filemon.filemon_figures import FIGURES
    from escapement.sources.filemon.nomograms import NOMOGRAMS, plot_nomogram

    sheets = {name: partial(plot_nomogram, sheet) for name, sheet in NOMOGRAMS.items()}
    return {f"filemon_figure_{name}": plot for name, plot in (FIGURES | sheets).items()}


def _why(slots: int, column: str, printed: str, value: float) -> Iterator[str]:
    """Rules that give the printed digits, from the strictest to the loosest."""
    source = {"F12": "acceleration_max", "F23": "acceleration_start"}.get(column)
    if source:
        other = printed_rows()[slots][source]
        made = 1.0 / digits(other)[0]
        for how in ("rounded", "cut off"):
            if gives(printed, made, cut=how == "cut off"):
                yield (
                    f"reciprocal: 1/{other}, of the printed {COLUMNS[source]}, is "
                    f"{made:.6g}, {how} to {printed}"
                )
        near = like(printed, made)
        if sorted(printed) == sorted(near):
            yield f"digits transposed: {near}, the reciprocal of the printed {COLUMNS[source]}"
    yield from cut_off(printed, value)
    shown, unit = digits(printed)
    sine = round(float(geneva.crank_ratio(slots)), 4)
    ends = sorted(true_values(slots, sine + off)[column] for off in (-_SINE, _SINE))
    reach = {"tables: sin(pi/n) with an error of up to one unit": ends}
    if column == "acceleration_max":
        c, b = geneva.crank_ratio(slots), geneva.acceleration_max_angle(slots)
        length = 1.0 + c * c - 2.0 * c * np.cos(b)
        # L stands squared in the denominator
        small = "arithmetic: L = 1 + c^2 - 2c cos(beta) is a small difference, and half a unit"
        reach[small] = [value * float(length / (length + off)) ** 2 for off in (_LENGTH, -_LENGTH)]
    for how, (low, high) in reach.items():
        # the printed value was itself rounded again
        if low - 0.5 * unit <= shown <= high + 0.5 * unit:
            between = f"{finer(printed, low)} to {finer(printed, high)}"
            yield f"four-place {how} in its fourth decimal gives {between}"
    # both texts have the same number of characters, because the true one was given the same
    # digits
    wrong = {(a, b) for a, b in zip(printed, like(printed, value), strict=True) if a != b}
    # one digit may stand for another more than once
    if len(wrong) == 1:
        yield "digit slip: {} printed for {}".format(*wrong.pop())
