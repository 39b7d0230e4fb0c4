"""Meyer (1973), Appendix E: 49 printed runs beside what was computed and what is true.

The thesis prints tables for three mechanisms, but its program ran all of them
in the four-pin cell of 90 degrees, and the heading of the six-pin table has the
inertias swapped. `appendix_e` sets every printed row beside three
recomputations and names, by comparing them, what explains each difference.

"K in lb/rad" of the thesis is a constant torque in in-lbf, its inertias are in
in-lbf-s^2.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, partial
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from escapement import validate
from escapement.mechanisms import Geneva
from escapement.model import Escapement, Inertia
from escapement.simulation import simulate, terminal
from escapement.sources import report
from escapement.sources.meyer.program import program_1973, read_printout
from escapement.sources.meyer.published_cell import PublishedCell
from escapement.sources.meyer.reasons import HALF_DIGIT, RunFigures, why
from escapement.sources.printed import read_table
from escapement.text import print_columns
from escapement.units import INCH_POUND, SYSTEMS, factor, unit_name

INERTIAS = {3: (6e-6, 10e-6), 4: (3e-6, 50e-6), 6: (3e-6, 40e-6)}
"""Driver and follower inertia really used, by slots [in-lbf-s^2] (figures 9 to 11)."""
HEADINGS = {3: (10e-6, 6e-6), 4: (3e-6, 50e-6), 6: (3e-6, 40e-6)}
"""The same as the headings of Appendix E give them."""
COLUMNS = {
    "printed": "printed",
    "as_published": "as published",
    "program_1973": "program 1973",
    "true": "true mechanism",
}
"""What stands side by side, and what the report calls it."""

_FIELDS = (
    ("velocity_max", 5, 0), ("velocity_min", 5, 0), ("rise_time", 6, 3), ("period", 6, 3)
)  # fmt: skip
"""Figures, the width of their columns, and the decimals of the thesis."""


class PrintedRun(NamedTuple):
    """One row of Appendix E: torque in in-lbf, speeds in rad/s, times in s."""

    slots: int
    pins: int
    friction: float
    torque_inlbf: float
    velocity_max: float
    velocity_min: float
    rise_time: float
    period: float


class Agreement(NamedTuple):
    """How many of `rows` printed rows one recomputation meets."""

    rows: int
    periods: int  # within 1 ms: two readings of half a 0.5 ms row, and rounding
    minima: int  # within 0.55 rad/s: half a digit, and the table's row spacing
    maxima: int  # within 1 rad/s
    worst_maximum: float  # largest relative deviation of a maximum that exists [-]
    rise_times: int  # within half a printed period


@cache
def printed_rows() -> tuple[PrintedRun, ...]:
    """The 49 rows of Appendix E in printed order."""
    return tuple(
        PrintedRun(int(slots), int(pins), *map(float, rest))
        for pins, slots, *rest in map(dict.values, read_table("meyer", "appendix_e.csv"))
    )


def appendix_e(units: str = "in-lbf-s") -> list[dict[str, Any]]:
    """Every printed row beside its recomputations.

    Parameters
    ----------
    units : str
        "in-lbf-s" or "SI": the system of `torque`, `driver_inertia` and
        `follower_inertia` in the answer; `torque_inlbf` is there in both.

    Returns
    -------
    list of dict
        49 rows. `printed`, `as_published` (exact solution in the 90-degree
        cell), `program_1973` (the listing with its sampling) and `true` (the
        real mechanism) each hold `velocity_max`, `velocity_min` [rad/s],
        `rise_time`, `period` [s]. `reasons` explains
        what is off by more than half a printed digit, one sentence a cause.
    """
    validate.choice("units", units, SYSTEMS)
    return [_compare(row, units) for row in printed_rows()]


def agreement(rows: Sequence[Mapping[str, Any]], column: str = "as_published") -> Agreement:
    """Count how far one recomputation meets the printed figures.

    Parameters
    ----------
    rows : sequence of dict
        As `appendix_e` returns them.
    column : str
        "as_published", "program_1973" or "true".
    """
    printed, computed = (
        {name: np.array([row[which][name] for row in rows]) for name in HALF_DIGIT}
        for which in ("printed", column)
    )
    off = {name: np.abs(printed[name] - computed[name]) for name in HALF_DIGIT}
    return Agreement(
        rows=len(rows),
        periods=int((off["period"] <= 1e-3).sum()),
        minima=int((off["velocity_min"] <= 0.55).sum()),
        maxima=int((off["velocity_max"] <= 1.0).sum()),
        worst_maximum=float((off["velocity_max"] / computed["velocity_max"]).max()),
        rise_times=int((off["rise_time"] <= printed["period"] / 2.0).sum()),
    )


def reproduce(units: str) -> report.Reproduction:
    """All 49 rows recomputed."""
    rows = appendix_e(units)
    agreeing = {name: agreement(rows, name)._asdict() for name in COLUMNS if name != "printed"}

    def show() -> None:
        _print_rows(rows, units)
        _print_reasons(rows)
        _print_agreement(agreeing)

    record = {"units": units, "rows": rows, "agreement": agreeing}
    table = _as_table(rows, units)
    return report.Reproduction("meyer_appendix_e", record, table, show, partial(_panels, rows))


def _panels(rows: Sequence[Mapping[str, Any]]) -> "report.Panels":
    """Figures 8 to 14 of the thesis, recomputed."""
    from escapement.plots import plot_configurations, plot_velocities
    from escapement.sources.meyer.figures import plot_appendix_e

    driver, follower = (inertia * INCH_POUND for inertia in INERTIAS[4])
    timer = Escapement(Geneva(4), Inertia(driver, follower), 0.10 * INCH_POUND, 0.35)
    return {
        "meyer_figure_8.png": lambda: plot_velocities(simulate(timer, engagements=5)),
        "meyer_figure_9.png": partial(plot_appendix_e, rows, 6),
        "meyer_figure_10.png": partial(plot_appendix_e, rows, 4),
        "meyer_figure_11.png": partial(plot_appendix_e, rows, 3),
        "meyer_figures_12_to_14.png": plot_configurations,
    }


def _compare(row: PrintedRun, units: str) -> dict[str, Any]:
    driver, follower = INERTIAS[row.slots]
    cell = PublishedCell(row.slots)
    run = (row.slots, row.friction, row.torque_inlbf, driver, follower)
    exact = _terminal(row, cell, INERTIAS)
    figures = {
        "printed": _figures(row),
        "as_published": exact,
        "program_1973": _figures(read_printout(program_1973(*run))),
        "true": _terminal(row, cell.geneva, INERTIAS),
    }
    # the same with the inertias of the heading, to show that they were not used
    headed = _terminal(row, cell, HEADINGS)
    torque_unit, inertia_unit = (INCH_POUND / factor(it, units) for it in ("torque", "inertia"))
    return {
        **{name: getattr(row, name) for name in PrintedRun._fields[:4]},
        "torque": row.torque_inlbf * torque_unit,
        "driver_inertia": driver * inertia_unit,
        "follower_inertia": follower * inertia_unit,
        **figures,
        "reasons": [*why(figures["printed"], exact, figures["true"], headed, run)],
    }


def _figures(source: Any) -> RunFigures:
    return {name: float(getattr(source, name)) for name in HALF_DIGIT}


def _terminal(
    row: PrintedRun, mechanism: Geneva | PublishedCell, inertias: Mapping[int, tuple[float, float]]
) -> RunFigures:
    """Figures of one row: without a load, speeds go as sqrt(torque), times as its inverse."""
    root = math.sqrt(row.torque_inlbf)
    figures = _at_unit_torque(mechanism, *inertias[row.slots], row.friction)
    return {
        name: value * (root if "velocity" in name else 1.0 / root)
        for name, value in figures.items()
    }


@cache
def _at_unit_torque(
    mechanism: Geneva | PublishedCell, driver: float, follower: float, mu: float
) -> RunFigures:
    """Exact figures at 1 in-lbf, one solve for all torques of a table."""
    inertia = Inertia(driver * INCH_POUND, follower * INCH_POUND)
    return _figures(terminal(Escapement(mechanism, inertia, INCH_POUND, mu)))


def _print_rows(rows: Sequence[Mapping[str, Any]], units: str) -> None:
    """One line a row; computed figures have a digit more than the thesis prints."""
    print("Meyer (1973), Appendix E: driver velocity [rad/s], rise time and period [s]\n")
    titles = [f"{title:^25}" for title in COLUMNS.values()]
    under = ["  max   min   rise period"] * len(COLUMNS)
    print(" | ".join([f"    slots   mu {'torque':>9}", *titles]).rstrip())
    print(" | ".join([f"row            {unit_name('torque', units):>9}", *under]))
    for number, row in enumerate(rows, 1):
        cells = [f"{number:>3} {row['slots']:>5} {row['friction']:.2f} {row['torque']:>9.4g}"]
        for column in COLUMNS:
            # what was computed is shown with one digit more
            finer = column != "printed"
            fields = [
                f"{row[column][name]:>{wide}.{digits + finer}f}" for name, wide, digits in _FIELDS
            ]
            cells.append(" ".join(fields))
        print(" | ".join(cells))


def _print_reasons(rows: Sequence[Mapping[str, Any]]) -> None:
    """Every kind of disagreement once, with the rows it explains and one in full."""
    kinds: dict[str, list[tuple[int, str]]] = {}
    for number, row in enumerate(rows, 1):
        for reason in row["reasons"]:
            # sentences that differ only in their numbers are of one kind
            kind = re.sub(r"\d[\d.e+-]*", "#", reason.partition(":")[0])
            kinds.setdefault(kind, []).append((number, reason))
    print("\nWhy printed figures differ, each with one row's numbers (all are in the JSON):")
    for found in kinds.values():
        numbers, (first, reason) = [number for number, _ in found], found[0]
        print(f"  {ranges(numbers)}; in row {first}, {reason}")


def ranges(numbers: Iterable[int]) -> str:
    """Ascending whole numbers as a reader writes them: rows 1-3, 5."""
    unique = sorted(set(numbers))
    # number less position is the same all along a run of neighbours
    runs = groupby(enumerate(unique), key=lambda pair: pair[1] - pair[0])
    spans = [[number for _, number in run] for _, run in runs]
    text = ", ".join(str(s[0]) if len(s) == 1 else f"{s[0]}-{s[-1]}" for s in spans)
    return f"row{'s' if len(unique) > 1 else ''} {text}"


def _print_agreement(agreeing: Mapping[str, dict[str, Any]]) -> None:
    header = ["of 49 rows", "period", "minimum", "maximum", "worst maximum", "rise time"]
    below = ["", "1 ms", "0.55 rad/s", "1 rad/s", "", "half a period"]
    print("\nHow many rows meet the printed figure within")
    rows = []
    for name, found in agreeing.items():
        worst = f"{100.0 * found['worst_maximum']:.1f} %"
        rows.append([*(found | {"rows": COLUMNS[name], "worst_maximum": worst}).values()])
    print_columns([header, below], rows)


def _as_table(rows: Sequence[Mapping[str, Any]], units: str) -> list[list[Any]]:
    """A header, then a line a row, with the system that torque and inertias are in."""
    plain = [name for name in rows[0] if name not in (*COLUMNS, "reasons")]
    header = [f"{column}_{name}" for column in COLUMNS for name in HALF_DIGIT]
    lines: list[list[Any]] = [[*plain, "units", *header, "reasons"]]
    for row in rows:
        figures = [row[column][name] for column in COLUMNS for name in HALF_DIGIT]
        lines.append([*(row[name] for name in plain), units, *figures, "; ".join(row["reasons"])])
    return lines
