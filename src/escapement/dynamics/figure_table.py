"""All figures of merit, each with its unit and a description.

`figures_of_merit` computes them from a motion; reports, studies, files and plots use these names.
"""

from typing import Any

from escapement.base.results import Result


def _slotted(escapement: Any) -> bool:
    return not escapement.mechanism.meshed and escapement.mechanism.pitch is None


def _sized(escapement: Any) -> bool:
    return escapement.mechanism.crank_radius is not None


def _stressed(escapement: Any) -> bool:
    return bool(escapement.pin_length)


def is_motored(escapement: Any) -> bool:
    """Whether a motor drives it: a torque that falls with the speed, or follows it in a table."""
    curve = escapement.drive_curve
    of_speed = curve is not None and curve.speed and not curve.angle
    return escapement.no_load_speed is not None or bool(of_speed)


def _never(_escapement: Any) -> bool:
    """Of what studies compute, since only these know the length of a run."""
    return False


def uneven(escapement: Any) -> bool:
    """Whether engagements may differ from each other, or begin with a blow."""
    return escapement.contact or len(escapement.pairs) > 1


RUN_TIME = "run_time"
FIGURES = {
    "velocity_max": Result("speed", "largest driver velocity of the terminal cycle"),
    "velocity_min": Result("speed", "smallest driver velocity of the terminal cycle"),
    "velocity_mean": Result("speed", "mean driver velocity of the terminal cycle"),
    "velocity_average_published": Result("speed", "mean of largest and smallest driver velocity"),
    "period": Result("time", "period of one engagement of the terminal cycle"),
    "beat_error": Result(
        "time", "longest minus shortest engagement of the terminal cycle", exists=uneven
    ),
    "blow_max": Result(
        "energy", "energy lost in the greatest impact, its friction included", exists=uneven
    ),
    RUN_TIME: Result("time", "time in which the driver makes its turns", exists=_never),
    "rise_time": Result("time", "time of the first velocity extremum within 2 % of terminal"),
    "rise_time_63": Result("time", "time in which the handoff velocity's deviation falls to 1/e"),
    "rise_time_98": Result("time", "time in which the handoff velocity's deviation falls to 0.02"),
    "settling_time": Result("time", "time from which every engagement's extremes are within 1 %"),
    "handoff_velocity": Result("speed", "driver velocity at the terminal handoff"),
    "contraction": Result("ratio", "factor by which an engagement shrinks a deviation"),
    "critical_friction": Result(
        "ratio", "friction at and above which no motion exists", exists=_slotted,
        missing="it has no slots in which friction can jam pins",
    ),
    "uniqueness_friction": Result(
        "ratio", "friction at and above which the motion is not unique", unlike="critical_friction"
    ),
    "jam_margin": Result("ratio", "1 - friction/critical friction"),
    "last_reversal_angle": Result(
        "angle", "last pin reversal, from dead centre", missing="the pin does not reverse"
    ),
    "acceleration_max": Result("acceleration", "greatest driver acceleration"),
    "follower_acceleration_max": Result("acceleration", "greatest follower acceleration"),
    "contact_moment_max": Result("torque", "greatest moment on the follower"),
    "contact_force_max": Result("force", "greatest force on the pin", exists=_sized),
    "rubbing_max": Result(
        "power", "greatest product of force on the pin and sliding speed", exists=_sized
    ),
    "pressure_max": Result("pressure", "greatest pressure between pin and wall", exists=_stressed),
    "pin_bending_max": Result("pressure", "greatest bending stress of the pin", exists=_stressed),
    "pin_shear_max": Result(
        "pressure", "greatest mean shear stress of the pin", exists=_stressed
    ),
    "pressure_speed_max": Result(
        "pressure_speed", "greatest mean pressure times sliding speed", exists=_stressed
    ),
    "pin_load_frequency": Result(
        "frequency", "load cycles of each pin in a second", exists=_stressed
    ),
    "speed_dip": Result(
        "ratio", "share by which the driver velocity falls below its greatest", exists=is_motored
    ),
    "motor_torque_max": Result("torque", "greatest torque of the motor", exists=is_motored),
    "motor_torque_rms": Result(
        "torque", "root mean square of the motor's torque over time", exists=is_motored
    ),
    "motor_stall_share": Result(
        "ratio", "greatest torque of the motor over its torque at rest", exists=is_motored
    ),
    "energy_residual": Result("ratio", "energy unaccounted for, as a share of the work"),
}  # fmt: skip
"""Scalar figures of merit in the order in which they are reported."""
PEAKS = (
    *("acceleration_max", "follower_acceleration_max", "contact_moment_max", "contact_force_max"),
    "rubbing_max",
)
"""Greatest magnitudes over a motion, in the order in which engines and `find_peaks` give them."""
OF_MOTOR = ("speed_dip", "motor_torque_max", "motor_torque_rms", "motor_stall_share")
"""Figures of a motor."""
TRANSIENT = ("rise_time", "rise_time_63", "rise_time_98", "settling_time")
"""Figures that depend on the start of the motion."""
