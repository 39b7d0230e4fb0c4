"""`escapement drive-torque`: torque and pin reversals at constant driver speed."""

import argparse
import math
from typing import TYPE_CHECKING, Any

from escapement.cli import _arguments, _output
from escapement.cli._parser import Parser
from escapement.constant_speed.case import Case
from escapement.quantity import declared
from escapement.text import print_values, words
from escapement.units import unit_name

if TYPE_CHECKING:
    from escapement.constant_speed import DriveTorque

SUMMARY = "Drive torque, power and pin reversals at constant driver speed."


def configure(parser: Parser) -> None:
    """Add the command's arguments."""
    _arguments.add_mechanism(parser)
    model = parser.add_argument_group("model")
    for entry in declared(Case).values():
        _arguments.add_setting(model, entry, required=entry.required)
    output = parser.add_argument_group("output")
    _arguments.add_plot(output, "draw the torque")
    _arguments.add_common(parser)


def execute(args: argparse.Namespace) -> int:
    """Print the figures; draw the torque where asked for."""
    _output.check_wanted(args)
    from escapement.constant_speed import drive_torque

    mechanism = _arguments.read_mechanism(args)
    result = drive_torque(mechanism, **_arguments.typed(args, declared(Case)))
    if args.plot is not None:
        from escapement.plots import plot_drive_torque
        from escapement.plots.saving import save

        save(plot_drive_torque(result, units=args.units), args.plot)
    record = summarise(result, args.units)
    if args.json:
        _output.print_json(record)
    else:
        _print_table(record, args.units)
    if "message" in record:
        _output.note(record["message"])
    return 0


def summarise(result: "DriveTorque", units: str) -> dict[str, Any]:
    """What `drive-torque` reports, by JSON key, in the user's units.

    What does not exist is NaN or infinite here and null in JSON; then, and where a table's
    scatter leaves doubt, there is a `message` that says so.
    """
    from escapement.constant_speed.extrema import LIMITS, limits_without_reversal
    from escapement.errors import InvalidValue

    reasons = []
    try:
        ratio = result.inertia_ratio
    except InvalidValue as error:
        ratio = math.nan
        reasons.append(f"inertia_ratio: {error}")
    if not all(map(math.isfinite, result.reversal_limits)):
        reasons.append(
            "reversal_limits: the follower's deceleration ends at zero, so no inertia ratio "
            "lets it drive up to the end"
        )
    if math.isnan(result.peak_to_mean):
        reasons.append("torque_max_over_mean: the mean torque is not above zero")
    if result.moment_deviation > 0.0:
        doubt = _output.in_units(result.moment_deviation, "torque", units)
        reasons.append(
            f"the scatter of the table leaves the contact moment uncertain by {doubt:.2g} "
            f"{unit_name('torque', units)} (standard deviation), the torque by that times the "
            "ratio, and reversals between which the moment is smaller may be none"
        )
    free = {
        key: _output.in_units(value, LIMITS[key], units)
        for key, value in limits_without_reversal(result).items()
    }
    reasons += [
        f"{key}: no finite value makes the pin reverse"
        for key, value in free.items()
        if not math.isfinite(value)
    ]
    record = {
        "inertia_ratio": ratio,
        "reversal_limits": list(result.reversal_limits),
        "reversals_deg": [math.degrees(angle) for angle in result.reversals.tolist()],
        "zone": result.zone,
        "torque_max": _output.in_units(result.torque_max, "torque", units),
        "torque_max_deg": math.degrees(result.torque_max_angle),
        "torque_mean": _output.in_units(result.torque_mean, "torque", units),
        "torque_max_over_mean": result.peak_to_mean,
        "power_max": _output.in_units(result.power_max, "torque", units),
        **free,
    }
    return record | ({"message": "; ".join(reasons)} if reasons else {})


def _print_table(record: dict[str, Any], units: str) -> None:
    from escapement.constant_speed.extrema import LIMITS

    torque = unit_name("torque", units)
    power = f"{torque} s-1" if units != "SI" else "W"
    reversals = ", ".join(f"{angle:.6g}" for angle in record["reversals_deg"])
    limit_12, limit_23 = record["reversal_limits"]
    print_values(
        [
            ("inertia ratio F", record["inertia_ratio"], ""),
            ("reversal limit F12", limit_12, ""),
            ("reversal limit F23", limit_23, ""),
            ("zone", record["zone"], ""),
            ("reversals", reversals or "none", "deg" if reversals else ""),
            ("torque max", record["torque_max"], torque),
            ("torque max at", record["torque_max_deg"], "deg"),
            ("torque mean to dead centre", record["torque_mean"], torque),
            ("torque max over mean", record["torque_max_over_mean"], ""),
            ("power max", record["power_max"], power),
            *(
                (f"{words(key)} without reversal", record[key], unit_name(unit, units))
                for key, unit in LIMITS.items()
            ),
        ]
    )
