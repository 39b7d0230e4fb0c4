"""The follower's motion over a whole cycle at constant driver speed, dwell included."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement import _validate
from escapement.mechanisms import GearDriven, Geneva
from escapement.model import FloatArray


@dataclass(frozen=True)
class FollowerMotion:
    """Motion of the follower: arrays of one shape.

    time : in cycles, from the entry of a pin.
    angle : in steps, 0 at that entry.
    velocity, acceleration, jerk : in steps per cycle, its square and its cube. The
        impulses of jerk where the wheel starts and stops are not in it.
    """

    time: FloatArray
    angle: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    jerk: FloatArray


def follower_motion(mechanism: GearDriven | Geneva, time: ArrayLike) -> FollowerMotion:
    """Follower angle, velocity, acceleration and jerk at constant driver speed.

    Parameters
    ----------
    mechanism : GearDriven or Geneva
        What moves. In a dwell the follower rests.
    time : array_like
        In cycles from the entry of a pin, of any sign and size.

    Raises
    ------
    InvalidValue
        For another mechanism, or a time that is not finite.

    Notes
    -----
    With q = C'/C and both on the circle of `motion_peaks`, u' = (s - 2g)(g1 + g2 - 2g)/2
    and g'' = u'(s - 2g) - 2 u g'. A wheel in uniform motion has neither g' nor g''.
    """
    if not isinstance(mechanism, GearDriven | Geneva):
        raise _validate.fail(
            "mechanism", "a slotted wheel", mechanism, "give a Geneva or a GearDriven"
        )
    at = np.asarray(time, dtype=float)
    if not np.isfinite(at).all():
        raise _validate.fail("time", "finite", time, "give times in cycles")
    cell, half = mechanism.cell_angle, mechanism.breaks[-1]
    step, whole = mechanism.follower_step, np.floor(at)
    theta = (at - whole) * cell - half
    moving = theta <= half
    theta = np.minimum(theta, half)
    found = mechanism.transmission(theta)
    rates = (found.g, found.dg, _jerk(mechanism, found.g, found.u, found.dg))
    angle = whole + 0.5 + mechanism.follower_angle(theta) / step
    scaled = (np.where(moving, x, 0.0) * cell ** (i + 1) / step for i, x in enumerate(rates))
    return FollowerMotion(at, angle, *scaled)


def _jerk(
    mechanism: GearDriven | Geneva, g: FloatArray, u: FloatArray, dg: FloatArray
) -> FloatArray:
    if isinstance(mechanism, GearDriven) and mechanism.through_centre:
        return np.zeros_like(g)
    path = mechanism.path
    circle = path[3] / path[1] + (path[3] + path[4]) / (path[1] + path[2])
    turn = path[6] - 2.0 * g
    return 0.5 * turn * (circle - 2.0 * g) * turn - 2.0 * u * dg
