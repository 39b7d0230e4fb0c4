"""Meyer's Appendix E: 49 printed runs beside what was computed and what is true.

The thesis prints tables for three mechanisms, but its program ran all of them
in the four-pin cell of 90 degrees, and the heading of the six-pin table has the
inertias swapped. `appendix_e` sets every printed row beside three
recomputations and names, by comparing them, what explains each difference.

"K in lb/rad" of the thesis is a constant torque in in-lbf, its inertias are in
in-lbf-s^2.
"""

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from escapement import validate
from escapement.mechanisms import Geneva
from escapement.model import Escapement, FloatArray, Inertia
from escapement.sources.meyer.program import program_1973, read_printout
from escapement.sources.meyer.published_cell import PublishedCell
from escapement.sources.meyer.reasons import (
    HALF_DIGIT,
    RunFigures,
    why_cell,
    why_extremes,
    why_inertias,
    why_times,
)
from escapement.sources.printed import read_table
from escapement.units import INCH_POUND, SYSTEMS, factor

INERTIAS = {3: (6e-6, 10e-6), 4: (3e-6, 50e-6), 6: (3e-6, 40e-6)}
"""Driver and follower inertia really used, by slots [in-lbf-s^2] (figures 9 to 11)."""
HEADINGS = {3: (10e-6, 6e-6), 4: (3e-6, 50e-6), 6: (3e-6, 40e-6)}
"""The same as the headings of Appendix E give them."""


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
        for pins, slots, *rest in read_table("meyer", "appendix_e.csv")
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
        `rise_time`, `period` [s], None where there is none. `reasons` explains
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

    def deviation(figure: str) -> FloatArray:
        pairs = [(row["printed"][figure], row[column][figure]) for row in rows]
        return np.array([np.inf if b is None else abs(a - b) for a, b in pairs])

    periods = np.array([row["printed"]["period"] for row in rows])
    maxima = deviation("velocity_max")
    solved = np.isfinite(maxima)
    size = np.array([row[column]["velocity_max"] or 1.0 for row in rows])
    return Agreement(
        rows=len(rows),
        periods=int((deviation("period") <= 1e-3).sum()),
        minima=int((deviation("velocity_min") <= 0.55).sum()),
        maxima=int((maxima <= 1.0).sum()),
        worst_maximum=float((maxima[solved] / size[solved]).max(initial=0.0)),
        rise_times=int((deviation("rise_time") <= periods / 2.0).sum()),
    )


def _compare(row: PrintedRun, units: str) -> dict[str, Any]:
    driver, follower = INERTIAS[row.slots]
    cell = PublishedCell(row.slots)
    run = (row.slots, row.friction, row.torque_inlbf, driver, follower)
    printed = _figures(row)
    exact = _terminal(row, cell, INERTIAS)
    true = _terminal(row, cell.geneva, INERTIAS)
    reasons = []
    if HEADINGS[row.slots] != INERTIAS[row.slots]:
        headed = _terminal(row, cell, HEADINGS)
        used = f"driver {driver:g} and follower {follower:g} in-lbf-s^2"
        reasons += why_inertias(printed, exact, headed, used)
    reasons += why_cell(printed, exact, true, math.degrees(cell.geneva.cell_angle))
    reasons += why_extremes(printed, exact, run)
    reasons += why_times(printed, exact)
    torque_unit, inertia_unit = (INCH_POUND / factor(q, units) for q in ("torque", "inertia"))
    return {
        "slots": row.slots,
        "pins": row.pins,
        "friction": row.friction,
        "torque_inlbf": row.torque_inlbf,
        "torque": row.torque_inlbf * torque_unit,
        "driver_inertia": driver * inertia_unit,
        "follower_inertia": follower * inertia_unit,
        "printed": printed,
        "as_published": exact,
        "program_1973": _figures(read_printout(program_1973(*run))),
        "true": true,
        "reasons": reasons,
    }


def _figures(source: Any) -> RunFigures:
    values = {name: float(getattr(source, name)) for name in HALF_DIGIT}
    return {name: value if math.isfinite(value) else None for name, value in values.items()}


def _terminal(
    row: PrintedRun, mechanism: Geneva | PublishedCell, inertias: Mapping[int, tuple[float, float]]
) -> RunFigures:
    """Figures of one row: without a load, speeds go as sqrt(torque), times as its inverse."""
    speed = math.sqrt(row.torque_inlbf)
    figures = _at_unit_torque(mechanism, *inertias[row.slots], row.friction)
    scale = {name: speed if "velocity" in name else 1.0 / speed for name in figures}
    return {name: None if value is None else value * scale[name] for name, value in figures.items()}


@cache
def _at_unit_torque(
    mechanism: Geneva | PublishedCell, driver: float, follower: float, mu: float
) -> RunFigures:
    """Exact figures at 1 in-lbf, one solve for all torques of a table."""
    from escapement.simulation import terminal  # its import is slow, printed rows need none

    inertia = Inertia(driver * INCH_POUND, follower * INCH_POUND)
    return _figures(terminal(Escapement(mechanism, inertia, INCH_POUND, mu)))
