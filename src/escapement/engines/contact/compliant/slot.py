"""Position of a pin in its slot, from either pair of coordinates.

Lengths are in crank radii. In complex numbers, with the follower's axis at 0, the pin's centre is
at C = c + beta exp(i beta theta). The unit vector e points outwards along the slot, n = i e across
it in the sense in which the follower turns. The follower angle phi is 0 where the slot lies on the
line of centres. With gamma = beta theta - phi

    D = n.C = beta sin(gamma) - c sin(phi),        R = e.C = beta cos(gamma) + c cos(phi)
    D' = cos(gamma) theta_dot - R phi_dot          speed across the slot
    v = -sin(gamma) theta_dot + (D + s r_p) phi_dot - s beta r_p theta_dot        sliding speed

In flight the state holds phi and phi_dot. While the pin touches a wall it holds D and D' instead:
the force of a hard wall follows from them without a loss of digits, and the position of the wall
is constant in them. In this case

    exp(i gamma) = (c cos(theta) + beta + i beta c sin(theta)) (R + i D)/|C|^2
"""

from typing import NamedTuple

import numpy as np

from escapement.mechanisms.path import L1, PIN_RATE
from escapement.numerics.jit import inner_jit

FREE, LOCKED = 0, 2
"""Modes: no contact with a wall, and the follower locked in a dwell; +1 and -1 are the walls."""


class Pose(NamedTuple):
    """D, R, sin(gamma), cos(gamma), D', theta_dot and phi_dot."""

    across: float
    radius: float
    sine: float
    cosine: float
    speed: float
    driver: float
    follower: float


@inner_jit
def _centres(scene):
    """beta, and the distance c of the centres."""
    numbers = scene.path.numbers
    return numbers[PIN_RATE], 0.25 * abs(numbers[L1])


@inner_jit
def touches(mode):
    """Whether the pin touches a wall."""
    return mode == 1 or mode == -1


@inner_jit
def pose(y, mode, scene):
    """The position of the pin that belongs to a state."""
    sense, centre = _centres(scene)
    if touches(mode):
        across, sine, cosine = y[1], np.sin(y[0]), np.cos(y[0])
        square = 1.0 + centre * (centre + 2.0 * sense * cosine)
        radius = np.sqrt(square - across * across)
        p, q = (centre * cosine + sense) / square, sense * centre * sine / square
        sine, cosine = p * across + q * radius, p * radius - q * across
        follower = (cosine * y[2] - y[3]) / radius
        return Pose(
            across=across, radius=radius, sine=sine, cosine=cosine, speed=y[3], driver=y[2],
            follower=follower,
        )  # fmt: skip
    angle = sense * y[0] - y[1]
    sine, cosine = np.sin(angle), np.cos(angle)
    across = sense * sine - centre * np.sin(y[1])
    radius = sense * cosine + centre * np.cos(y[1])
    return Pose(
        across=across, radius=radius, sine=sine, cosine=cosine,
        speed=cosine * y[2] - radius * y[3], driver=y[2], follower=y[3],
    )  # fmt: skip


@inner_jit
def to_slot(y, scene):
    """Replace phi and phi_dot in a state by D and D'."""
    at = pose(y, FREE, scene)
    y[1], y[3] = at.across, at.speed


@inner_jit
def to_angle(y, scene):
    """Replace D and D' in a state by phi and phi_dot."""
    sense, centre = _centres(scene)
    at = pose(y, 1, scene)
    direction = np.arctan2(np.sin(y[0]), centre + sense * np.cos(y[0]))
    y[1], y[3] = direction - np.arctan2(at.across, at.radius), at.follower


@inner_jit
def slide(at, side, scene):
    """Sliding speed v of the contact point along the wall s = `side`."""
    arm = side * scene.pin
    beta = scene.path.numbers[PIN_RATE]
    return (at.across + arm) * at.follower - (at.sine + beta * arm) * at.driver


@inner_jit
def acceleration_across(at, on_driver, on_follower, scene):
    """D'' from the accelerations of driver and follower."""
    along = at.follower * at.across - at.sine * at.driver
    turn = scene.path.numbers[PIN_RATE] * at.driver - at.follower
    inertial = at.sine * turn * at.driver + along * at.follower
    return at.cosine * on_driver - at.radius * on_follower - inertial
