"""Dijksman (1974): the gear-driven wheels of figures 6 to 9 and every slip, printed and true.

A printed number that is not right to its last digit was computed from a rounded ratio of times;
the right one of several possible roundings is found by testing which gives the printed digits.
"""

import math
from collections.abc import Iterator
from functools import cache, partial

import numpy as np

from escapement.mechanisms import GearDriven
from escapement.sources import report
from escapement.sources.report import Cell, gives, judge

COLUMNS = {"alpha": "alpha", "V": "V", "MC": "MC/R0", "M0C": "M0C/R0"}
"""Printed proportions and their names in a table; alpha in degrees."""
_LENGTHS = {"V": "motion_ratio", "MC": "arm_over_fixed", "M0C": "entry_radius_over_fixed"}
_HEADS = {"figure": "figure", "curve": "curve", "n": "stations", "m": "lobes"}
_HEADS |= {"k": "gear_ratio", "slots": "slots_printed"}


def captions() -> list[dict[str, str]]:
    """The captions of figures 6 to 9, as printed."""
    return report.read_table("dijksman", "figures.csv")


def mechanism(caption: dict[str, str]) -> GearDriven:
    """The mechanism that a caption names."""
    return GearDriven(int(caption["stations"]), int(caption["lobes"]), caption["curve"])


def true_values(wheel: GearDriven) -> dict[str, float]:
    """alpha [deg], V, MC/R0 and M0C/R0 of a mechanism with one pin."""
    lengths = {column: getattr(wheel, name) for column, name in _LENGTHS.items()}
    return {"alpha": math.degrees(wheel.alpha), **lengths}


def proportions() -> list[Cell]:
    """Every printed proportion, figure after figure."""
    cells = []
    for caption in captions():
        wheel, number = mechanism(caption), int(caption["figure"])
        for column, value in true_values(wheel).items():
            text = caption[column]
            if text == "M0M":  # the caption gives the name of a length, not its value
                agrees = math.isclose(value, wheel.carrier_over_fixed, rel_tol=1e-14)
                why = "" if agrees else report.UNEXPLAINED
                cells.append(Cell(number, column, text, f"{value:g}", value, why))
            else:
                rules = partial(_why, wheel, caption["V"], column)
                cells.append(judge(number, column, text, value, rules))
    return cells


@cache
def chart_mechanisms() -> tuple[GearDriven, ...]:
    """Hypocycloids and epicycloids of 3 to 24 stations and up to 12 lobes, with V < 1."""
    return tuple(
        GearDriven(stations, lobes, curve)
        for curve in ("hypocycloid", "epicycloid")
        for stations in range(3, 25)
        for lobes in np.arange(0.0, 12.5, 0.5).tolist()
        # a hypocycloid with this many lobes leaves no dwell
        if curve == "epicycloid" or 2 * (lobes + 2) < stations
    )


def reproduce(units: str | None = None) -> report.Reproduction:
    """The captions recomputed: pure numbers and angles, independent of the units."""
    cells, slips = proportions(), report.read_slips("dijksman")
    heads = {}
    for caption in captions():
        wheel, number = mechanism(caption), int(caption["figure"])
        heads[number] = {
            "figure": number, "curve": wheel.curve, "stations": wheel.stations,
            "lobes": int(caption["lobes"]), "gear_ratio": float(wheel.gear_ratio),
            "slots": wheel.slots, "slots_printed": int(caption["slots"]),
        }  # fmt: skip
    record = report.compare(cells, slips, heads, {"alpha": "alpha_deg", **_LENGTHS})

    def show() -> None:
        print("Dijksman (1974), figures 6 to 9: printed, and below it true; * differs\n")
        report.print_side_by_side(_HEADS, COLUMNS, record["rows"], cells)
        report.print_errata(cells, "numbers", "figure {}, {}", COLUMNS, slips)

    lines = report.as_table(cells, "figure")
    return report.Reproduction("dijksman_figures", record, lines, show, _panels)


def _panels() -> report.Panels:
    """Figure 2, figures 6 to 9, the design charts, and motions beside the ordinary wheel's."""
    from escapement.plots import gear_driven
    from escapement.sources.dijksman import dijksman_figures

    return {
        "dijksman_figure_2": gear_driven.plot_curves,
        "dijksman_figures_6_to_9": gear_driven.plot_gear_driven_examples,
        "dijksman_charts": dijksman_figures.plot_design_charts,
        "dijksman_motions": dijksman_figures.plot_motions,
    }


def _why(wheel: GearDriven, ratio: str, column: str, printed: str, value: float) -> Iterator[str]:
    """Rounded ratios of times that give the printed number."""
    # the ratio with the printed number of places, or with four
    for decimals in (len(ratio.partition(".")[2]), 4):
        rounded = round(wheel.motion_ratio, decimals)
        # a ratio may itself be too great by a unit of its last digit
        for off in (0.0, 10.0**-decimals):
            made = _from_ratio(wheel, rounded + off)[column]
            if gives(printed, made):
                how = f"a unit in the last digit above {rounded:g}" if off else "rounded"
                yield f"computed from V = {rounded + off:.{decimals}f}, {how}: {made:.6g}"


def _from_ratio(wheel: GearDriven, ratio: float) -> dict[str, float]:
    """Proportions as (9) and (15) give them from a ratio of times."""
    # k is negative for an epicycloid, and alpha is not
    k = float(wheel.gear_ratio)
    alpha = 2.0 * math.pi * ratio / abs(k)
    end = alpha + 2.0 * math.pi / wheel.stations
    arm = abs(math.sin(end) / (2.0 * math.sin(0.5 * k * alpha)))
    return dict(zip(COLUMNS, (math.degrees(alpha), ratio, arm, math.cos(0.5 * end)), strict=True))
