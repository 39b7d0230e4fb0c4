"""`escapement mechanism`: geometry and transmission of a mechanism."""

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from escapement import validate
from escapement.cli import _arguments, _output
from escapement.cli._parser import Parser, UsageError, number
from escapement.errors import InvalidValue
from escapement.model import Inertia
from escapement.quantity import declared
from escapement.text import print_columns, print_values, words
from escapement.units import unit_name

if TYPE_CHECKING:
    from escapement.mechanisms.kind import Kind

SUMMARY = "Geometry, transmission, motion ratio and dwell of a mechanism."


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    inertia = parser.add_argument_group("inertia, for the critical friction")
    for entry in declared(Inertia).values():
        _arguments.add_setting(inertia, entry)
    drawing = parser.add_argument_group("drawing")
    _arguments.add_plot(drawing, "draw it to scale")
    drawing.add_argument(
        "--angle",
        type=number("--angle", validate.number, "give a driver angle in degrees"),
        metavar="DEG",
        help="driver angle of the drawing from dead centre (default: 0)",
    )
    _arguments.add_common(parser)


def execute(args: argparse.Namespace) -> int:
    """Print the geometry; draw it where asked for."""
    _output.check_wanted(args)
    if args.angle is not None and args.plot is None:
        raise UsageError("--angle must come with --plot FILE, got none; it turns the drawing")
    mechanism = _arguments.read_mechanism(args)
    record = _report(mechanism, args)
    if args.plot is not None:
        _draw(mechanism, args)
    reasons = _reasons(mechanism, record)
    if args.json:
        _output.print_json(record | ({"message": "; ".join(reasons)} if reasons else {}))
    else:
        _print(record, mechanism.report_units, args.units)
    if reasons:
        _output.note("; ".join(reasons))
    return 0


def _report(mechanism: "Kind", args: argparse.Namespace) -> dict[str, Any]:
    """What `mechanism` reports, by JSON key, in the user's units."""
    record = mechanism.report()
    for key, quantity in mechanism.report_units.items():
        if record.get(key) is not None:
            record[key] = _output.in_units(record[key], quantity, args.units)
    inertia = _arguments.read_inertia(args)
    if inertia is not None:
        from escapement.painleve import critical_friction

        record["critical_friction"] = critical_friction(mechanism, inertia)
    return record


def _print(record: dict[str, Any], quantities: Mapping[str, str], system: str) -> None:
    """Name, value and unit of each; a list of objects follows as a table of its own."""
    units = {key: unit_name(quantity, system) for key, quantity in quantities.items()}
    units |= {key: "deg" for key in record if key.endswith("_deg")}
    tables = {key: value for key, value in record.items() if isinstance(value, list)}
    print_values(
        (words(key), value, units.get(key, ""))
        for key, value in record.items()
        if key not in tables
    )
    for key, rows in tables.items():
        if len(rows) > 1:
            print(f"\n{words(key)}")
            suffixes = [" (deg)" if name.endswith("_deg") else "" for name in rows[0]]
            names = map(words, rows[0])
            header = [name + suffix for name, suffix in zip(names, suffixes, strict=True)]
            print_columns([header], [row.values() for row in rows])


def _reasons(mechanism: "Kind", record: dict[str, Any]) -> list[str]:
    """What does not exist, and why: dynamics beside a geometry, and numbers of the report."""
    try:
        _ = mechanism.path
    except InvalidValue as error:
        return [f"warning: {error}", *_output.not_given(record)]
    return _output.not_given(record)


def _draw(mechanism: "Kind", args: argparse.Namespace) -> None:
    import math

    from escapement.plots import plot_mechanism
    from escapement.plots.saving import save

    save(plot_mechanism(mechanism, math.radians(args.angle or 0.0)), args.plot)
