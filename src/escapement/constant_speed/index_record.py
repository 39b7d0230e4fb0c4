"""What is told of an indexing drive, in the order in which the engineer of a machine reads it."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.spoken import as_spoken

if TYPE_CHECKING:
    from escapement.constant_speed.indexing import IndexingDrive


def _has(*numbers: str, but: str = "") -> Callable[[Any], bool]:
    """Whether a drive, or its mechanism, has all of these numbers, and not another one."""

    def given(drive: Any, name: str) -> bool:
        return bool(vars(drive).get(name) or drive.lengths.get(name))

    return lambda drive: all(given(drive, x) for x in numbers) and not (but and given(drive, but))


_LOOSE, _ELASTIC, _STRESSED = _has("clearance"), _has("load_frequency"), _has("pin_length")


def _constant(drive: Any) -> bool:
    return drive.load_curve is None


def _slotted(drive: Any) -> bool:
    return not drive.mechanism.meshed


_NO_FORCE = "give the crank radius"
_NO_PIN = "give the crank radius and the radius of the pin"
_NO_WALL = "the pin stays on its wall, or the index ends before it meets one again"
_NO_LIMIT = "no finite value makes the pin reverse"

INDEX = {
    "index_time": Result("time", "time in which the follower moves"),
    "dwell_time": Result("time", "time in which it rests"),
    "cycle_time": Result("time", "time from one index to the next"),
    "motion_ratio": Result("ratio", "share of the cycle in which it moves"),
    "follower_velocity_max": Result("speed", "greatest speed of the follower"),
    "follower_acceleration_max": Result("acceleration", "greatest acceleration of the follower"),
    "contact_moment_max": Result(
        "torque", "greatest moment on the follower", label="moment on the follower max"
    ),
    "torque_max": Result("torque", "greatest torque of the drive"),
    "torque_max_deg": Result(
        "degrees", "driver angle of the greatest torque", label="torque max at"
    ),
    "torque_min": Result("torque", "least torque; below zero the follower drives"),
    "torque_min_deg": Result(
        "degrees", "driver angle of the least torque", label="torque min at"
    ),
    "torque_mean_index": Result("torque", "mean while the follower moves"),
    "torque_mean_cycle": Result("torque", "mean over the cycle, dwell included"),
    "torque_rms": Result("torque", "root mean square over the cycle"),
    "power_max": Result("power", "greatest power"),
    "power_mean": Result("power", "mean power over the cycle"),
    "contact_force_max": Result(
        "force", "greatest force on the pin", exists=_slotted, missing=_NO_FORCE,
        label="force on the pin max",
    ),
    "contact_force_max_deg": Result(
        "degrees", "driver angle of the greatest force", exists=_has("crank_radius"),
        label="force on the pin max at",
    ),
    "pressure_max": Result(
        "pressure", "greatest pressure between pin and wall", exists=_STRESSED, missing=_NO_PIN
    ),
    "pin_diameter_needed": Result(
        "length", "diameter of the pin at the permitted pressure",
        exists=_has("pin_length", "pressure_limit"), missing=_NO_FORCE,
    ),
    "pin_bending_max": Result(
        "pressure", "greatest bending stress of the pin", exists=_STRESSED, missing=_NO_PIN
    ),
    "pin_shear_max": Result(
        "pressure", "greatest mean shear stress of the pin", exists=_STRESSED, missing=_NO_PIN
    ),
    "rubbing_max": Result(
        "power", "greatest product of force on the pin and sliding speed", exists=_STRESSED,
        missing=_NO_FORCE,
    ),
    "pressure_speed_max": Result(
        "pressure_speed", "greatest mean pressure times sliding speed",
        exists=_has("pin_length", but="roller_radius"), missing=_NO_PIN,
    ),
    "pin_load_frequency": Result(
        "frequency", "load cycles of each pin in a second", exists=_STRESSED
    ),
    "pin_loads": Result(
        "ratio", "load cycles of each pin over the running time", exists=_has("running_time")
    ),
    "entry_impact_deg": Result(
        "degrees", "where the pin meets its slot", exists=_LOOSE, label="entry impact at"
    ),
    "entry_impact_speed": Result("slip", "speed at which the pin meets its slot", exists=_LOOSE),
    "entry_impact_energy": Result(
        "energy", "energy lost when the pin meets its slot", exists=_LOOSE
    ),
    "lift_off_deg": Result(
        "degrees", "where the pin leaves the wall that it met", exists=_LOOSE, label="lift off at"
    ),
    "reversal_flight_time": Result(
        "time", "time until the pin meets a wall again", exists=_LOOSE, missing=_NO_WALL
    ),
    "reversal_impact_deg": Result(
        "degrees", "where the pin meets a wall again", exists=_LOOSE, label="reversal impact at"
    ),
    "reversal_impact_speed": Result(
        "slip", "speed at which the pin meets a wall again", exists=_LOOSE
    ),
    "reversal_impact_energy": Result(
        "energy", "energy lost when the pin meets a wall again", exists=_LOOSE
    ),
    "deflection_max": Result("angle", "greatest angle of the load from the wheel", exists=_ELASTIC),
    "residual_amplitude": Result("angle", "amplitude left after the index", exists=_ELASTIC),
    "settling_time_load": Result(
        "time", "time after the index until the load is within its tolerance", exists=_ELASTIC,
        missing="without damping the load rings on",
    ),
    "dwell_left": Result(
        "time", "time of the dwell after that; below zero the load still rings", exists=_ELASTIC
    ),
    "locking_torque": Result(
        "torque", "friction of the locking disc in the dwell", exists=_has("locking_radius"),
        missing=_NO_FORCE,
    ),
    "inertia_ratio": Result(
        "ratio", "I_f omega^2 over the load", label="inertia ratio F", exists=_constant,
        missing="F is not defined without a load",
    ),
    "reversal_limits": Result(
        "ratio", "inertia ratios between the zones", label="reversal limits F12, F23",
        exists=_constant,
        missing="the follower's deceleration ends at zero, so no inertia ratio lets it drive up to "
        "the end",
    ),
    "zone": Result("ratio", "zone of the inertia ratio"),
    "reversals_deg": Result("degrees", "driver angles at which the pin changes sides"),
    "torque_mean": Result(
        "torque", "mean torque up to dead centre", label="torque mean to dead centre"
    ),
    "torque_max_over_mean": Result(
        "ratio", "greatest torque over the mean up to dead centre",
        missing="the mean torque is not above zero",
    ),
    "power_mean_to_dead_centre": Result("power", "mean power up to dead centre"),
    "greatest_speed": Result(
        "speed", "greatest driver speed without reversal under the load alone",
        label="greatest speed without reversal", missing=_NO_LIMIT, exists=_constant,
    ),
    "greatest_follower_inertia": Result(
        "inertia", "greatest inertia of the follower without reversal under the load alone",
        label="greatest follower inertia without reversal", missing=_NO_LIMIT, exists=_constant,
    ),
    "least_load_torque": Result(
        "torque", "least load without reversal", label="least load torque without reversal",
        missing=_NO_LIMIT, exists=_constant,
    ),
}  # fmt: skip
"""Figures of an indexing drive by name. Those with "_deg" are angles in degrees."""
_ATTRIBUTES = {name: name.replace("_deg", "_angle") for name in INDEX}


def in_si(drive: Any, name: str) -> Any:
    """A figure of a drive, or of many, in SI."""
    return getattr(drive, _ATTRIBUTES.get(name, name))


def record_of(drive: "IndexingDrive") -> Record:
    """The figures of a drive in SI; those that it cannot have are left out."""
    import numpy as np

    lists: dict[str, Any] = {"reversals_deg": np.degrees(drive.reversals).tolist()}
    lists["reversal_limits"] = [*drive.reversal_limits]
    found: dict[str, Any] = {}
    for name, result in INDEX.items():
        if result.exists is None or result.exists(drive):
            value = lists[name] if name in lists else in_si(drive, name)
            degrees = result.kind == "degrees" and name not in lists
            found[name] = math.degrees(value) if degrees else value
    return Record(found, INDEX)


def doubt_of(drive: "IndexingDrive") -> str:
    """What the scatter of a measured table makes uncertain; "" for other mechanisms."""
    if drive.moment_deviation == 0.0:
        return ""
    return (
        "the scatter of the table makes the contact moment uncertain by "
        f"{as_spoken(drive.moment_deviation, 'torque', 2)} (standard deviation), and the torque "
        "by this times the ratio; two reversals may be false if the moment between them is smaller "
        "than this"
    )
