"""Timers or indexing drives for a task, none of them better in everything than another."""

from pathlib import Path
from typing import Any

import escapement as esc
from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.text import as_csv
from escapement.base.toml_file import read_toml
from escapement.cli import SOME_FAILED, _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.model.inputs import Input

UNITS = "units of the printed figures (default: those of the wish)"


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    text = "file that says what the timer or the indexing drive must do, and its bounds"
    parser.add_argument("wish", type=Path, metavar="WISH.toml", help=text)
    rule: dict[str, Any] = {"minimum": 1, "whole": True, "remedy": "give how many"}
    _arguments.add_number(parser, "count", "greatest number of designs (default: 40)", "N", **rule)
    output = parser.add_argument_group("output")
    _arguments.add_output(output, "FILE.csv", "write a line for each design, in SI")
    _arguments.add_plot(output, "draw the designs over the first two objectives")
    _arguments.add_report(output)


def execute(args: Arguments) -> int:
    """Search, write and draw what was asked for, print the designs."""
    from escapement.inverse_design.design_record import record_of, short_record_of
    from escapement.inverse_design.requirement import load_requirement
    from escapement.study.subject import ESCAPEMENT

    _output.speak_as(args, args.wish, "wish")
    content = read_toml(args.wish, "wish")
    if "study" in content or "ranges" in content:
        return _search(args, {"study": ESCAPEMENT.name} | content)
    found = esc.design(load_requirement(args.wish)[0], count=args.count or 40)
    known = [*found.requirement.inputs(), ("count", args.count or 40, "ratio")]
    record = record_of(found)
    if not (lines := record.values["designs"]):
        _output.tell(args, record, known, lambda: None)
        return SOME_FAILED
    first = found.designs[0].timer
    _output.save(
        args,
        lambda: as_csv([[*lines[0]], *([*line.values()] for line in lines)]),
        lambda plots: plots.plot_designs(found),
        lambda: _output.page_of(first, title="Timers for a requirement", designs=found),
    )
    _output.tell(args, record, known, lambda: short_record_of(found).show(args.units))
    return 0


def _search(args: Arguments, wish: dict[str, Any]) -> int:
    """The same by a study of what the wish describes."""
    if args.report is not None:
        raise UsageError("--report must be left out with [ranges], whose designs have none")
    found = esc.design_drive(wish, count=args.count or 40)
    requirement = found.requirement
    plan = {name: value for name, value in requirement.study.items() if not isinstance(value, dict)}
    known: list[Input] = [(name, value, "ratio") for name, value in plan.items()]
    known.append(("objectives", ", ".join(requirement.objectives), "ratio"))
    if not found.designs:
        _output.tell(args, {"designs": [], "message": found.message}, known, lambda: None)
        return SOME_FAILED
    lines = [one.chosen | one.values for one in found.designs]
    _output.save(
        args,
        lambda: as_csv([[*lines[0]], *([*line.values()] for line in lines)]),
        lambda plots: plots.plot_designs(found),
    )
    results = {name: Result(entry.unit) for name, entry in requirement.entries.items()}
    message = f"{len(lines)} designs, from {found.tried} points tried"
    record = Record({"designs": lines, "message": message}, results | dict(requirement.figures))
    _output.tell(args, record, known)
    return 0
