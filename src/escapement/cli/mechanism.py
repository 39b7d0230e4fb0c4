"""Geometry, transmission, motion ratio and dwell of a mechanism."""

import math
from dataclasses import replace
from typing import Any

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.quantity import declared
from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.units import degrees
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError
from escapement.model.escapement import Inertia
from escapement.model.inputs import inputs_of_mechanism
from escapement.outlines.fits import Fits

_INERTIA = _arguments.together(declared(Inertia))
_SHAFT = {
    name: replace(entry, note=": a warning tells where a slot reaches it")
    for name, entry in declared(Fits).items()
    if name == "follower_shaft_radius"
}
_STATIONS = Result(
    missing="R2/R1 is not a fraction with a denominator of at most 1000, so the output never "
    "stops in the same direction again"
)


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser, tables=True)
    _arguments.add_group(parser, "inertia, for the critical friction", _INERTIA)
    _arguments.add_group(parser, "shaft", _SHAFT)
    drawing = parser.add_argument_group("drawing")
    _arguments.add_plot(drawing, "draw it to scale")
    text = "driver angle of the drawing from dead centre (default: 0)"
    rule = {"unit": "degrees", "minimum": -math.inf, "remedy": "give a driver angle"}
    _arguments.add_number(drawing, "angle", text, "DEG", needs="plot", **rule)


def execute(args: Arguments) -> int:
    """Print the geometry; draw it where asked for."""
    return _output.tell_found(args, _found)


def _found(args: Arguments) -> _output.Found:
    """What is told of one mechanism, which is drawn where that is asked for."""
    mechanism: Any = _arguments.read_mechanism(args)
    if args.angle is not None and isinstance(mechanism, esc.Tabulated):
        raise UsageError(
            "--angle must not come with a tabulated mechanism, which has no bodies to turn; "
            "leave it out"
        )
    record, misfit = mechanism.report(), mechanism.misfit
    if given := _arguments.typed(args, _INERTIA):
        record["critical_friction"] = _critical_friction(mechanism, given)
    if not mechanism.perfect and not misfit:
        record["engagements"] = _engagements(mechanism)
    shaft = _arguments.typed(args, _SHAFT).get("follower_shaft_radius")
    sizes, warnings = _sizes(mechanism, shaft)
    if not mechanism.perfect:
        text = "the numbers except the distance of the axes are those of parts without errors"
        warnings += [reason for reason in (text, misfit) if reason]
    angle = math.radians(args.angle or 0.0)
    _output.save(args, plot=lambda plots: plots.plot_mechanism(mechanism, angle))
    try:
        _ = mechanism.driver_features or mechanism.path
    except InvalidValue as error:
        # the geometry is reported even if no motion can be computed for it
        warnings.append(str(error))
    units = {name: Result(kind) for name, kind in mechanism.report_units.items()}
    # a single solution would repeat what stands above
    units["solutions"] = Result(tabled=len(record.get("solutions", ())) > 1)
    found = Record(record, {"stations": _STATIONS} | units) | sizes
    warning = "; ".join(f"warning: {text}" for text in warnings)
    return _output.with_reasons(found, warning), inputs_of_mechanism(mechanism), 0


def _critical_friction(mechanism: Any, given: dict[str, float]) -> float:
    """The Painleve limit with these inertias."""
    if mechanism.meshed or mechanism.driver_features:
        raise UsageError(
            f"--driver-inertia must not come with a {mechanism.kind} mechanism, which has no "
            "slots and so no critical friction; leave it out"
        )
    if misfit := mechanism.misfit:
        raise UsageError(f"--driver-inertia must come with parts that fit, got: {misfit}")
    return esc.critical_friction(mechanism, Inertia(**given))


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


def _sizes(mechanism: Any, shaft: float | None) -> tuple[Record, list[str]]:
    """Sizes of a Geneva wheel's follower, and what is wrong with its shaft, if one is given."""
    wheel = isinstance(mechanism, esc.Geneva)
    if shaft is not None and not (wheel and not mechanism.internal and mechanism.crank_radius):
        rule = "come with an external Geneva wheel and its --crank-radius"
        raise UsageError(f"--follower-shaft-radius must {rule}, got none; leave it out")
    if not wheel:
        return Record({}), []
    from escapement.outlines.part_record import record_of_sizes

    record, warning = record_of_sizes(mechanism, shaft)
    return record, [warning] * (warning != "")
