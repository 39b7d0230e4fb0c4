"""Dijksman (1974): figures 6 to 9, errata, cognates, and the wheels that never rest."""

from pathlib import Path
from typing import Any

from escapement.sources.dijksman.captions import COLUMNS, Proportion, as_rows, proportions
from escapement.sources.dijksman.slips import equations, start_ratios
from escapement.sources.reproduction import (
    Reproduction,
    as_table,
    print_equations,
    print_errata,
)
from escapement.text import print_columns, show, words


def reproduce(units: str) -> Reproduction:
    """The captions recomputed: pure numbers and angles, whatever the units."""
    cells, slips = proportions(), equations()
    ratios = {
        "per_cycle": start_ratios(per_cycle=True),
        "per_motion": start_ratios(per_cycle=False),
    }
    record: dict[str, Any] = {
        "rows": as_rows(cells),
        "cells": len(cells),
        "agreeing": sum(cell.agrees for cell in cells),
        "equations": [vars(slip) for slip in slips],
        "start_ratios": ratios,
        "message": "printed_error and right_error are null where a slip is a matter of words",
    }

    def show() -> None:
        _print_figures(record["rows"], cells)
        print_errata(cells, "numbers", lambda it: f"figure {it.figure}, {COLUMNS[it.column]}")
        print(
            "\nSlips in equations and text, some perhaps the scan's, with the greatest error of "
            "the\nprinted and of the corrected formula over the design charts:"
        )
        print_equations(slips)
        print(
            "\nAcceleration with which a gear-driven wheel starts, over that of the ordinary wheel "
            "of as many\nstations, least and greatest over the design charts:"
        )
        for name, (least, greatest) in ratios.items():
            text = f"{words(name).removeprefix('per ')}s of the same time"
            print(f"  {text:<27}{least:.3f} to {greatest:.3f}")

    return Reproduction("dijksman_figures", record, as_table(cells, "figure"), show, _draw)


def _print_figures(rows: list[dict[str, Any]], cells: list[Proportion]) -> None:
    """Printed over computed, a star at what is wrong."""
    print("Dijksman (1974), figures 6 to 9: printed, and below it computed; * differs\n")
    names = ["figure", "curve", "n", "m", "k", "slots", "", *(f"{c} " for c in COLUMNS.values())]
    lines: list[list[str]] = []
    for row in rows:
        own = [cell for cell in cells if cell.figure == row["figure"]]
        keys = ("figure", "curve", "stations", "lobes", "gear_ratio", "slots_printed")
        head = [show(row[key]) for key in keys]
        lines.append([*head, "printed", *(cell.printed + " " for cell in own)])
        computed = [cell.right + (" " if cell.agrees else "*") for cell in own]
        lines.append([*[""] * 5, str(row["slots"]), "computed", *computed])
    print_columns([names], lines)


def _draw(folder: Path) -> None:
    """Figure 2, figures 6 to 9, the design charts, and motions beside the ordinary wheel's."""
    from escapement.plots import gear_driven, save
    from escapement.sources.dijksman import charts

    save(gear_driven.plot_curves(), folder / "dijksman_figure_2.png")
    save(gear_driven.plot_gear_driven_examples(), folder / "dijksman_figures_6_to_9.png")
    save(charts.plot_design_charts(), folder / "dijksman_charts.png")
    save(charts.plot_motions(), folder / "dijksman_motions.png")
