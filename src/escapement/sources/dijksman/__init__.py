"""Dijksman (1974): the gear-driven wheels of figures 6 to 9, printed against computed.

A printed number that is not right to its last digit was computed from a rounded ratio of
times: which one is found by trying.
"""

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from escapement.mechanisms import GearDriven
from escapement.sources import report
from escapement.sources.dijksman.slips import equations, start_ratios
from escapement.sources.printed import UNEXPLAINED, Cell, Digits, judge, read_table
from escapement.text import words

COLUMNS = {"alpha": "alpha", "V": "V", "MC": "MC/R0", "M0C": "M0C/R0"}
"""Printed proportions and what a table calls them; alpha in degrees."""
_LENGTHS = {"V": "motion_ratio", "MC": "arm_over_fixed", "M0C": "entry_radius_over_fixed"}
_HEADS = {
    **{name: name for name in ("figure", "curve")},
    **{"n": "stations", "m": "lobes", "k": "gear_ratio", "slots": "slots_printed"},
}


def captions() -> list[dict[str, str]]:
    """The captions of figures 6 to 9, as printed."""
    return read_table("dijksman", "figures.csv")


def mechanism(caption: dict[str, str]) -> GearDriven:
    """The mechanism that a caption names."""
    return GearDriven(int(caption["stations"]), int(caption["lobes"]), caption["curve"])


def proportions() -> list[Cell]:
    """Every printed proportion, figure after figure."""
    return [_compare(caption, column) for caption in captions() for column in COLUMNS]


def right_values(wheel: GearDriven) -> dict[str, float]:
    """alpha [deg], V, MC/R0 and M0C/R0 of a mechanism with one pin."""
    lengths = {column: getattr(wheel, name) for column, name in _LENGTHS.items()}
    return {"alpha": math.degrees(wheel.alpha), **lengths}


def reproduce(units: str) -> report.Reproduction:
    """The captions recomputed: pure numbers and angles, whatever the units."""
    cells, slips = proportions(), equations()
    ratios = {name: start_ratios(name == "per_cycle") for name in ("per_cycle", "per_motion")}
    rows = [_as_row(caption, cells) for caption in captions()]
    record = {"rows": rows, **report.counts(cells, slips), "start_ratios": ratios}

    def show() -> None:
        print("Dijksman (1974), figures 6 to 9: printed, and below it computed; * differs\n")
        beside = [
            ([row[key] for key in _HEADS.values()], _of_figure(row["figure"], cells))
            for row in rows
        ]
        report.print_side_by_side([*_HEADS], COLUMNS.values(), beside)
        report.print_errata(cells, "numbers", lambda it: f"figure {it.place}, {COLUMNS[it.column]}")
        report.print_slips(slips, "all wheels of the design charts")
        print("\nAcceleration at the start over an ordinary wheel's of as many stations, extremes:")
        for name, (least, greatest) in ratios.items():
            text = f"{words(name).removeprefix('per ')}s of the same time"
            print(f"  {text:<27}{least:.3f} to {greatest:.3f}")

    lines = report.as_table(cells, "figure")
    return report.Reproduction("dijksman_figures", record, lines, show, _panels)


def _panels() -> "report.Panels":
    """Figure 2, figures 6 to 9, the design charts, and motions beside the ordinary wheel's."""
    from escapement.plots import gear_driven
    from escapement.sources.dijksman import figures

    return {
        "dijksman_figure_2.png": gear_driven.plot_curves,
        "dijksman_figures_6_to_9.png": gear_driven.plot_gear_driven_examples,
        "dijksman_charts.png": figures.plot_design_charts,
        "dijksman_motions.png": figures.plot_motions,
    }


def _of_figure(number: int, cells: Sequence[Cell]) -> list[Cell]:
    return [cell for cell in cells if cell.place == number]


def _as_row(caption: dict[str, str], cells: Sequence[Cell]) -> dict[str, Any]:
    """A figure for JSON."""
    wheel, number = mechanism(caption), int(caption["figure"])
    return {
        "figure": number,
        "curve": caption["curve"],
        "stations": wheel.stations,
        "lobes": int(caption["lobes"]),
        "gear_ratio": float(wheel.gear_ratio),
        "slots": wheel.slots,
        "slots_printed": int(caption["slots"]),
        **report.side_by_side(_of_figure(number, cells), {"alpha": "alpha_deg", **_LENGTHS}),
    }


def _compare(caption: dict[str, str], column: str) -> Cell:
    wheel, number, text = mechanism(caption), int(caption["figure"]), caption[column]
    value = right_values(wheel)[column]
    if text == "M0M":  # the caption gives the name of a length, not its value
        agrees = math.isclose(value, wheel.carrier_over_fixed, rel_tol=1e-14)
        return Cell(number, column, text, f"{value:g}", value, "" if agrees else UNEXPLAINED)
    return judge(number, column, text, value, partial(_why, wheel, caption["V"], column))


def _why(
    wheel: GearDriven, ratio: str, column: str, printed: Digits, right: Digits
) -> Iterator[str]:
    """Rounded ratios of times that give the printed number."""
    # the ratio with as many places as are printed, or with four
    for places in (len(ratio.partition(".")[2]), 4):
        rounded = round(wheel.motion_ratio, places)
        # a ratio may itself be a unit of its last digit too great
        for off in (0.0, 10.0**-places):
            made = _from_ratio(wheel, rounded + off)[column]
            if printed.like(made).value == printed.value:
                how = f"a unit in the last digit above {rounded:g}" if off else "rounded"
                yield f"computed from V = {rounded + off:.{places}f}, {how}: {made:.6g}"


def _from_ratio(wheel: GearDriven, ratio: float) -> dict[str, float]:
    """Proportions as (9) and (15) give them from a ratio of times."""
    # k is negative for an epicycloid, and alpha is not
    k = float(wheel.gear_ratio)
    alpha = 2.0 * math.pi * ratio / abs(k)
    end = alpha + 2.0 * math.pi / wheel.stations
    return {
        "alpha": math.degrees(alpha),
        "V": ratio,
        "MC": abs(math.sin(end) / (2.0 * math.sin(0.5 * k * alpha))),
        "M0C": math.cos(0.5 * end),
    }
