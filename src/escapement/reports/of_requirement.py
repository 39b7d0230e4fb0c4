"""The sections of a report about the designs that satisfy a requirement."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from escapement import plots
from escapement.base.records import Record, beside
from escapement.base.results import Result
from escapement.base.spoken import spoken
from escapement.dynamics.figure_record import record_of
from escapement.engines.run_down import rundown
from escapement.engines.simulate import terminal
from escapement.inverse_design.design_record import short_record_of
from escapement.reports import sections

if TYPE_CHECKING:
    from escapement.inverse_design.timer_search import Designs


def of_requirement(found: Designs) -> list[str]:
    """What was asked for, and the designs that satisfy it."""
    front = sections.paragraph(
        "None of these designs is better than another in all objectives. The first one follows."
    )
    front += "".join(map(sections.of_table, short_record_of(found).tables(spoken())))
    front += sections.picture(lambda: plots.plot_designs(found), "The designs over two objectives")
    return [
        sections.section("What is asked for", sections.of_inputs(found.requirement.inputs())),
        sections.section("The designs", front),
    ]


def of_friction(found: Designs) -> str:
    """The figures of the first design at both ends of the friction range and in its middle."""
    asked, first = found.requirement, found.designs[0].timer
    low, high = asked.friction
    frictions = [*dict.fromkeys((low, first.friction, high))]
    records = []
    for friction in frictions:
        timer = replace(first, friction=friction)
        record = record_of(terminal(timer), timer)
        if asked.turns:
            run = rundown(timer, turns=asked.turns)
            told = {"run_time": run.end_time, "run_ends": run.message}
            record |= Record(told, {"run_time": Result("time", "time of the whole run")})
        records.append(record)
    header = "", *(f"friction {friction:g}" for friction in frictions), "unit"
    rows = [row for row in beside(records, spoken()) if not {*row[1:-1]} <= {"-", "done"}]
    return sections.section("Over the range of friction", sections.table(header, rows))
