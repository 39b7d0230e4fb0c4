"""Driver and follower at an instant, and the ways in which an instant follows from another."""

from typing import NamedTuple

from escapement.engines.contact.slot import follower_angle, frame_of, pose_across
from escapement.numerics.jit import inner_jit


class RigidState(NamedTuple):
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
def follower_on(walls, side, theta):
    """Follower angle, and g, while the pin touches a wall."""
    frame = frame_of(walls.plus)
    at = pose_across(frame, theta, side * walls.clearance.half_clearance, 0.0, 0.0)
    return follower_angle(frame, theta, at), at.cosine / at.radius


@inner_jit
def on_wall(walls, now, theta, speed, time):
    """Another driver angle, speed and time, while the pin touches the same wall."""
    phi, g = follower_on(walls, now.wall, theta)
    return RigidState(
        theta=theta, speed=speed, phi=phi, turning=g * speed, time=time, wall=now.wall,
        trend=now.trend,
    )  # fmt: skip
