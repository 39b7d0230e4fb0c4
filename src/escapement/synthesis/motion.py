"""The follower's motion over a whole cycle at constant driver speed, dwell included."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.mechanisms import GearDriven, Geneva
from escapement.mechanisms.slotted import jerk
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
    A wheel in uniform motion has neither acceleration nor jerk.
    """
    if not isinstance(mechanism, GearDriven | Geneva):
        raise validate.fail(
            "mechanism", "a slotted wheel", mechanism, "give a Geneva or a GearDriven"
        )
    at = validate.numbers("time", time, "give times in cycles")
    cell, half = mechanism.cell_angle, mechanism.breaks[-1]
    step, whole = mechanism.follower_step, np.floor(at)
    theta = (at - whole) * cell - half
    moving = theta <= half
    theta = np.minimum(theta, half)
    found = mechanism.transmission(theta)
    uniform = isinstance(mechanism, GearDriven) and mechanism.through_centre
    change = np.zeros_like(found.g) if uniform else jerk(mechanism.path, found)
    rates = (found.g, found.dg, change)
    angle = whole + 0.5 + mechanism.follower_angle(theta) / step
    scaled = (np.where(moving, x, 0.0) * cell ** (i + 1) / step for i, x in enumerate(rates))
    return FollowerMotion(at, angle, *scaled)
