"""What is told of a drive at constant speed, in the order in which it is read."""

import math
from typing import TYPE_CHECKING, Any

from escapement.base.errors import InvalidValue
from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.spoken import as_spoken
from escapement.constant_speed.extrema import limits_without_reversal

if TYPE_CHECKING:
    from escapement.constant_speed import Case
    from escapement.constant_speed.indexing import IndexingDrive
    from escapement.constant_speed.input_torque import DriveTorque

_NO_LIMIT = "no finite value makes the pin reverse"

DRIVE = {
    "index_time": Result("time", "time in which the follower moves"),
    "dwell_time": Result("time", "time in which it stands still"),
    "inertia_ratio": Result(
        "ratio", "I_f omega^2 over the load", label="inertia ratio F",
        missing="F is not defined without a load",
    ),
    "reversal_limits": Result(
        "ratio", "inertia ratios between the zones", label="reversal limits F12, F23",
        missing="the follower's deceleration ends at zero, so no inertia ratio lets it drive up to "
        "the end",
    ),
    "zone": Result("ratio", "zone of the inertia ratio"),
    "reversals_deg": Result("degrees", "driver angles at which the pin changes sides"),
    "torque_max": Result("torque", "greatest torque of the driver"),
    "torque_max_deg": Result("degrees", "driver angle of it", label="torque max at"),
    "torque_mean": Result("torque", "up to dead centre", label="torque mean to dead centre"),
    "torque_max_over_mean": Result(
        "ratio", "greatest over mean torque", missing="the mean torque is not above zero"
    ),
    "power_mean_to_dead_centre": Result("power", "mean power up to dead centre"),
    "power_max": Result("power", "greatest power"),
    "contact_force_max": Result("force", "greatest force on the pin"),
    "contact_force_max_deg": Result("degrees", "driver angle of it"),
    "greatest_speed": Result(
        "speed", "greatest driver speed", label="greatest speed without reversal",
        missing=_NO_LIMIT,
    ),
    "greatest_follower_inertia": Result(
        "inertia", "greatest inertia of the follower",
        label="greatest follower inertia without reversal", missing=_NO_LIMIT,
    ),
    "least_load_torque": Result(
        "torque", "least load", label="least load torque without reversal", missing=_NO_LIMIT
    ),
}  # fmt: skip
"""Figures of a drive by name. Those with "_deg" are angles in degrees."""


def doubt_of(drive: "Case") -> str:
    """What the scatter of a measured table makes uncertain; "" for other mechanisms."""
    if drive.moment_deviation == 0.0:
        return ""
    return (
        "the scatter of the table makes the contact moment uncertain by "
        f"{as_spoken(drive.moment_deviation, 'torque', 2)} (standard deviation), and the torque "
        "by this times the ratio; two reversals may be false if the moment between them is smaller "
        "than this"
    )


def filemon_figures(drive: "IndexingDrive") -> dict[str, Any]:
    """Filemon's figures of an indexing drive, by the names of `DRIVE` [SI].

    His numbers without reversal belong to a constant load.
    """
    if drive.load_curve is not None:
        reversals = [math.degrees(angle) for angle in drive.reversals.tolist()]
        return {"reversals_deg": reversals, "torque_mean": drive.torque_mean}
    thin = drive.thin
    found = record_of(thin).values
    names = (
        *("inertia_ratio", "reversal_limits", "zone", "reversals_deg", "torque_mean"),
        *("torque_max_over_mean", "power_mean_to_dead_centre", "greatest_speed"),
        *("greatest_follower_inertia", "least_load_torque"),
    )
    return {name: found[name] for name in names}


def record_of(result: "DriveTorque") -> Record:
    """The figures of a drive in SI; one that does not exist is NaN or infinite.

    The contact force needs a crank radius, and is left out without one.
    """
    try:
        ratio = result.inertia_ratio
    except InvalidValue:
        # without a load there is none
        ratio = math.nan
    mechanism: Any = result.mechanism
    cell = mechanism.cell_angle / result.speed
    found = {
        "index_time": mechanism.motion_ratio * cell,
        "dwell_time": (1.0 - mechanism.motion_ratio) * cell,
        "inertia_ratio": ratio,
        "reversal_limits": list(result.reversal_limits),
        "reversals_deg": [math.degrees(angle) for angle in result.reversals.tolist()],
        "torque_max_deg": math.degrees(result.torque_max_angle),
        "torque_max_over_mean": result.peak_to_mean,
        **limits_without_reversal(result),
    }
    if mechanism.crank_radius is not None:
        found["contact_force_max"], angle = result.contact_force_max
        found["contact_force_max_deg"] = math.degrees(angle)
    elsewhere = DRIVE.keys() - found.keys() - {"contact_force_max", "contact_force_max_deg"}
    found |= {name: getattr(result, name) for name in elsewhere}
    return Record({name: found[name] for name in DRIVE if name in found}, DRIVE)
