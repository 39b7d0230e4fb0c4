"""The drive, table 1 and the statistics of Prikhodko (2020), printed against computed."""

from pathlib import Path
from typing import Any

from escapement.sources import prikhodko
from escapement.sources.reproduction import Reproduction
from escapement.text import words
from escapement.units import degrees

_NAME = "prikhodko"


def reproduce(units: str) -> Reproduction:
    """What can be recomputed; lengths in millimetres as printed, whatever the units."""
    rows = prikhodko.table()
    mechanism = prikhodko.drive()
    judged = [row for row in rows if row.right is not None]
    record: dict[str, Any] = {
        "rows": [vars(row) | {"agrees": row.agrees} for row in rows],
        "judged": len(judged),
        "agreeing": sum(row.agrees for row in judged),
        "errata": [vars(slip) for slip in prikhodko.ERRATA],
        "stop_interval_deg": degrees(mechanism.cell_angle),
        "output_per_stop_deg": -degrees(mechanism.follower_step),
        "transmission_max": mechanism.ratio_max,
        "position_function_error": prikhodko.position_function_error(),
        "pitch_curve_slip": prikhodko.pitch_curve_slip(),
        "message": "right and value are null where a number follows from nothing printed",
    }
    return Reproduction(_NAME, record, _as_table(rows), lambda: _print(rows, record), _draw)


def _print(rows: list[prikhodko.PrintedValue], record: dict[str, Any]) -> None:
    print("Prikhodko (2020): printed and computed; * differs, - follows from nothing printed\n")
    cells = [
        [
            words(row.name), row.place, row.printed,
            "-" if row.right is None else f"{row.value:.6g}",
            "" if row.agrees else "*", row.unit,
        ]
        for row in rows
    ]  # fmt: skip
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for name, place, printed, computed, star, unit in cells:
        numbers = f"{printed:>{widths[2]}}  {computed:>{widths[3]}}{star:<1}"
        print(f"{name:<{widths[0]}}  {place:<{widths[1]}}  {numbers}  {unit}".rstrip())
    print(f"\n{record['agreeing']} of {record['judged']} numbers are right to their last digit.")
    for row in rows:
        if row.reason:
            print(f"  {words(row.name)}, {row.printed}: {row.reason}")
    print("\nSlips in equations and text, some perhaps the scan's:")
    for slip in prikhodko.ERRATA:
        print(f"  {slip.place}: {slip.printed}\n      instead: {slip.right}")
    print(
        f"\nOutput per stop {record['output_per_stop_deg']:g} degrees; greatest output speed "
        f"{record['transmission_max']:.6g} times the input's, backwards"
    )
    print(
        "Closed position function against quadrature of (9): "
        f"{record['position_function_error']:.1e} rad"
    )
    print(f"Slip of the pitch curves: {record['pitch_curve_slip']:.1e} centre distances")


def _as_table(rows: list[prikhodko.PrintedValue]) -> list[list[Any]]:
    """A header, then a line a number."""
    table: list[list[Any]] = [
        ["quantity", "place", "unit", "printed", "right", "computed", "reason"]
    ]
    for row in rows:
        computed = "" if row.right is None else repr(row.value)
        table.append([row.name, row.place, row.unit, row.printed, row.right, computed, row.reason])
    return table


def _draw(folder: Path) -> None:
    """Figures 2, 3 and 6, the velocity analogue, and 7 to 9 of readings that are made up."""
    import math

    from escapement.plots import measurement as errors
    from escapement.plots import save
    from escapement.plots.planetary import plot_planetary
    from escapement.sources.prikhodko import figures

    mechanism = prikhodko.drive()
    save(figures.plot_velocity_plans(mechanism), folder / f"{_NAME}_figure_3.png")
    panels = {
        "figure_2": plot_planetary(mechanism, math.radians(30.0)),
        "figure_6": figures.plot_position_function(mechanism),
        "equation_9": figures.plot_velocity_analogue(mechanism),
    }
    made_up = prikhodko.synthetic_measurement()
    panels |= {
        "figure_7_synthetic": errors.plot_errors(made_up),
        "figure_8_synthetic": errors.plot_error_histogram(made_up),
        "figure_9_synthetic": errors.plot_frequencies(made_up),
    }
    for name, ax in panels.items():
        save(ax, folder / f"{_NAME}_{name}.png")
