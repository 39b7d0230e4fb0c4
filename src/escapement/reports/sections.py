"""The sections of a report, as HTML."""

from __future__ import annotations

import html
import math
import tempfile
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement import plots
from escapement.base.spoken import spoken
from escapement.base.text import show, words
from escapement.base.units import SYSTEMS, factor, printed
from escapement.dynamics.figure_table import FIGURES
from escapement.dynamics.figures_of_merit import Figures
from escapement.dynamics.motion import Motion
from escapement.model.escapement import Escapement
from escapement.model.inputs import in_unit, in_words, inputs_of
from escapement.reports.assumptions import ALWAYS, left_out

if TYPE_CHECKING:
    from escapement.engines.run_down import Rundown
    from escapement.tolerance.tolerance_budget import Budget

_DESCRIBED = (
    "period", "velocity_mean", "velocity_max", "velocity_min", "rise_time_98",
    "handoff_velocity", "acceleration_max", "follower_acceleration_max", "contact_moment_max",
    "contact_force_max", "beat_error", "blow_max", "critical_friction", "jam_margin",
)  # fmt: skip


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


def of_inputs(escapement: Escapement, initial_speed: float) -> str:
    """What the design consists of, in both systems of units."""
    rows = []
    for name, value, kind in [*inputs_of(escapement), ("initial_speed", initial_speed, "speed")]:
        names = [name.replace("_", " ")]
        for system in SYSTEMS:
            shown = show(in_words(in_unit(value, factor(kind, system))))
            names.append(f"{shown} {printed(kind, system)}".strip())
        rows.append(names)
    return table(("", *SYSTEMS), rows)


def _unit(kind: str) -> str:
    """A kind of unit in the system that the user chose."""
    return printed(kind, spoken())


def of_figures(figures: Figures) -> str:
    """Figures of merit that there are."""
    rows: list[list[Any]] = []
    for name in _DESCRIBED:
        value = float(getattr(figures, name))
        if math.isfinite(value) and (value != 0.0 or name not in ("beat_error", "blow_max")):
            kind, name_of = FIGURES[name].kind, FIGURES[name].long_name
            rows.append([words(name), value / factor(kind, spoken()), _unit(kind), name_of])
    return table(("", "value", "unit", "meaning"), rows)


def of_budget(budget: Budget) -> str:
    """What the tolerances contribute, and the share of cases within the limits."""
    parts = []
    for name, scatter in budget.figures.items():
        parts.append(f"<h3>{html.escape(words(name))}</h3>")
        if scatter.inside:
            low, high = (100.0 * x for x in (scatter.inside.low, scatter.inside.high))
            parts.append(paragraph(
                f"{100.0 * scatter.inside.value:.1f} % of {budget.size} cases lie within the "
                f"limits; with 95 % confidence the share is {low:.1f} to {high:.1f} %."
            ))  # fmt: skip
        kind = FIGURES[name].kind

        def shown(*values: float, size: float = factor(kind, spoken())) -> list[float]:
            return [value / size for value in values]

        spread = [
            ("nominal", *shown(scatter.nominal), "", ""),
            ("mean, with its 95 % interval", *shown(*scatter.mean)),
            ("one case of twenty lies below", *shown(*scatter.quantiles[0.05])),
            ("one case of twenty lies above", *shown(*scatter.quantiles[0.95])),
            ("worst case", "", *shown(scatter.worst.low, scatter.worst.high)),
        ]
        parts.append(table((_unit(kind), "value", "from", "to"), spread))
        rows = [
            (words(key), f"{100.0 * share:.1f} %", scatter.balanced.get(key))
            for key, share in scatter.contributions.items()
        ]
        if rows:
            parts.append(table(("tolerance", "share of variance", "factor for equal shares"), rows))
        caption = f"Contributors to the scatter of the {words(name)}, and the sample"
        parts.append(picture(partial(plots.plot_budget, budget, name), caption))
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
    rows = [
        ("turns", run.end_turns, ""),
        ("time", run.end_time, "s"),
        ("period at the full torque", run.nominal_period, "s"),
        ("last period", float(run.periods[-1]) if run.periods.size else math.nan, "s"),
        ("lateness at the end", float(run.lateness[-1]) if run.times.size else math.nan, "s"),
    ]
    caption = "Speed and lateness over the turns"
    return table(("", "value", "unit"), rows) + picture(lambda: plots.plot_rundown(run), caption)


def of_pictures(escapement: Escapement, motion: Motion) -> str:
    """The mechanism to scale, and the velocities from the start."""
    drawn = picture(lambda: plots.plot_mechanism(escapement.mechanism), "The mechanism to scale")
    caption = "Driver and follower velocity from the start"
    return drawn + picture(lambda: plots.plot_velocities(motion), caption)


def of_assumptions(escapement: Escapement) -> str:
    """What the model leaves out."""
    missing = left_out(escapement)
    parts = []
    if missing:
        parts += [paragraph("This design was computed without"), table(("", "usual size"), missing)]
    parts += [paragraph("No design is computed with"), table(("", "assumed instead"), ALWAYS)]
    return "".join(parts)
