"""Table I and the figures of Filemon (1960): cells, errata, equations, nomograms."""

import csv
import io
from pathlib import Path
from typing import Any

from escapement.cli import _files, _output
from escapement.published.filemon import COLUMNS, Cell, as_rows, mean_torque_error, table_1
from escapement.published.filemon_equations import EquationErratum, equations

_NAME = "filemon_table_1"


def reproduce(folder: Path | None, as_json: bool, units: str) -> dict[str, Any]:
    """Recompute all 48 cells; print them, and write them with figures to `folder`.

    Everything in Table I is a pure number or an angle, whatever the units.
    """
    cells, slips = table_1(), equations()
    record = {
        "rows": as_rows(cells),
        "cells": len(cells),
        "agreeing": sum(cell.agrees for cell in cells),
        "equations": [vars(slip) for slip in slips],
        "mean_torque_error": mean_torque_error(),
    }
    if folder is not None:
        _files.write_text(folder / f"{_NAME}.json", _output.as_json(record))
        _files.write_text(folder / f"{_NAME}.csv", _as_csv(cells))
        _draw(folder)
        _output.note(f"table and figures in {folder}")
    if not as_json:
        _print_cells(cells)
        _print_errata(cells)
        _print_equations(slips)
        print(
            "\nMean torque (10) against quadrature, n = 3 to 100: greatest relative difference "
            f"{record['mean_torque_error']:.1e}"
        )
    return record


def _print_cells(cells: list[Cell]) -> None:
    """Printed over computed, a star at what is wrong."""
    print("Filemon (1960), Table I: printed, and below it computed; * differs\n")
    header = [["n", "", *(f"{name} " for name in COLUMNS.values())]]
    rows: list[list[str]] = []
    for n in dict.fromkeys(cell.slots for cell in cells):
        row = [cell for cell in cells if cell.slots == n]
        rows.append([str(n), "printed", *(cell.printed + " " for cell in row)])
        computed = [cell.right + (" " if cell.agrees else "*") for cell in row]
        rows.append(["", "computed", *computed])
    _output.print_columns(header, rows)


def _print_errata(cells: list[Cell]) -> None:
    wrong = [cell for cell in cells if not cell.agrees]
    print(
        f"\n{len(cells) - len(wrong)} of {len(cells)} cells are right to their last digit. Errata:"
    )
    for cell in wrong:
        name = COLUMNS[cell.column]
        print(f"  n = {cell.slots}, {name}: {cell.printed} must be {cell.right}")
        print(f"      {cell.reason}")


def _print_equations(slips: list[EquationErratum]) -> None:
    print(
        "\nSlips in equations and text, some perhaps the scan's, with the greatest relative error"
    )
    print("of the printed and of the corrected formula for 3 to 10 slots:")
    for slip in slips:
        print(f"  {slip.place}: {slip.printed}")
        error = ""
        if slip.printed_error is not None and slip.right_error is not None:
            error = f"  [{slip.printed_error:.2g}; corrected {slip.right_error:.0e}]"
        print(f"      must be {slip.right}{error}")


def _as_csv(cells: list[Cell]) -> str:
    """A line a cell."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["slots", "column", "printed", "right", "computed", "agrees", "reason"])
    for cell in cells:
        writer.writerow(
            [
                cell.slots, cell.column, cell.printed, cell.right, repr(cell.value),
                "yes" if cell.agrees else "no", cell.reason,
            ]
        )  # fmt: skip
    return text.getvalue()


def _draw(folder: Path) -> None:
    """Figures 3 to 12 and 15; the nomograms 13 and 16, to be printed, as PDF."""
    from escapement.plots import filemon, filemon_reversals, save
    from escapement.plots.nomograms import SHEETS, plot_nomogram

    panels: dict[int, Any] = {
        3: filemon.plot_transmission,
        4: filemon.plot_transmission_family,
        5: filemon.plot_acceleration,
        6: filemon.plot_acceleration_family,
        7: filemon.plot_torque_terms,
        9: filemon_reversals.plot_reversal_curve,
        10: filemon_reversals.plot_reversal_curves,
        11: filemon_reversals.plot_reversal_limits,
        12: filemon_reversals.plot_mean_factors,
        15: filemon_reversals.plot_maximum_angles,
    }
    for number, plot in panels.items():
        _files.save_axes(plot(), folder / f"filemon_figure_{number}.png")
    save(filemon.plot_zones(), folder / "filemon_figure_8.png")
    for name, sheet in SHEETS.items():
        save(plot_nomogram(sheet), folder / f"filemon_figure_{name}.pdf")
