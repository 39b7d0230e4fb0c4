"""What is told of an indexing drive, in the order in which the engineer of a machine reads it."""

import math
from typing import Any

from escapement.base.records import Record
from escapement.base.results import Result
from escapement.constant_speed.drive_record import DRIVE, filemon_figures
from escapement.constant_speed.indexing import IndexingDrive


def _sized(drive: IndexingDrive) -> bool:
    return drive.mechanism.crank_radius is not None


def _slotted(drive: IndexingDrive) -> bool:
    return not drive.mechanism.meshed


def _stressed(drive: IndexingDrive) -> bool:
    return drive.pin_length > 0.0


def _loose(drive: IndexingDrive) -> bool:
    return bool(drive.mechanism.clearance > 0.0)


def _elastic(drive: IndexingDrive) -> bool:
    return drive.load_frequency > 0.0


def _locked(drive: IndexingDrive) -> bool:
    return drive.locking_radius > 0.0


_NO_FORCE = "give the crank radius"
_NO_WALL = "the pin stays on its wall, or the index ends before it meets one again"

INDEX = {
    "index_time": Result("time", "time in which the follower moves"),
    "dwell_time": Result("time", "time in which it rests"),
    "motion_ratio": Result("ratio", "share of the cycle in which it moves"),
    "follower_velocity_max": Result("speed", "greatest speed of the follower"),
    "follower_acceleration_max": Result("acceleration", "greatest acceleration of the follower"),
    "contact_moment_max": Result(
        "torque", "greatest moment on the follower", label="moment on the follower max"
    ),
    "torque_max": Result("torque", "greatest torque of the drive"),
    "torque_max_deg": Result("degrees", "driver angle of it", label="torque max at"),
    "torque_min": Result("torque", "least torque; below zero the follower drives"),
    "torque_min_deg": Result("degrees", "driver angle of it", label="torque min at"),
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
        "degrees", "driver angle of it", exists=_sized, label="force on the pin max at"
    ),
    "pressure_max": Result(
        "pressure", "greatest pressure between pin and wall", exists=_stressed,
        missing="give the crank radius and the radius of the pin",
    ),
    "pin_diameter_needed": Result(
        "length", "diameter of the pin at the permitted pressure",
        exists=lambda drive: _stressed(drive) and drive.pressure_limit > 0.0, missing=_NO_FORCE,
    ),
    "pin_bending_max": Result(
        "pressure", "greatest bending stress of the pin", exists=_stressed,
        missing="give the crank radius and the radius of the pin",
    ),
    "pin_shear_max": Result(
        "pressure", "greatest mean shear stress of the pin", exists=_stressed,
        missing="give the crank radius and the radius of the pin",
    ),
    "entry_impact_deg": Result(
        "degrees", "where the pin meets its slot", exists=_loose, label="entry impact at"
    ),
    "entry_impact_speed": Result("slip", "speed of this impact", exists=_loose),
    "entry_impact_energy": Result("energy", "energy lost in it", exists=_loose),
    "lift_off_deg": Result(
        "degrees", "where the pin leaves the front wall", exists=_loose, label="lift off at"
    ),
    "reversal_flight_time": Result(
        "time", "time until it meets a wall again", exists=_loose, missing=_NO_WALL
    ),
    "reversal_impact_deg": Result(
        "degrees", "where it does", exists=_loose, label="reversal impact at"
    ),
    "reversal_impact_speed": Result("slip", "speed of this impact", exists=_loose),
    "reversal_impact_energy": Result("energy", "energy lost in it", exists=_loose),
    "deflection_max": Result("angle", "greatest angle of the load from the wheel", exists=_elastic),
    "residual_amplitude": Result("angle", "amplitude left after the index", exists=_elastic),
    "settling_time_load": Result(
        "time", "time after the index until the load is within its tolerance", exists=_elastic,
        missing="without damping the load rings on",
    ),
    "locking_torque": Result(
        "torque", "friction of the locking disc in the dwell", exists=_locked,
        missing="give the crank radius and the locking angle",
    ),
}  # fmt: skip
"""Figures of an indexing drive by name. Those with "_deg" are angles in degrees."""


def record_of(drive: IndexingDrive) -> Record:
    """The figures of a drive in SI, and Filemon's; those that it cannot have are left out."""
    found: dict[str, Any] = {}
    for name, result in INDEX.items():
        if result.exists is None or result.exists(drive):
            angle = name.endswith("_deg")
            value = getattr(drive, name.removesuffix("_deg") + "_angle" if angle else name)
            found[name] = math.degrees(value) if angle else value
    return Record(found | filemon_figures(drive), DRIVE | INDEX)
