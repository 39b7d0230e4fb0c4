"""Dijksman (1974): figures 6 to 9, errata, cognates, and the wheels that never rest."""

import csv
import io
from pathlib import Path
from typing import Any

from escapement.cli import _files, _output
from escapement.published.dijksman import COLUMNS, Proportion, as_rows, proportions
from escapement.published.dijksman_equations import equations, start_ratios
from escapement.published.filemon_equations import EquationErratum

_NAME = "dijksman_figures"


def reproduce(folder: Path | None, as_json: bool, units: str) -> dict[str, Any]:
    """Recompute the captions; print them, and write them with figures to `folder`.

    Every printed proportion is a pure number or an angle, whatever the units.
    """
    cells, slips = proportions(), equations()
    record: dict[str, Any] = {
        "rows": as_rows(cells),
        "cells": len(cells),
        "agreeing": sum(cell.agrees for cell in cells),
        "equations": [vars(slip) for slip in slips],
        "start_ratios": {
            "per_cycle": list(start_ratios(per_cycle=True)),
            "per_motion": list(start_ratios(per_cycle=False)),
        },
    }
    if folder is not None:
        _files.write_text(folder / f"{_NAME}.json", _output.as_json(record))
        _files.write_text(folder / f"{_NAME}.csv", _as_csv(cells))
        _draw(folder)
        _output.note(f"table and figures in {folder}")
    if not as_json:
        _print_figures(record["rows"], cells)
        _print_errata(cells)
        _print_equations(slips)
        print(
            "\nAcceleration with which a gear-driven wheel starts, over that of the ordinary wheel "
            "of as many\nstations, least and greatest over the design charts:"
        )
        for name, (least, greatest) in record["start_ratios"].items():
            text = f"{_output.words(name).removeprefix('per ')}s of the same time"
            print(f"  {text:<27}{least:.3f} to {greatest:.3f}")
    return record


def _print_figures(rows: list[dict[str, Any]], cells: list[Proportion]) -> None:
    """Printed over computed, a star at what is wrong."""
    print("Dijksman (1974), figures 6 to 9: printed, and below it computed; * differs\n")
    names = ["figure", "curve", "n", "m", "k", "slots", "", *(f"{c} " for c in COLUMNS.values())]
    lines: list[list[str]] = []
    for row in rows:
        own = [cell for cell in cells if cell.figure == row["figure"]]
        keys = ("figure", "curve", "stations", "lobes", "gear_ratio", "slots_printed")
        head = [_output.show(row[key]) for key in keys]
        lines.append([*head, "printed", *(cell.printed + " " for cell in own)])
        computed = [cell.right + (" " if cell.agrees else "*") for cell in own]
        lines.append([*[""] * 5, str(row["slots"]), "computed", *computed])
    _output.print_columns([names], lines)


def _print_errata(cells: list[Proportion]) -> None:
    wrong = [cell for cell in cells if not cell.agrees]
    right = len(cells) - len(wrong)
    print(f"\n{right} of {len(cells)} numbers are right to their last digit. Errata:")
    for cell in wrong:
        name = COLUMNS[cell.column]
        print(f"  figure {cell.figure}, {name}: {cell.printed} must be {cell.right}")
        print(f"      {cell.reason}")


def _print_equations(slips: list[EquationErratum]) -> None:
    print("\nSlips in equations and text, some perhaps the scan's, with the greatest error of the")
    print("printed and of the corrected formula over the design charts:")
    for slip in slips:
        print(f"  {slip.place}: {slip.printed}")
        error = ""
        if slip.printed_error is not None and slip.right_error is not None:
            error = f"  [{slip.printed_error:.2g}; corrected {slip.right_error:.0e}]"
        print(f"      must be {slip.right}{error}")


def _as_csv(cells: list[Proportion]) -> str:
    """A line a number."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["figure", "column", "printed", "right", "computed", "agrees", "reason"])
    for cell in cells:
        writer.writerow(
            [
                cell.figure, cell.column, cell.printed, cell.right, repr(cell.value),
                "yes" if cell.agrees else "no", cell.reason,
            ]
        )  # fmt: skip
    return text.getvalue()


def _draw(folder: Path) -> None:
    """Figure 2, figures 6 to 9, the design charts, and motions beside the ordinary wheel's."""
    from escapement.plots import gear_charts, gear_driven, save

    save(gear_driven.plot_curves(), folder / "dijksman_figure_2.png")
    save(gear_driven.plot_gear_driven_examples(), folder / "dijksman_figures_6_to_9.png")
    save(gear_charts.plot_design_charts(), folder / "dijksman_charts.png")
    save(gear_charts.plot_motions(), folder / "dijksman_motions.png")
