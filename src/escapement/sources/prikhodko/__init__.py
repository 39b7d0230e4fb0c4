"""Prikhodko (2020): the planetary drive with elliptical gears, printed and true.

The raw measurements are not published, so three statistics of them are taken as
printed; everything else is recomputed, from the two radii and from these three.
"""

import math
from collections.abc import Iterator
from functools import cache, partial
from typing import Any

from escapement.base.text import plain, print_columns, words
from escapement.base.units import degrees
from escapement.measurement import Encoder, Measurement, measure, sturges, synthetic_readings
from escapement.mechanisms import EllipticalPlanetary
from escapement.sources import report
from escapement.sources.report import Cell, cut_off, digits, judge, read_slips, read_table

ENCODER_STEPS = 4096
CONFIDENCE = 0.99


@cache
def printed_rows() -> dict[str, dict[str, str]]:
    """Printed numbers by name: `printed`, as text, `unit` and `place`."""
    return {row["quantity"]: row for row in read_table("prikhodko", "table_1.csv")}


def drive() -> EllipticalPlanetary:
    """The drive that was measured: R1 = 16, R2 = 9 mm."""
    return EllipticalPlanetary(_given("sun_radius") / 1e3, _given("planet_radius") / 1e3)


def table() -> list[Cell]:
    """Every printed number that can be checked, and those on which the check is based."""
    values = _recomputed()
    return [
        judge(row["place"], name, row["printed"], values.get(name, math.nan), _why)
        for name, row in printed_rows().items()
    ]


def synthetic_measurement() -> Measurement:
    """A synthetic measurement with the paper's drive, encoders, standard deviation and classes.

    148 readings over two cells, whose errors are normal with the printed deviation.
    """
    mechanism = drive()
    samples, noise = int(_given("sample_size")), math.radians(_given("error_deviation"))
    # two stops, as in the figures of the paper
    turns, encoder = 2.0 * mechanism.cell_angle / (2.0 * math.pi), Encoder(ENCODER_STEPS)
    readings = synthetic_readings(
        mechanism, seed=2020, samples=samples, turns=turns, encoder=encoder, noise=noise
    )
    return measure(readings, mechanism, bins=int(_given("intervals")))


def reproduce(units: str | None = None) -> report.Reproduction:
    """Recomputed numbers; lengths in millimetres as printed, independent of the units."""
    cells, slips, mechanism = table(), read_slips("prikhodko"), drive()
    judged = [cell for cell in cells if cell.true is not None]
    record: dict[str, Any] = {
        "rows": [_as_row(cell) for cell in cells],
        "judged": len(judged),
        "agreeing": sum(cell.agrees for cell in judged),
        "errata": [{"place": it.place, "printed": it.printed, "true": it.true} for it in slips],
        "stop_interval_deg": degrees(mechanism.cell_angle),
        "output_per_stop_deg": -degrees(mechanism.follower_step),
        "transmission_max": mechanism.ratio_max,
        "message": "true and value are null where a number follows from nothing printed",
    }

    def show() -> None:
        print("Prikhodko (2020): printed and true; * differs, - follows from nothing printed\n")
        names = {cell.column: words(cell.column) for cell in cells}
        print_columns([], map(_as_line, record["rows"]))
        report.print_errata(cells, "numbers", "{1}", names, slips)
        print(
            f"\nOutput per stop {record['output_per_stop_deg']:g} degrees; greatest output speed "
            f"{mechanism.ratio_max:.6g} times the input's, backwards"
        )

    header = ["quantity", "place", "unit", "printed", "true", "value", "reason"]
    keys = ["name", *header[1:]]
    rows = [[plain(row[key]) for key in keys] for row in record["rows"]]
    return report.Reproduction("prikhodko", record, [header, *rows], show, _panels)


def _panels() -> report.Panels:
    """Figures 2, 3 and 6, the velocity analogue, and 7 to 9 with synthetic readings."""
    from escapement.plots import measurement as errors
    from escapement.plots.planetary import plot_planetary
    from escapement.sources.prikhodko import prikhodko_figures

    mechanism, made_up = drive(), synthetic_measurement()
    return {
        "prikhodko_figure_2": partial(plot_planetary, mechanism, math.radians(30.0)),
        "prikhodko_figure_3": partial(prikhodko_figures.plot_velocity_plans, mechanism),
        "prikhodko_figure_6": partial(prikhodko_figures.plot_position_function, mechanism),
        "prikhodko_equation_9": partial(prikhodko_figures.plot_velocity_analogue, mechanism),
        "prikhodko_figure_7_synthetic": partial(errors.plot_errors, made_up),
        "prikhodko_figure_8_synthetic": partial(errors.plot_error_histogram, made_up),
        "prikhodko_figure_9_synthetic": partial(errors.plot_frequencies, made_up),
    }


def _given(name: str) -> float:
    return float(printed_rows()[name]["printed"])


def _recomputed() -> dict[str, float]:
    """Numbers that follow from the radii, and from size, deviation and chi^2 of the sample."""
    from scipy.stats import chi2, norm

    mechanism = drive()
    return {
        "semi_major_axis": 1e3 * mechanism.semi_major_axis,
        "semi_minor_axis": 1e3 * mechanism.semi_minor_axis,
        "focal_distance": 1e3 * mechanism.focal_distance,
        "eccentricity": mechanism.eccentricity,
        "encoder_resolution": 360.0 / ENCODER_STEPS,
        "stop_interval": math.degrees(mechanism.cell_angle),
        "intervals": sturges(int(_given("sample_size"))),
        # two degrees of freedom are lost, because mean and deviation were estimated from the
        # sample
        "degrees_of_freedom": _given("intervals") - 1.0 - 2.0,
        "significance": 100.0 * float(chi2.sf(_given("chi_squared"), _given("degrees_of_freedom"))),
        "quantile": float(norm.ppf(0.5 * (1.0 + CONFIDENCE))),
        # the printed quantile, so that its own erratum does not count twice
        "half_width": _given("quantile") * _given("error_deviation"),
    }


def _why(printed: str, value: float) -> Iterator[str]:
    """Rules that give the printed number."""
    yield from cut_off(printed, value)
    if digits(printed)[0] == math.ceil(value):
        yield f"the next greater whole number: {value:.4g}"


def _as_row(cell: Cell) -> dict[str, Any]:
    """A printed number for JSON."""
    row = vars(cell) | {"unit": printed_rows()[cell.column]["unit"], "agrees": cell.agrees}
    return {"name": row.pop("column"), **row}


def _as_line(row: report.Record) -> list[str]:
    """A printed number for people."""
    value = "- " if row["true"] is None else f"{row['value']:.6g}{' ' if row['agrees'] else '*'}"
    return [words(row["name"]), row["place"], row["printed"], value, row["unit"]]
