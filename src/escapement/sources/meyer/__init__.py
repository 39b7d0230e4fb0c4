"""Meyer (1973), Appendix E: 49 printed runs beside three recomputations, one of them true.

The thesis prints tables for three mechanisms, but its program ran all of them
in the four-pin cell of 90 degrees, and the heading of the six-pin table has the
inertias swapped. `appendix_e` compares every printed row with three recomputations and finds from
them the explanation of each difference.

"K in lb/rad" of the thesis is a constant torque in in-lbf, its inertias are in
in-lbf-s^2.

- `program`, `listing`: the program of 1973 as printed
- `reasons`: why printed figures differ
- `meyer_figures`: its figures 9 to 11
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, partial
from itertools import groupby
from typing import Any, NamedTuple

from escapement.base import validate
from escapement.base.text import print_columns
from escapement.base.units import INCH_POUND, SYSTEMS, factor, spelt, unit_name
from escapement.engines.simulate import simulate, terminal
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import Mechanism
from escapement.model.escapement import Escapement, Inertia
from escapement.sources import report
from escapement.sources.meyer.program import PublishedCell, program_1973, read_printout
from escapement.sources.meyer.reasons import HALF_DIGIT, RunFigures, why

INERTIAS = {3: (6e-6, 10e-6), 4: (3e-6, 50e-6), 6: (3e-6, 40e-6)}
"""Driver and follower inertia really used, by slots [in-lbf-s^2] (figures 9 to 11)."""
HEADINGS = {3: (10e-6, 6e-6), 4: (3e-6, 50e-6), 6: (3e-6, 40e-6)}
"""The same as the headings of Appendix E give them."""
UNITS = "in-lbf-s"
"""The units of the thesis."""
COLUMNS = {
    "printed": ("printed", "what stands in the thesis"),
    "as_published": (
        "as published", "exact solution of what its program was given, the 90-degree cell included"
    ),
    "program_1973": ("program of 1973", "that program run again, with a row every 0.5 ms"),
    "true": ("true", "exact solution of the real mechanism"),
}  # fmt: skip
"""The columns: their names in reports and legends, and their meanings."""

_HEADS = {"maximum": "rad/s", "minimum": "rad/s", "rise time": "s", "period": "s"}
_DECIMALS = [round(-math.log10(2.0 * half)) for half in HALF_DIGIT.values()]


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
    """How many of `rows` printed rows agree with one recomputation."""

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
        for pins, slots, *rest in map(dict.values, report.read_table("meyer", "appendix_e.csv"))
    )


def appendix_e(units: str = UNITS) -> list[dict[str, Any]]:
    """Every printed row beside its recomputations.

    Parameters
    ----------
    units : str
        "in-lbf-s" or "SI": the system of `torque`, `driver_inertia` and
        `follower_inertia` in the answer; `torque_inlbf` is there in both.

    Returns
    -------
    list of dict
        49 rows. `printed`, `as_published`, `program_1973` and `true`, as `COLUMNS`
        defines them, each hold `velocity_max`, `velocity_min` [rad/s], `rise_time`,
        `period` [s]. `reasons` explains differences of more than half a printed digit, one
        sentence for each cause.
    """
    validate.choice("units", units, SYSTEMS)
    return [_compare(row, units) for row in printed_rows()]


def agreement(rows: Sequence[Mapping[str, Any]], column: str = "as_published") -> Agreement:
    """Count how many printed figures agree with one recomputation.

    Parameters
    ----------
    rows : sequence of dict
        As `appendix_e` returns them.
    column : str
        "as_published", "program_1973" or "true".
    """

    def off(row: Mapping[str, Any], name: str) -> float:
        return float(abs(row["printed"][name] - row[column][name]))

    within = {"period": 1e-3, "velocity_min": 0.55, "velocity_max": 1.0}
    counts = [sum(off(row, name) <= most for row in rows) for name, most in within.items()]
    worst = max(off(row, "velocity_max") / row[column]["velocity_max"] for row in rows)
    risen = sum(off(row, "rise_time") <= row["printed"]["period"] / 2.0 for row in rows)
    return Agreement._make([len(rows), *counts, worst, risen])


def reproduce(units: str | None = None) -> report.Reproduction:
    """All 49 rows recomputed; torques and inertias in the units of the thesis, or in others."""
    units = units or UNITS
    rows = appendix_e(units)
    agreeing = {name: agreement(rows, name)._asdict() for name in COLUMNS if name != "printed"}
    slips = report.read_slips("meyer")

    def show() -> None:
        _print_rows(rows, units)
        _print_reasons(rows)
        _print_agreement(agreeing)
        report.print_slips(slips)

    record = {"units": units, "rows": rows, "agreement": agreeing}
    record["equations"] = [vars(slip) for slip in slips]
    lines = [_as_line(row, units) for row in rows]
    table = [[*lines[0]], *([*line.values()] for line in lines)]
    return report.Reproduction("meyer_appendix_e", record, table, show, partial(_panels, rows))


def _panels(rows: Sequence[Mapping[str, Any]]) -> report.Panels:
    """Figures 8 to 14 of the thesis, recomputed."""
    from escapement.plots import plot_configurations, plot_velocities
    from escapement.sources.meyer.meyer_figures import plot_appendix_e

    inertia = Inertia(*(value * INCH_POUND for value in INERTIAS[4]))
    timer = Escapement(Geneva(4), inertia, 0.10 * INCH_POUND, 0.35)
    return {
        "meyer_figure_8": lambda: plot_velocities(simulate(timer, engagements=5)),
        "meyer_figure_9": partial(plot_appendix_e, rows, 6),
        "meyer_figure_10": partial(plot_appendix_e, rows, 4),
        "meyer_figure_11": partial(plot_appendix_e, rows, 3),
        "meyer_figures_12_to_14": plot_configurations,
    }


def _compare(row: PrintedRun, units: str) -> dict[str, Any]:
    inertias, cell = INERTIAS[row.slots], PublishedCell(row.slots)
    run = (row.slots, row.friction, row.torque_inlbf, *inertias)
    printed, program = map(_figures, (row, read_printout(program_1973(*run))))
    exact, true = (_terminal(row, mechanism, *inertias) for mechanism in (cell, cell.geneva))
    # the same with the inertias of the heading, to show that they were not used
    headed = _terminal(row, cell, *HEADINGS[row.slots])
    torque_unit = INCH_POUND / factor("torque", units)  # the unit of torques and of inertias
    return {
        **{name: getattr(row, name) for name in PrintedRun._fields[:4]},
        "torque": row.torque_inlbf * torque_unit,
        "driver_inertia": inertias[0] * torque_unit,
        "follower_inertia": inertias[1] * torque_unit,
        **dict(zip(COLUMNS, (printed, exact, program, true), strict=True)),
        "reasons": [*why(printed, exact, true, headed, run)],
    }


def _figures(source: Any) -> RunFigures:
    return {name: float(getattr(source, name)) for name in HALF_DIGIT}


def _terminal(row: PrintedRun, mechanism: Mechanism, *inertias: float) -> RunFigures:
    """Exact figures of one row."""
    inertia = Inertia(*(value * INCH_POUND for value in inertias))
    torque = row.torque_inlbf * INCH_POUND
    return _figures(terminal(Escapement(mechanism, inertia, torque, row.friction)))


def _print_rows(rows: Sequence[Mapping[str, Any]], units: str) -> None:
    """A line for each of `COLUMNS`; recomputed figures have a digit more than printed ones."""
    print("Meyer (1973), Appendix E: velocity of the driver, rise time and period\n")
    for title, meaning in COLUMNS.values():
        print(f"  {title:<17}{meaning}")
    print()
    header = ["row", "slots", "friction", "torque", "", *_HEADS]
    below = ["", "", "", spelt(unit_name("torque", units)), "", *_HEADS.values()]
    lines = []
    for number, row in enumerate(rows, 1):
        run = [str(number), row["slots"], f"{row['friction']:.2f}", f"{row['torque']:.4g}"]
        for name, (title, _) in COLUMNS.items():
            more = name != "printed"
            pairs = zip(row[name].values(), _DECIMALS, strict=True)
            lines.append([*run, title, *(f"{value:.{most + more}f}" for value, most in pairs)])
            run = [""] * len(run)
    print_columns([header, below], lines)


def _print_reasons(rows: Sequence[Mapping[str, Any]]) -> None:
    """Every kind of disagreement once, with the rows it explains and one in full."""
    kinds: dict[str, dict[int, str]] = {}
    for number, row in enumerate(rows, 1):
        for reason in row["reasons"]:
            # sentences that differ only in their numbers are of one kind
            kind = re.sub(r"\d[\d.e+-]*", "#", reason.partition(":")[0])
            kinds.setdefault(kind, {}).setdefault(number, reason)
    print("\nWhy printed figures differ, each with one row's numbers (all are in the JSON):")
    for found in kinds.values():
        first, reason = next(iter(found.items()))
        report.say(
            f"  row{'s' if len(found) > 1 else ''} {ranges(found)}; in row {first}, {reason}"
        )


def ranges(numbers: Iterable[int]) -> str:
    """Ascending whole numbers as a reader writes them: 1-3, 5."""
    # number less position is the same all along a run of neighbours
    runs = groupby(enumerate(numbers), key=lambda pair: pair[1] - pair[0])
    spans = [[number for _, number in run] for _, run in runs]
    return ", ".join(str(s[0]) if len(s) == 1 else f"{s[0]}-{s[-1]}" for s in spans)


def _print_agreement(agreeing: Mapping[str, dict[str, Any]]) -> None:
    header = ["of 49 rows", "period", "minimum", "maximum", "worst maximum", "rise time"]
    below = ["", "1 ms", "0.55 rad/s", "1 rad/s", "", "half a period"]
    print("\nHow many rows meet the printed figure within")
    lines = []
    for name, found in agreeing.items():
        _, *counts, worst, rise = found.values()
        lines.append([COLUMNS[name][0], *counts, f"{100.0 * worst:.1f} %", rise])
    print_columns([header, below], lines)


def _as_line(row: Mapping[str, Any], units: str) -> dict[str, Any]:
    """A row for CSV, with the system that torque and inertias are in."""
    plain = {name: row[name] for name in row if name not in (*COLUMNS, "reasons")}
    figures = {f"{column}_{name}": row[column][name] for column in COLUMNS for name in HALF_DIGIT}
    return {**plain, "units": units, **figures, "reasons": "; ".join(row["reasons"])}
