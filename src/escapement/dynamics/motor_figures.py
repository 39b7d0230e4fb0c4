"""What a motor gives over a terminal cycle: its greatest and its effective torque."""

from typing import Any

import numpy as np

from escapement.dynamics.figure_table import OF_MOTOR
from escapement.mechanisms.protocol import FloatArray

_POINTS = 16
_MOST_PANELS = 256
_ERROR = 1e-11
"""Two numbers of panels whose integrals differ by less are enough [-]."""


def motor_figures(motion: Any) -> dict[str, float]:
    """Figures of a motor over a motion that repeats itself; NaN where no motor drives.

    speed_dip : greatest less least driver speed, as a share of the greatest [-].
    motor_torque_max : torque of the motor at its least speed [N m].
    motor_torque_rms : root of the mean square of its torque over time, to which its heating by
        the current is proportional [N m].
    motor_stall_share : `motor_torque_max` over its torque at rest [-].
    """
    escapement = motion.escapement
    if escapement.no_load_speed is None:
        return dict.fromkeys(OF_MOTOR, np.nan)
    ends = motion.at([0.0, motion.end_time])
    speeds = np.append(motion.extrema.theta_dot, ends.theta_dot)
    stall, no_load = escapement.torque, escapement.referred["no_load_speed"]
    mean = (ends.theta[1] - ends.theta[0]) / motion.end_time
    square = 1.0 - 2.0 * mean / no_load + mean_square_speed(motion) / no_load**2
    share = 1.0 - speeds.min() / no_load
    found = 1.0 - speeds.min() / speeds.max(), stall * share, stall * np.sqrt(square), share
    return dict(zip(OF_MOTOR, map(float, found), strict=True))


def mean_square_speed(motion: Any) -> float:
    """Mean over time of the square of the driver's speed [rad^2/s^2]."""
    start = motion.trajectory.start
    length = np.append(start[1:], motion.end_time) - start
    pieces = np.flatnonzero(length > 0.0)[:, None]
    start, length = start[pieces], length[pieces]
    points, weights = np.polynomial.legendre.leggauss(_POINTS)

    def integral(panels: int) -> float:
        shares: FloatArray = (np.arange(panels)[:, None] + 0.5 * (points + 1.0)) / panels
        speed = motion.within(pieces, start + length * shares.ravel()).theta_dot
        return float((length * np.tile(weights, panels) * speed**2).sum() / (2.0 * panels))

    panels, before, found = 1, np.inf, integral(1)
    while abs(found - before) > _ERROR * found and panels < _MOST_PANELS:
        panels, before = 2 * panels, found
        found = integral(panels)
    return found / float(motion.end_time)
