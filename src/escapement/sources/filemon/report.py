"""Table I and the figures of Filemon (1960): cells, errata, equations, nomograms."""

from pathlib import Path
from typing import Any

from escapement.sources.filemon.cells import COLUMNS, TableCell, as_rows, mean_torque_error, table_1
from escapement.sources.filemon.slips import equations
from escapement.sources.reproduction import (
    Reproduction,
    as_table,
    print_equations,
    print_errata,
)
from escapement.text import print_columns


def reproduce(units: str) -> Reproduction:
    """All 48 cells recomputed: pure numbers and angles, whatever the units."""
    cells, slips, error = table_1(), equations(), mean_torque_error()
    record = {
        "rows": as_rows(cells),
        "cells": len(cells),
        "agreeing": sum(cell.agrees for cell in cells),
        "equations": [vars(slip) for slip in slips],
        "mean_torque_error": error,
        "message": "printed_error and right_error are null where a slip is a matter of words",
    }

    def show() -> None:
        _print_cells(cells)
        print_errata(cells, "cells", lambda cell: f"n = {cell.slots}, {COLUMNS[cell.column]}")
        print(
            "\nSlips in equations and text, some perhaps the scan's, with the greatest relative "
            "error\nof the printed and of the corrected formula for 3 to 10 slots:"
        )
        print_equations(slips)
        print(
            "\nMean torque (10) against quadrature, n = 3 to 100: greatest relative difference "
            f"{error:.1e}"
        )

    return Reproduction("filemon_table_1", record, as_table(cells, "slots"), show, _draw)


def _print_cells(cells: list[TableCell]) -> None:
    """Printed over computed, a star at what is wrong."""
    print("Filemon (1960), Table I: printed, and below it computed; * differs\n")
    header = [["n", "", *(f"{name} " for name in COLUMNS.values())]]
    rows: list[list[str]] = []
    for n in dict.fromkeys(cell.slots for cell in cells):
        row = [cell for cell in cells if cell.slots == n]
        rows.append([str(n), "printed", *(cell.printed + " " for cell in row)])
        computed = [cell.right + (" " if cell.agrees else "*") for cell in row]
        rows.append(["", "computed", *computed])
    print_columns(header, rows)


def _draw(folder: Path) -> None:
    """Figures 3 to 12 and 15; the nomograms 13 and 16, to be printed, as PDF."""
    from escapement.plots import save
    from escapement.sources.filemon import figures, reversal_figures
    from escapement.sources.filemon.nomograms import NOMOGRAMS, plot_nomogram

    panels: dict[int, Any] = {
        3: figures.plot_transmission,
        4: figures.plot_transmission_family,
        5: figures.plot_acceleration,
        6: figures.plot_acceleration_family,
        7: figures.plot_torque_terms,
        9: reversal_figures.plot_reversal_curve,
        10: reversal_figures.plot_reversal_curves,
        11: reversal_figures.plot_reversal_limits,
        12: reversal_figures.plot_mean_factors,
        15: reversal_figures.plot_maximum_angles,
    }
    for number, plot in panels.items():
        save(plot(), folder / f"filemon_figure_{number}.png")
    save(figures.plot_zones(), folder / "filemon_figure_8.png")
    for name, sheet in NOMOGRAMS.items():
        save(plot_nomogram(sheet), folder / f"filemon_figure_{name}.pdf")
