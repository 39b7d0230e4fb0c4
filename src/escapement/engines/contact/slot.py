"""Position of a pin in its slot, from either pair of coordinates.

Lengths are in crank radii. In complex numbers, with the follower's axis at 0, the pin's centre is
at C = c + beta exp(i beta theta). The unit vector e points outwards along the slot, n = i e across
it in the sense in which the follower turns. The follower angle phi is 0 where the slot lies on the
line of centres. With gamma = beta theta - phi

    D = n.C = beta sin(gamma) - c sin(phi),        R = e.C = beta cos(gamma) + c cos(phi)
    D' = cos(gamma) theta_dot - R phi_dot                             speed across the slot
    v = (D + s r_p) phi_dot - (sin(gamma) + s beta r_p) theta_dot     sliding speed on the wall s

By virtual work the wall s, which presses the pin with the force N and rubs it with f N against v,
exerts torques that have the factors of the speeds in these lines: `pushes`.

A state holds theta and its rate, and in flight phi and phi_dot. While the pin touches a wall it
may hold D and D' instead: the force of a hard wall follows from them without a loss of digits, and
the position of the wall is constant in them. In this case

    exp(i gamma) = (c cos(theta) + beta + i beta c sin(theta)) (R + i D)/|C|^2
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.compliance import FREE
from escapement.mechanisms.path import L1, PIN_RATE
from escapement.numerics.jit import inner_jit


class Pose(NamedTuple):
    """D, R, sin(gamma), cos(gamma), D', theta_dot and phi_dot."""

    across: float
    radius: float
    sine: float
    cosine: float
    speed: float
    driver: float
    follower: float


class Frame(NamedTuple):
    """beta, and the distance c of the centres: all of a scene that the position depends on."""

    sense: float
    centre: float


@inner_jit
def frame_of(scene):
    """The frame of a scene; to hand it on takes much less time than to hand on the scene."""
    numbers = scene.path.numbers
    return Frame(sense=numbers[PIN_RATE], centre=0.25 * abs(numbers[L1]))


@inner_jit
def touches(mode):
    """Whether the pin touches a wall."""
    return mode == 1 or mode == -1


@inner_jit
def pose(y, mode, scene):
    """The position of the pin that belongs to a state."""
    if touches(mode):
        return pose_across(frame_of(scene), y[0], y[1], y[2], y[3])
    return free_pose(frame_of(scene), y[0], y[2], y[1], y[3])


@inner_jit
def free_pose(frame, theta, driver, phi, follower):
    """The position of the pin from angles and speeds of driver and follower."""
    sense, centre = frame.sense, frame.centre
    sine, cosine = np.sin(sense * theta - phi), np.cos(sense * theta - phi)
    radius = sense * cosine + centre * np.cos(phi)
    return Pose(
        across=sense * sine - centre * np.sin(phi), radius=radius, sine=sine, cosine=cosine,
        speed=cosine * driver - radius * follower, driver=driver, follower=follower,
    )  # fmt: skip


@inner_jit
def pose_across(frame, theta, across, driver, speed):
    """The position of the pin from angle and speed of the driver, D and D'."""
    sense, centre = frame.sense, frame.centre
    sine, cosine = np.sin(theta), np.cos(theta)
    square = 1.0 + centre * (centre + 2.0 * sense * cosine)
    radius = np.sqrt(square - across * across)
    p, q = (centre * cosine + sense) / square, sense * centre * sine / square
    sine, cosine = p * across + q * radius, p * radius - q * across
    return Pose(
        across=across, radius=radius, sine=sine, cosine=cosine, speed=speed, driver=driver,
        follower=(cosine * driver - speed) / radius,
    )  # fmt: skip


@inner_jit
def to_slot(y, scene):
    """Replace phi and phi_dot in a state by D and D'."""
    at = pose(y, FREE, scene)
    y[1], y[3] = at.across, at.speed


@inner_jit
def to_angle(y, scene):
    """Replace D and D' in a state by phi and phi_dot."""
    at = pose(y, 1, scene)
    y[1], y[3] = follower_angle(frame_of(scene), y[0], at), at.follower


@inner_jit
def follower_angle(frame, theta, at):
    """phi at a driver angle, from D and R of its pose."""
    direction = np.arctan2(np.sin(theta), frame.centre + frame.sense * np.cos(theta))
    return direction - np.arctan2(at.across, at.radius)


@inner_jit
def slide_factors(at, side, scene):
    """Factors of theta_dot and phi_dot in the sliding speed along the wall s = `side`."""
    arm = side * scene.pin
    return -(at.sine + scene.path.numbers[PIN_RATE] * arm), at.across + arm


@inner_jit
def slide(at, side, scene):
    """Sliding speed v of the contact point along the wall s = `side`."""
    by_driver, by_follower = slide_factors(at, side, scene)
    return by_driver * at.driver + by_follower * at.follower


@inner_jit
def pushes(at, side, f, scene):
    """Torques on driver and follower by a unit of force N of the wall s = `side`.

    `f` is the friction over N, positive where it resists a positive sliding speed.
    """
    by_driver, by_follower = slide_factors(at, side, scene)
    return -side * at.cosine - f * by_driver, side * at.radius - f * by_follower


@inner_jit
def journal_share(f, scene):
    """Force on the bearings by a unit of N, over that of a contact that slides.

    The numbers of the journals in a `Scene` are those of a pin that slides with full friction.
    """
    return np.sqrt((1.0 + f * f) / (1.0 + scene.mu_plus * scene.mu_plus))


@inner_jit
def acceleration_across(at, on_driver, on_follower, scene):
    """D'' from the accelerations of driver and follower."""
    along = at.follower * at.across - at.sine * at.driver
    turn = scene.path.numbers[PIN_RATE] * at.driver - at.follower
    inertial = at.sine * turn * at.driver + along * at.follower
    return at.cosine * on_driver - at.radius * on_follower - inertial
