"""`escapement drive-torque`: torque and pin reversals at constant driver speed."""

import argparse
import math
from typing import TYPE_CHECKING, Any

from escapement.cli import _arguments, _output
from escapement.cli._arguments import Parser
from escapement.constant_speed.case import Case
from escapement.quantity import declared
from escapement.units import factor, unit_name

if TYPE_CHECKING:
    from escapement.constant_speed import DriveTorque

SUMMARY = "Drive torque, power and pin reversals at constant driver speed."

QUANTITIES = {"torque_max": "torque", "torque_mean": "torque", "power_max": "power"}
LABELS = {
    "inertia_ratio": "inertia ratio F",
    "reversal_limits": "reversal limits F12, F23",
    "torque_max_deg": "torque max at",
    "torque_mean": "torque mean to dead centre",
    "greatest_speed": "greatest speed without reversal",
    "greatest_follower_inertia": "greatest follower inertia without reversal",
    "least_load_torque": "least load torque without reversal",
}


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
    from escapement.constant_speed.design import LIMITS

    _output.report(args, summarise(result, args.units), QUANTITIES | LIMITS, LABELS)
    return 0


def summarise(result: "DriveTorque", units: str) -> dict[str, Any]:
    """What `drive-torque` reports, by JSON key, in SI; the message names numbers in `units`.

    What does not exist is NaN or infinite here and null in JSON; then, and where a table's
    scatter leaves doubt, there is a `message` that says so.
    """
    from escapement.constant_speed.design import limits_without_reversal
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
        doubt = result.moment_deviation / factor("torque", units)
        reasons.append(
            f"the scatter of the table leaves the contact moment uncertain by {doubt:.2g} "
            f"{unit_name('torque', units)} (standard deviation), the torque by that times the "
            "ratio, and reversals between which the moment is smaller may be none"
        )
    free = limits_without_reversal(result)
    reasons += [
        f"{key}: no finite value makes the pin reverse"
        for key, value in free.items()
        if not math.isfinite(value)
    ]
    record = {
        "inertia_ratio": ratio,
        "reversal_limits": list(result.reversal_limits),
        "zone": result.zone,
        "reversals_deg": [math.degrees(angle) for angle in result.reversals.tolist()],
        "torque_max": result.torque_max,
        "torque_max_deg": math.degrees(result.torque_max_angle),
        "torque_mean": result.torque_mean,
        "torque_max_over_mean": result.peak_to_mean,
        "power_max": result.power_max,
        **free,
    }
    return record | ({"message": "; ".join(reasons)} if reasons else {})
