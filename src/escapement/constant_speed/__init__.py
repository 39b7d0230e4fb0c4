"""Constant driver speed: torque, power and pin reversals (Filemon 1960).

Modules are loaded when they are first asked for: what a case is made of can be told without.
"""

from typing import TYPE_CHECKING, Any

from escapement.lazy import offered

if TYPE_CHECKING:
    from escapement.constant_speed.case import contact_moment
    from escapement.constant_speed.extrema import (
        Extremum,
        TransmissionExtrema,
        fewest_slots,
        greatest_follower_inertia,
        greatest_speed,
        jerk_function,
        least_load_torque,
        transmission_extrema,
    )
    from escapement.constant_speed.study import ReversalStudy, reversal_study
    from escapement.constant_speed.torque import (
        DriveTorque,
        TorqueState,
        drive_torque,
        inertia_ratio,
    )

__all__ = [
    "DriveTorque",
    "Extremum",
    "ReversalStudy",
    "TorqueState",
    "TransmissionExtrema",
    "contact_moment",
    "drive_torque",
    "fewest_slots",
    "greatest_follower_inertia",
    "greatest_speed",
    "inertia_ratio",
    "jerk_function",
    "least_load_torque",
    "reversal_study",
    "transmission_extrema",
]

_MODULES = ("torque", "case", "extrema", "study")


def __getattr__(name: str) -> Any:
    return offered(__name__, __all__, _MODULES, name)
