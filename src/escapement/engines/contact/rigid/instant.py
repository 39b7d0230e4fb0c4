"""Driver and follower at an instant, and the ways in which an instant follows from another."""

from typing import NamedTuple

import numpy as np

from escapement.engines.contact.rigid.walls import wall_of
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.jit import inner_jit


class Instant(NamedTuple):
    """Driver and follower at an instant of an engagement.

    theta, speed, phi, turning : angles and speeds, as in the package's docstring.
    time : since the entry of the pin.
    wall : the wall that the pin touches or has just left, 0 for none.
    trend : sign of theta_ddot before this instant, 0 if nothing is known of it.
    """

    theta: float
    speed: float
    phi: float
    turning: float
    time: float
    wall: float
    trend: float


@inner_jit
def instant_with(now, theta=None, speed=None, phi=None, turning=None, wall=None, trend=None):
    """The instant with other values of the fields that are given by their names."""
    return Instant(
        theta=now.theta if theta is None else theta,
        speed=now.speed if speed is None else speed,
        phi=now.phi if phi is None else phi,
        turning=now.turning if turning is None else turning,
        time=now.time,
        wall=now.wall if wall is None else wall,
        trend=now.trend if trend is None else trend,
    )


@inner_jit
def follower_on(walls, side, theta):
    """Follower angle, and g, while the pin touches a wall."""
    wheel = walls.clearance
    x, y = wheel.centre + wheel.crank * np.cos(theta), np.sin(theta)
    behind = np.arcsin(side * wheel.half_clearance / np.sqrt(x * x + y * y))
    return np.arctan2(y, x) - behind, pose_at(wall_of(walls, side).path, theta)[0]


@inner_jit
def on_wall(walls, now, theta, speed, time):
    """Another driver angle, speed and time, while the pin touches the same wall."""
    phi, g = follower_on(walls, now.wall, theta)
    return Instant(
        theta=theta, speed=speed, phi=phi, turning=g * speed, time=time, wall=now.wall,
        trend=now.trend,
    )  # fmt: skip
