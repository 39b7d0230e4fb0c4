"""Geometry, transmission, motion ratio and dwell of a mechanism."""

import math
from dataclasses import replace
from typing import Any

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.quantity import declared
from escapement.base.units import degrees, printed
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.model.escapement import Inertia
from escapement.model.inputs import inputs_of_mechanism
from escapement.outlines.fits import Fits

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
    mechanism: Any = _arguments.read_mechanism(args)
    if args.angle is not None and isinstance(mechanism, esc.Tabulated):
        raise UsageError(
            "--angle must not come with a tabulated mechanism, which has no bodies to turn; "
            "leave it out"
        )
    record, misfit = mechanism.report(), mechanism.misfit
    if given := _arguments.typed(args, declared(Inertia)):
        _arguments.require(args, declared(Inertia), ", both or none")
        if mechanism.meshed:
            raise UsageError(
                f"--driver-inertia must not come with a {mechanism.kind} mechanism, which has no "
                "slots and so no critical friction; leave it out"
            )
        if misfit:
            raise UsageError(f"--driver-inertia must come with parts that fit, got: {misfit}")
        record["critical_friction"] = esc.critical_friction(mechanism, Inertia(**given))
    kinds, warnings = {**mechanism.report_units}, list[str]()
    if not mechanism.perfect and not misfit:
        record["engagements"] = _engagements(mechanism)
    shaft = _arguments.typed(args, _SHAFT).get("follower_shaft_radius")
    outside = isinstance(mechanism, esc.Geneva) and not mechanism.internal
    if shaft is not None and not (outside and mechanism.crank_radius):
        rule = "come with an external Geneva wheel and its --crank-radius"
        raise UsageError(f"--follower-shaft-radius must {rule}, got none; leave it out")
    if isinstance(mechanism, esc.Geneva):
        found, warnings = _sizes(mechanism, shaft, args.units)
        record |= found
        kinds |= {name: "length" for name in found if not name.endswith("_over_crank_radius")}
    if not mechanism.perfect:
        text = "the numbers except the distance of the axes are those of parts without errors"
        warnings += [f"warning: {reason}" for reason in (text, misfit) if reason]
    angle = math.radians(args.angle or 0.0)
    _output.draw(args.plot, lambda plots: plots.plot_mechanism(mechanism, angle))
    try:
        _ = mechanism.path
    except InvalidValue as error:
        # the geometry is reported even if no motion can be computed for it
        warnings.append(f"warning: {error}")
    _output.report(args, record, kinds, "; ".join(warnings), inputs_of_mechanism(mechanism))
    return 0


def _engagements(wheel: Any) -> list[dict[str, Any]]:
    """The engagements of a wheel with errors, until pins and slots meet again.

    Angles of the driver are counted from the first dead centre of perfect parts; `jump_deg` is by
    how much the follower jumps ahead where a pin picks it up or strikes it.
    """
    rows = []
    for k, pair in enumerate(wheel.pairs):
        centre = k * wheel.cell_angle + pair.delay
        rows.append({
            "pin": k % wheel.pins, "slot": k % wheel.slots, "begins_with": pair.kind,
            "begin_deg": degrees(centre + pair.edges[0]),
            "end_deg": degrees(centre + pair.edges[-1]), "jump_deg": degrees(pair.jump),
        })  # fmt: skip
    return rows


def _sizes(
    mechanism: esc.Geneva, shaft: float | None, system: str
) -> tuple[dict[str, float], list[str]]:
    """Sizes of the follower by JSON key, and what is wrong with its shaft."""
    from escapement.outlines.geneva import sizes

    found, unit = sizes(mechanism), mechanism.crank_radius
    if unit is None:
        return {f"{name}_over_crank_radius": size for name, size in found.items()}, []
    lengths = {name: unit * size for name, size in found.items()}
    if shaft is None:
        return lengths, []
    closest = lengths["closest_radius"]
    lengths["slot_to_shaft"] = closest - shaft
    if shaft < closest:
        return lengths, []
    radius, end = (
        f"{_output.in_units(x, 'length', system):.6g} {printed('length', system)}"
        for x in (shaft, closest)
    )
    text = f"a slot reaches the shaft of radius {radius}: it ends {end} from the axis"
    return lengths, [f"warning: {text}; choose a thinner shaft or a larger wheel"]
