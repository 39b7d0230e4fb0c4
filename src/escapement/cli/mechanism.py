"""Geometry, transmission, motion ratio and dwell of a mechanism."""

import math

import escapement as esc
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.errors import InvalidValue
from escapement.model import Inertia
from escapement.quantity import declared


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    _arguments.add_group(parser, "inertia, for the critical friction", declared(Inertia))
    drawing = parser.add_argument_group("drawing")
    _arguments.add_plot(drawing, "draw it to scale")
    text = "driver angle of the drawing from dead centre (default: 0)"
    rule = {"unit": "degrees", "minimum": -math.inf, "remedy": "give a driver angle"}
    _arguments.add_number(drawing, "angle", text, "DEG", **rule)


def execute(args: Arguments) -> int:
    """Print the geometry; draw it where asked for."""
    _output.check_wanted(args)
    if args.angle is not None and args.plot is None:
        raise UsageError("--angle must come with --plot FILE, got none; it turns the drawing")
    mechanism = _arguments.read_mechanism(args)
    record = mechanism.report()
    if given := _arguments.typed(args, declared(Inertia)):
        _arguments.require(args, declared(Inertia), ", both or none")
        record["critical_friction"] = esc.critical_friction(mechanism, Inertia(**given))
    angle = math.radians(args.angle or 0.0)
    _output.draw(args.plot, lambda plots: plots.plot_mechanism(mechanism, angle))
    warning = ""
    try:
        _ = mechanism.path
    except InvalidValue as error:
        # a geometry that no motion can be computed for is reported all the same
        warning = f"warning: {error}"
    _output.report(args, record, mechanism.report_units, warning=warning)
    return 0
