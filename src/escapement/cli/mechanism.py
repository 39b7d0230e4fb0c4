"""`escapement mechanism`: geometry and transmission of a mechanism."""

import argparse
import math
from typing import Any

from escapement import validate
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Parser, UsageError, number
from escapement.errors import InvalidValue
from escapement.model import Inertia
from escapement.quantity import declared

SUMMARY = "Geometry, transmission, motion ratio and dwell of a mechanism."


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    _arguments.add_group(parser, "inertia, for the critical friction", declared(Inertia))
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
    record: dict[str, Any] = mechanism.report()
    settings = declared(Inertia)
    given = _arguments.typed(args, settings)
    if given:
        _arguments.require(args, settings, ", both or none")
        from escapement.painleve import critical_friction

        record["critical_friction"] = critical_friction(mechanism, Inertia(**given))
    if args.plot is not None:
        from escapement import plots

        plots.save(plots.plot_mechanism(mechanism, math.radians(args.angle or 0.0)), args.plot)
    warning = ""
    try:
        _ = mechanism.path
    except InvalidValue as error:
        # a geometry that no motion can be computed for is reported all the same
        warning = f"warning: {error}"
    _output.report(args, record, mechanism.report_units, warning=warning)
    return 0
