"""Appendix E of Meyer (1973): table, reasons and figures."""

import re
from collections.abc import Iterable
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from escapement.sources.meyer.rows import INERTIAS, agreement, appendix_e
from escapement.sources.reproduction import Reproduction
from escapement.text import print_columns
from escapement.units import INCH_POUND, unit_name

_COLUMNS = {
    "printed": "printed",
    "as_published": "as published",
    "program_1973": "program 1973",
    "true": "true mechanism",
}
_FIGURES = {"velocity_max": "max", "velocity_min": "min", "rise_time": "rise", "period": "period"}


def reproduce(units: str) -> Reproduction:
    """All 49 rows recomputed."""
    rows = appendix_e(units)
    counts = {name: agreement(rows, name)._asdict() for name in _COLUMNS if name != "printed"}

    def show() -> None:
        _print_rows(rows, units)
        _print_reasons(rows)
        _print_agreement(counts)

    record = {"units": units, "rows": rows, "agreement": counts}
    return Reproduction(
        "meyer_appendix_e", record, _as_table(rows, units), show, partial(_draw, rows=rows)
    )


def _print_rows(rows: list[dict[str, Any]], units: str) -> None:
    """One line a row; speeds in rad/s, times in s."""
    torque = unit_name("torque", units)
    print("Meyer (1973), Appendix E: driver velocity [rad/s], rise time and period [s]\n")
    fields = [f"{'':>3} {'slots':>5} {'mu':>4} {'torque':>9}"]
    fields += [f"{title:^23}" for title in _COLUMNS.values()]
    print(" | ".join(fields).rstrip())
    under = " ".join(f"{name:>5}" for name in _FIGURES.values())
    print(" | ".join([f"{'row':>3} {'':>5} {'':>4} {torque:>9}", *[f"{under:<23}"] * 4]).rstrip())
    for number, row in enumerate(rows, 1):
        first = f"{number:>3} {row['slots']:>5} {row['friction']:.2f} {row['torque']:>9.4g}"
        cells = [_cell(row[name], name == "printed") for name in _COLUMNS]
        print(" | ".join([first, *cells]))


def _cell(figures: dict[str, float | None], printed: bool) -> str:
    """Four figures with the digits the thesis prints, or one more."""
    speed, time = ("{:>5.0f}", "{:>5.3f}") if printed else ("{:>5.1f}", "{:>5.4f}")
    forms = (speed, speed, time, time)
    shown = [
        "-".rjust(5) if figures[name] is None else form.format(figures[name])
        for name, form in zip(_FIGURES, forms, strict=True)
    ]
    return f"{' '.join(shown):<23}"


def _print_reasons(rows: list[dict[str, Any]]) -> None:
    """Every kind of disagreement once, with the rows it explains and one in full."""
    kinds: dict[str, list[tuple[int, str]]] = {}
    for number, row in enumerate(rows, 1):
        for reason in row["reasons"]:
            kind = re.sub(r"\d[\d.e+-]*", "#", reason.partition(":")[0])
            kinds.setdefault(kind, []).append((number, reason))
    print("\nWhy printed figures differ, each with one row's numbers (all are in the JSON):")
    for found in kinds.values():
        numbers, (first, reason) = [number for number, _ in found], found[0]
        print(f"  {ranges(numbers)}; in row {first}, {reason}")


def ranges(numbers: Iterable[int]) -> str:
    """Ascending whole numbers as a reader writes them: rows 1-3, 5."""
    unique = sorted(set(numbers))
    runs = groupby(enumerate(unique), key=lambda pair: pair[1] - pair[0])
    spans = [[number for _, number in run] for _, run in runs]
    text = ", ".join(str(s[0]) if len(s) == 1 else f"{s[0]}-{s[-1]}" for s in spans)
    return f"row{'s' if len(unique) > 1 else ''} {text}"


def _print_agreement(counts: dict[str, dict[str, Any]]) -> None:
    header = ["of 49 rows", "period", "minimum", "maximum", "worst maximum", "rise time"]
    below = ["", "1 ms", "0.55 rad/s", "1 rad/s", "", "half a period"]
    print("\nHow many rows meet the printed figure within")
    rows = [
        [
            _COLUMNS[name], found["periods"], found["minima"], found["maxima"],
            f"{100.0 * found['worst_maximum']:.1f} %", found["rise_times"],
        ]
        for name, found in counts.items()
    ]  # fmt: skip
    print_columns([header, below], rows)


def _as_table(rows: list[dict[str, Any]], units: str) -> list[list[Any]]:
    """A header, then a line a row, with the system that torque and inertias are in."""
    plain = [name for name in rows[0] if name not in (*_COLUMNS, "reasons")]
    header = [*plain, "units", *(f"{c}_{f}" for c in _COLUMNS for f in _FIGURES), "reasons"]
    return [
        header,
        *(
            [
                *(row[name] for name in plain),
                units,
                *(row[column][figure] for column in _COLUMNS for figure in _FIGURES),
                "; ".join(row["reasons"]),
            ]
            for row in rows
        ),
    ]


def _draw(folder: Path, rows: list[dict[str, Any]]) -> None:
    """Figures 8 to 14 of the thesis, recomputed."""
    from escapement.mechanisms import Geneva
    from escapement.model import Escapement, Inertia
    from escapement.plots import plot_configurations, plot_velocities, save
    from escapement.simulation import simulate
    from escapement.sources.meyer.figures import plot_appendix_e

    driver, follower = (inertia * INCH_POUND for inertia in INERTIAS[4])
    timer = Escapement(Geneva(4), Inertia(driver, follower), 0.10 * INCH_POUND, 0.35)
    velocities = plot_velocities(simulate(timer, engagements=5))
    save(velocities, folder / "meyer_figure_8.png")
    for number, slots in {9: 6, 10: 4, 11: 3}.items():
        save(plot_appendix_e(rows, slots), folder / f"meyer_figure_{number}.png")
    save(plot_configurations(), folder / "meyer_figures_12_to_14.png")
