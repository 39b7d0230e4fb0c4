"""Constant driver speed: torque, power and pin reversals (Filemon 1960)."""

from escapement.constant_speed.contact import contact_moment
from escapement.constant_speed.design import (
    fewest_slots,
    greatest_follower_inertia,
    greatest_speed,
    least_load_torque,
)
from escapement.constant_speed.extrema import (
    Extremum,
    TransmissionExtrema,
    jerk_function,
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
