"""What a motor gives over a terminal cycle: its greatest and its effective torque."""

from collections.abc import Callable
from typing import Any

import numpy as np

from escapement.dynamics.figure_table import OF_MOTOR, is_motored
from escapement.mechanisms.protocol import FloatArray

_POINTS = 16
_MOST_PANELS = 256
_ERROR = 1e-11
"""Two numbers of panels whose integrals differ by less are enough [-]."""


def motor_figures(motion: Any) -> dict[str, float]:
    """Figures of a motor over a motion that repeats itself; NaN where no motor drives.

    speed_dip : greatest less least driver speed, as a share of the greatest [-].
    motor_torque_max : greatest torque of the motor [N m].
    motor_torque_rms : root of the mean square of its torque over time, to which its heating by
        the current is proportional [N m].
    motor_stall_share : `motor_torque_max` over its torque at rest [-].
    """
    escapement = motion.escapement
    if not is_motored(escapement):
        return dict.fromkeys(OF_MOTOR, np.nan)
    rest, torque, turns = _line(escapement) if escapement.no_load_speed else _curve(escapement)
    ends = motion.at([0.0, motion.end_time])
    speeds = np.append(motion.extrema.theta_dot, ends.theta_dot)
    least, most = speeds.min(), speeds.max()
    greatest = torque(np.append(speeds, turns[(turns > least) & (turns < most)])).max()
    effective = np.sqrt(_mean(motion, lambda speed: torque(speed) ** 2))
    found = 1.0 - least / most, greatest, effective, greatest / rest
    return dict(zip(OF_MOTOR, map(float, found), strict=True))


_Motor = tuple[float, Callable[[FloatArray], FloatArray], FloatArray]


def _line(escapement: Any) -> _Motor:
    """Torque at rest and over the driver speed, and the speeds at which it is greatest or least."""
    stall, no_load = escapement.torque, escapement.referred["no_load_speed"]
    return stall, lambda speed: stall * (1.0 - speed / no_load), np.empty(0)


def _curve(escapement: Any) -> _Motor:
    """As `_line`, of a torque over the speed."""
    curve, ratio = escapement.torque, escapement.barrel.ratio if escapement.barrel else 1.0
    return curve.greatest, lambda speed: curve(0.0, speed / ratio), ratio * curve.level_speeds


def _mean(motion: Any, function: Callable[[FloatArray], FloatArray]) -> float:
    """Mean over time of a function of the driver's speed."""
    start = motion.trajectory.start
    length = np.append(start[1:], motion.end_time) - start
    pieces = np.flatnonzero(length > 0.0)[:, None]
    start, length = start[pieces], length[pieces]
    points, weights = np.polynomial.legendre.leggauss(_POINTS)

    def integral(panels: int) -> float:
        shares: FloatArray = (np.arange(panels)[:, None] + 0.5 * (points + 1.0)) / panels
        values = function(motion.within(pieces, start + length * shares.ravel()).theta_dot)
        return float((length * np.tile(weights, panels) * values).sum() / (2.0 * panels))

    panels, before, found = 1, np.inf, integral(1)
    while abs(found - before) > _ERROR * found and panels < _MOST_PANELS:
        panels, before = 2 * panels, found
        found = integral(panels)
    return found / float(motion.end_time)
