"""The sections of a report, as HTML."""

from __future__ import annotations

import html
import tempfile
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement import plots
from escapement.base.errors import InvalidValue
from escapement.base.records import Record, Table, in_units
from escapement.base.spoken import spoken
from escapement.base.text import show, words
from escapement.base.units import SYSTEMS, printed
from escapement.dynamics.motion import Motion
from escapement.engines.run_down import RUNDOWN
from escapement.model.escapement import Escapement
from escapement.model.inputs import Input, in_words
from escapement.outlines.fits import Fits
from escapement.outlines.part_files import motion_check
from escapement.outlines.part_record import record_of as sizes_of
from escapement.outlines.parts import parts_of
from escapement.reports.assumptions import ALWAYS, left_out
from escapement.tolerance.intervals import per_cent
from escapement.tolerance.scatter_record import permitted_table, tables_of

if TYPE_CHECKING:
    from escapement.engines.run_down import Rundown
    from escapement.tolerance.tolerance_budget import Budget


def section(title: str, *content: str) -> str:
    """A section with its heading."""
    return f"<section><h2>{html.escape(title)}</h2>{''.join(content)}</section>"


def paragraph(text: str) -> str:
    """A paragraph of plain text."""
    return f"<p>{html.escape(text)}</p>"


def table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table of plain values; the first column is a heading of its row."""
    top = "".join(f"<th scope=col>{html.escape(x)}</th>" for x in header)
    lines = []
    for first, *others in rows:
        cells = "".join(f"<td>{html.escape(show(x))}</td>" for x in others)
        lines.append(f"<tr><th scope=row>{html.escape(show(first))}</th>{cells}</tr>")
    return f"<table><thead><tr>{top}</tr></thead><tbody>{''.join(lines)}</tbody></table>"


def picture(make: Callable[[], Any], caption: str) -> str:
    """A figure as SVG within the page, with a sentence for those who do not see it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "figure.svg"
        plots.save(make(), path)
        drawn = path.read_text(encoding="utf-8")
    drawn = drawn[drawn.index("<svg") :]
    return f'<figure role=img aria-label="{html.escape(caption, quote=True)}">{drawn}</figure>'


def of_inputs(inputs: Iterable[Input]) -> str:
    """What went in, in all systems of units."""
    rows = []
    for name, value, kind in inputs:
        names = [name.replace("_", " ")]
        for system in SYSTEMS:
            shown = show(in_words(in_units(value, kind, system)))
            names.append(f"{shown} {printed(kind, system)}".strip())
        rows.append(names)
    return table(("", *SYSTEMS), rows)


def of_record(record: Record) -> str:
    """What was computed, in the system that the user chose, without numbers that do not exist."""
    rows = [
        (row.name, row.value, row.unit, row.meaning) for row in record.rows(spoken())
        if row.value != "-"
    ]  # fmt: skip
    tables = (f"<h3>{html.escape(x.title)}</h3>{of_table(x)}" for x in record.tables(spoken()))
    return table(("", "value", "unit", "meaning"), rows) + "".join(tables)


def of_table(one: Table) -> str:
    """A table with a column for each key."""
    names = zip(one.names, one.units, strict=True)
    return table([name + f" ({unit})" * (unit != "") for name, unit in names], one.rows)


def of_budget(budget: Budget) -> str:
    """What the tolerances contribute, and the share of cases within the limits."""
    parts = []
    for name, scatter in budget.figures.items():
        for one in tables_of(scatter, name, spoken()):
            parts.append(f"<h3>{html.escape(one.title)}</h3>" * (one.title != "") + of_table(one))
        if scatter.inside:
            parts.append(paragraph(
                f"{100.0 * scatter.inside.value:.1f} % of {budget.size} cases lie within the "
                f"limits; with 95 % confidence the share is "
                f"{per_cent(scatter.inside)} %."
            ))  # fmt: skip
        caption = f"Contributors to the scatter of the {words(name)}, and the sample"
        parts.append(picture(partial(plots.plot_budget, budget, name), caption))
    for share, ranges in budget.permitted.items():
        one = permitted_table(share, ranges, spoken())
        parts.append(f"<h3>{html.escape(one.title)}</h3>" + of_table(one))
    parts.append(
        paragraph(f"{budget.message[:1].upper()}{budget.message[1:]}.") * (budget.message != "done")
    )
    parts.append(paragraph(
        "A factor below 1 asks for a tighter tolerance, one above 1 allows a wider one; together "
        "they leave the standard deviation as it is, to first order."
    ))  # fmt: skip
    return "".join(parts)


def of_rundown(run: Rundown) -> str:
    """How the spring runs down."""
    caption = "Speed and lateness over the turns"
    record = Record(run.as_dict(), RUNDOWN)
    return of_record(record) + picture(lambda: plots.plot_rundown(run), caption)


def of_pictures(escapement: Escapement, motion: Motion) -> str:
    """The mechanism to scale, and the velocities from the start."""
    wheel: Any = escapement.mechanism
    drawn = picture(lambda: plots.plot_mechanism(wheel), "The mechanism to scale")
    with suppress(InvalidValue):  # it has no size, or no parts that could be drawn
        gaps, parts = motion_check(wheel), parts_of(wheel)
        drawn += of_record(sizes_of(wheel, Fits(), parts, gaps, {}).without("kind", "least_gaps"))
    caption = "Driver and follower velocity from the start"
    return drawn + picture(lambda: plots.plot_velocities(motion), caption)


def of_assumptions(escapement: Escapement, varied: Iterable[str]) -> str:
    """What the model leaves out; `varied` are numbers that a budget varies."""
    missing = left_out(escapement, varied)
    parts = []
    if missing:
        parts += [paragraph("This design was computed without"), table(("", "usual size"), missing)]
    parts += [paragraph("No design is computed with"), table(("", "assumed instead"), ALWAYS)]
    return "".join(parts)
