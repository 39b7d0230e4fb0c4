"""Filemon (1960): the 48 cells of Table I and every slip, printed and true.

Every cell follows from the closed forms of `constant_speed.geneva`. The reason for a wrong cell
is found by computation, and no list of cells is kept: a rule is named if it gives the printed
digits and the true value does not. The rules of four places say only that the printed value can
result from such an error. Each equation is evaluated as printed and as corrected, and both are
compared with the result from the pin's path, which proves the correction.
"""

import math
from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from numpy.typing import ArrayLike

from escapement.constant_speed import geneva, reversal_study
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray
from escapement.sources import report
from escapement.sources.report import Cell, Slip, cut_off, digits, finer, gives, judge, like

COLUMNS = {
    "ratio_max": "i_omega max", "beta_max": "beta_max", "acceleration_start": "i_epsilon start",
    "acceleration_max": "i_epsilon max", "F12": "F12", "F23": "F23",
}  # fmt: skip
"""Columns of Table I and their names in the paper."""
_SINE, _LENGTH = 1e-4, 5e-5  # errors of a sine and of L in arithmetic of four decimals
_SHARES = np.array([-0.93, -0.7, -0.41, -0.2, 0.13, 0.35, 0.62, 0.88])  # places as shares of beta_0


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


def equations() -> list[Slip]:
    """Every slip of the equations, each tested: relative errors for 3 to 10 slots."""
    n = np.repeat(np.arange(3, 11), _SHARES.size)
    c, half = geneva.crank_ratio(n), geneva.engagement_half(n)
    # the places keep clear of dead centre, where some of the functions are zero
    b = np.resize(_SHARES, n.size) * half
    wheels = [Geneva(int(k), pins=1) for k in n]
    found = [wheel.transmission(at) for wheel, at in zip(wheels, b, strict=True)]
    g, dg = np.array([(one.g, one.dg) for one in found]).T
    ddg = np.array([wheel.jerk(at) for wheel, at in zip(wheels, b, strict=True)])
    x = np.cos(b)
    length = 1.0 + c * c - 2.0 * c * x
    ratio, swing = c * (x - c) / length, c * (1.0 - c * c)
    # the acceleration function, from which (7) and the slope of the torque follow
    rate = -swing * np.sin(b) / length**2
    quarters = ((1.0 + sign * c * c) / (4.0 * c) for sign in (-1.0, 1.0))
    curvatures = (2.0 * c * x**2 + (1.0 + sign * c * c) * x - 4.0 * c for sign in (-1.0, 1.0))
    top = 2.0 * c * x**3 + 2.0 * (1.0 - c * c) * x**2 - (5.0 * c + c**3) * x + 5.0 * c * c - 1.0
    # the second term of dM_2/d beta at F = 1, M_e = eta = 1, without its denominator
    term = c * swing * top
    # the formula as printed, the true one, and what both should give
    tried = {
        "acceleration": (ratio**2 * rate, rate, dg),
        "jerk": (*(-swing * curvature / length**3 for curvature in curvatures), ddg),
        "reversal ratio": (
            length**2 / (c * (1.0 - c * c * np.sin(b))), length**2 / (swing * np.sin(b)), -1.0 / dg
        ),
        "steepest": (
            *(np.sqrt(k * k + 2.0) - k for k in quarters), np.cos(geneva.acceleration_max_angle(n))
        ),
        "limit F23": (-1.0 / np.tan(np.arcsin(c)), 1.0 / np.tan(np.arcsin(c)), np.tan(half)),
        "torque slope": (
            rate - term / length**3, rate - term / length**4, dg + dg**2 + g * ddg
        ),
        "cubic": (_cubic(n, 0.0, -1.0, 0.333, 0.074), _cubic(n, 1 / 3, 1.0, 1 / 3, 2 / 27), 1.0),
    }  # fmt: skip
    deviations = {
        name: (printed / goal - 1.0, true / goal - 1.0)
        for name, (printed, true, goal) in tried.items()
    }
    return report.read_slips("filemon", deviations)


def _cubic(n: ArrayLike, shift: float, sign: float, third: float, cube: float) -> FloatArray:
    """1 + the reduced cubic (12) over y^3, y = cos(beta*) + shift a, at its root."""
    c = geneva.crank_ratio(n)
    a, q, d = (1.0 - c * c) / c, 0.5 * (5.0 + c * c), (5.0 * c * c - 1.0) / (2.0 * c)
    # F is practically infinite
    y = np.cos(reversal_study(n, 1e15).torque_max_angle) + shift * a
    rest = y * (-third * a * a - q) + cube * a**3 + sign * third * q * a + d
    return 1.0 + (y**3 + rest) / y**3


def reproduce(units: str | None = None) -> report.Reproduction:
    """All 48 cells recomputed: pure numbers and angles, independent of the units."""
    cells, slips = table_1(), equations()
    heads = {n: {"slots": n} for n in printed_rows()}
    record = report.compare(cells, slips, heads, {"beta_max": "beta_max_deg"})

    def show() -> None:
        print("Filemon (1960), Table I: printed, and below it true; * differs\n")
        report.print_side_by_side({"n": "slots"}, COLUMNS, record["rows"], cells)
        tried = "3 to 10 slots, relative"
        report.print_errata(cells, "cells", "n = {}, {}", COLUMNS, slips, tried)

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
