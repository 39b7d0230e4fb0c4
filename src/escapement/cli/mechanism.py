"""Geometry, transmission, motion ratio and dwell of a mechanism."""

import math
from dataclasses import replace

import escapement as esc
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.errors import InvalidValue
from escapement.fits import Fits
from escapement.model import Inertia
from escapement.quantity import declared

_SHAFT = {
    name: replace(entry, note=": a warning tells where a slot reaches it")
    for name, entry in declared(Fits).items()
    if name == "follower_shaft_radius"
}


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    _arguments.add_group(parser, "inertia, for the critical friction", declared(Inertia))
    _arguments.add_group(parser, "shaft", _SHAFT)
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
    kinds, warnings = {**mechanism.report_units}, list[str]()
    if isinstance(mechanism, esc.Geneva):
        shaft = _arguments.typed(args, _SHAFT).get("follower_shaft_radius", 0.0)
        found, warnings = _sizes(mechanism, shaft)
        record |= found
        kinds |= {name: "length" for name in found if not name.endswith("_over_crank_radius")}
    if not getattr(mechanism, "perfect", True):
        text = "the numbers except the distance of the axes are those of parts without errors"
        misfit = getattr(mechanism, "misfit", "")
        warnings += [f"warning: {told}" for told in (text, misfit) if told]
    angle = math.radians(args.angle or 0.0)
    _output.draw(args.plot, lambda plots: plots.plot_mechanism(mechanism, angle))
    try:
        _ = mechanism.path
    except InvalidValue as error:
        # the geometry is reported even if no motion can be computed for it
        warnings.append(f"warning: {error}")
    _output.report(args, record, kinds, "; ".join(warnings))
    return 0


def _sizes(mechanism: esc.Geneva, shaft: float) -> tuple[dict[str, float], list[str]]:
    """Sizes of the follower by JSON key, and what is wrong with its shaft."""
    from escapement.outlines.geneva import sizes

    found, unit = sizes(mechanism), mechanism.crank_radius
    if unit is None:
        return {f"{name}_over_crank_radius": size for name, size in found.items()}, []
    lengths = {name: unit * size for name, size in found.items()}
    closest = lengths.get("closest_radius", math.inf)
    if shaft < closest:
        return lengths, []
    text = (
        f"a slot reaches the shaft of radius {shaft:.6g} m: it ends {closest:.6g} m from the axis"
    )
    return lengths, [f"warning: {text}; choose a thinner shaft or a larger wheel"]
