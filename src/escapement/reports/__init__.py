"""A report of a design: one HTML file that needs no other and prints on paper."""

from __future__ import annotations

import html
from importlib.resources import files
from typing import TYPE_CHECKING

from escapement import __version__
from escapement.base import validate
from escapement.base.files import PAGES, AnyPath, check_target, file_format, write_file
from escapement.base.status import Status
from escapement.dynamics.figure_record import record_of
from escapement.engines import simulate as simulation
from escapement.engines.run_down import rundown
from escapement.model.escapement import Escapement
from escapement.model.inputs import inputs_of
from escapement.reports import sections
from escapement.reports.of_requirement import of_friction, of_requirement

if TYPE_CHECKING:
    from escapement.inverse_design.timer_search import Designs
    from escapement.tolerance.tolerance_budget import Budget

_ENGAGEMENTS = 20


def report(
    escapement: Escapement,
    path: AnyPath,
    *,
    budget: Budget | None = None,
    title: str = "",
    initial_speed: float = 0.0,
    force: bool = False,
) -> None:
    """Write a report of a design.

    It holds the design in all systems of units, its figures of merit, the drawing to scale, the
    velocities from the start, the run-down of a spring, the budget if there is one, and what the
    model leaves out.

    Parameters
    ----------
    escapement : Escapement
        The design.
    path : path
        File to write, which ends in .html.
    budget : Budget, optional
        What `escapement.budget` returns for this design: its intervals become a section.
    title : str
        One line for people. Default: the kind of mechanism.
    initial_speed : float
        Driver speed at the first pin entry [rad/s], >= 0.
    force : bool
        Replace an existing file, once the new one is complete.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    CannotCreate, StorageError
        When the file cannot be made, or the disk fails.
    """
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    file_format(path, PAGES)
    check_target(path, force)
    text = page(escapement, budget, title=title, initial_speed=initial_speed)
    write_file(path, [text.encode()], force)


def page(
    escapement: Escapement,
    budget: Budget | None = None,
    *,
    title: str = "",
    initial_speed: float = 0.0,
    date: str = "",
    designs: Designs | None = None,
) -> str:
    """The text of a report.

    Arguments are those of `report`, the date of the design, and the designs of which it is the
    first.
    """
    name = title or f"A {escapement.mechanism.kind} escapement"
    figures = simulation.terminal(escapement, initial_speed=initial_speed)
    motion = simulation.simulate(escapement, _ENGAGEMENTS, initial_speed=initial_speed)
    parts = [sections.paragraph(date)] if date else []
    if designs is not None:
        parts += of_requirement(designs)
    inputs = [*inputs_of(escapement), ("initial_speed", initial_speed, "speed")]
    parts.append(sections.section("The design", sections.of_inputs(inputs)))
    text = sections.paragraph(f"The figures of the terminal cycle: {figures.message}.")
    if figures.status is Status.OK:
        text += sections.of_record(record_of(figures, escapement))
    parts.append(sections.section("What it does", text))
    if designs is not None:
        parts.append(of_friction(designs))
    if motion.end_time > 0.0:
        drawn = sections.of_pictures(escapement, motion)
        parts.append(sections.section("Drawing and velocities", drawn))
    curve = escapement.curve
    asked = designs and designs.requirement.turns
    falls = curve is not None and not curve.periodic and curve.at_rest[-1] == 0.0
    if asked or falls:
        run = rundown(escapement, turns=asked or None, initial_speed=initial_speed)
        text = sections.paragraph(
            f"{run.message[0].upper()}{run.message[1:]}."
        ) + sections.of_rundown(run)
        parts.append(sections.section("How it runs down", text))
    if budget is not None:
        parts.append(sections.section("What the tolerances do", sections.of_budget(budget)))
    assumed = sections.of_assumptions(escapement, budget.spreads if budget else ())
    parts.append(sections.section("What is assumed", assumed))
    style = files(__name__).joinpath("page.css").read_text(encoding="utf-8")
    return (
        "<!doctype html>\n"
        f"<html lang=en><head><meta charset=utf-8><title>{html.escape(name)}</title>"
        '<meta name=viewport content="width=device-width, initial-scale=1">'
        f"<style>{style}</style></head><body><main><h1>{html.escape(name)}</h1>"
        f"{''.join(parts)}<footer>geneva-escapement {__version__}, engine {motion.engine}, "
        f"relative tolerance {motion.rtol:g}</footer></main></body></html>\n"
    )
