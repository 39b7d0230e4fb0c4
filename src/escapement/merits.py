"""The figures of merit that there are, each with its unit and what it is.

`metrics` reads them off a motion; reports, studies, files and plots take them from here.
"""

from typing import NamedTuple

from escapement.units import unit_name


class Result(NamedTuple):
    """A number of every case: its kind of unit, what it is, and how a file stores it."""

    kind: str
    long_name: str
    dtype: str = "<f8"

    @property
    def units(self) -> str:
        """UDUNITS spelling of its unit in SI."""
        return unit_name(self.kind, "SI")


FIGURES = {
    "velocity_max": Result("speed", "largest driver velocity of the terminal cycle"),
    "velocity_min": Result("speed", "smallest driver velocity of the terminal cycle"),
    "velocity_mean": Result("speed", "mean driver velocity of the terminal cycle"),
    "velocity_average_published": Result("speed", "mean of largest and smallest driver velocity"),
    "period": Result("time", "period of one engagement of the terminal cycle"),
    "beat_error": Result("time", "longest less shortest engagement of the terminal cycle"),
    "blow_max": Result("energy", "energy lost in the greatest blow, its friction included"),
    "rise_time": Result("time", "time of the first velocity extremum within 2 % of terminal"),
    "rise_time_63": Result("time", "time in which the handoff velocity's deviation falls to 1/e"),
    "rise_time_98": Result("time", "time in which the handoff velocity's deviation falls to 0.02"),
    "settling_time": Result("time", "time from which every engagement's extremes are within 1 %"),
    "handoff_velocity": Result("speed", "driver velocity at the terminal handoff"),
    "contraction": Result("ratio", "factor by which an engagement shrinks a deviation"),
    "critical_friction": Result("ratio", "friction from which on no motion exists"),
    "uniqueness_friction": Result("ratio", "friction from which on another motion exists beside"),
    "jam_margin": Result("ratio", "1 - friction/critical friction"),
    "last_reversal_angle": Result("angle", "last pin reversal, from dead centre"),
    "acceleration_max": Result("acceleration", "greatest driver acceleration"),
    "follower_acceleration_max": Result("acceleration", "greatest follower acceleration"),
    "contact_moment_max": Result("torque", "greatest moment on the follower"),
    "contact_force_max": Result("force", "greatest force on the pin"),
    "energy_residual": Result("ratio", "energy unaccounted for, of the work done"),
}
"""Scalar figures of merit in the order in which they are reported."""
TRANSIENT = ("rise_time", "rise_time_63", "rise_time_98", "settling_time")
"""Those that depend on how the motion begins."""
