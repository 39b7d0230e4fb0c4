"""Drive torque, power and pin reversals at constant driver speed."""

import math
from typing import TYPE_CHECKING, Any

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.quantity import declared
from escapement.base.units import printed
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError, option
from escapement.constant_speed import Case
from escapement.model.inputs import inputs_of_mechanism, inputs_of_settings

if TYPE_CHECKING:
    from escapement.constant_speed import DriveTorque


_KINDS = {
    "torque_max": "torque", "torque_mean": "torque", "power_mean_to_dead_centre": "power",
    "power_max": "power", "index_time": "time", "dwell_time": "time", "contact_force_max": "force",
}  # fmt: skip
_THICK = ("pin_radius", "roller_radius")


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    _arguments.add_group(parser, "model", declared(Case))
    _arguments.add_plot(parser.add_argument_group("output"), "draw the torque")


def execute(args: Arguments) -> int:
    """Print the figures; draw the torque where asked for."""
    _output.check_wanted(args)
    from escapement.constant_speed.extrema import LIMITS

    _arguments.require(args, declared(Case))
    for name in _THICK:
        if getattr(args, name):
            remedy = (
                "without friction it changes nothing, and with friction only thin pins are known"
            )
            raise UsageError(f"{option(name)} must be left out at constant speed: {remedy}")
    mechanism = _arguments.read_mechanism(args)
    result = esc.drive_torque(mechanism, **_arguments.typed(args, declared(Case)))
    _output.draw(args.plot, lambda plots: plots.plot_drive_torque(result, units=args.units))
    kinds = _KINDS | LIMITS
    known = [*inputs_of_mechanism(mechanism), *inputs_of_settings(result, mechanism.meshed)]
    _output.report(args, summarise(result), kinds, _doubt(result, args.units), known)
    return 0


def summarise(result: "DriveTorque") -> dict[str, Any]:
    """The reported numbers by JSON key, in SI; one that does not exist is NaN or infinite."""
    from escapement.constant_speed.extrema import limits_without_reversal

    try:
        ratio = result.inertia_ratio
    except InvalidValue:
        # without a load there is none
        ratio = math.nan
    mechanism: Any = result.mechanism
    cell = mechanism.cell_angle / result.speed
    force = {}
    if mechanism.crank_radius is not None:
        force["contact_force_max"], angle = result.contact_force_max
        force["contact_force_max_deg"] = math.degrees(angle)
    return {
        "index_time": mechanism.motion_ratio * cell,
        "dwell_time": (1.0 - mechanism.motion_ratio) * cell,
        "inertia_ratio": ratio,
        "reversal_limits": list(result.reversal_limits),
        "zone": result.zone,
        "reversals_deg": [math.degrees(angle) for angle in result.reversals.tolist()],
        "torque_max": result.torque_max,
        "torque_max_deg": math.degrees(result.torque_max_angle),
        "torque_mean": result.torque_mean,
        "torque_max_over_mean": result.peak_to_mean,
        "power_mean_to_dead_centre": result.power_mean_to_dead_centre,
        "power_max": result.power_max,
        **force,
        **limits_without_reversal(result),
    }


def _doubt(result: "DriveTorque", units: str) -> str:
    """The uncertainty due to the scatter of a measured table; "" for other mechanisms."""
    if result.moment_deviation == 0.0:
        return ""
    doubt = _output.in_units(result.moment_deviation, "torque", units)
    return (
        f"the scatter of the table makes the contact moment uncertain by {doubt:.2g} "
        f"{printed('torque', units)} (standard deviation), and the torque by this times the "
        "ratio; two reversals may be false if the moment between them is smaller than this"
    )
