"""The law of two bodies that are free or touch at one point, in natural units.

With the touch of `touch`, the sign sigma of the slip and the torques Q without the contact,

    B_b = G_b - mu sigma H_b - sense_b journal_b,      A = sum G_b B_b/I_b,
    N = -(kappa + sum G_b Q_b/I_b)/A,                  I_b q_b'' = Q_b + N B_b

The sign of N does not depend on friction while A > 0.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.law import LOSSES
from escapement.dynamics.torque import torque_after
from escapement.engines.two_bodies.touch import place, touch_at
from escapement.numerics.jit import inner_jit

MOTION, STATE = 4, 10
"""Numbers of a state that move, its angles and speeds, and with the work that is lost."""
LOST = (*LOSSES[:5], "load")
"""What the numbers of a state after the speeds are: work lost since the start."""


class Law(NamedTuple):
    """Two bodies in natural units, see `model.scene.Scene` for the fields of the same name.

    centre : distance of the axes. rho : inertia of the driver. begin : driver angle at the start.
    spring, weight, rest : stiffness of the follower's spring, moment of its weight, and the angle
    at which both are at rest. restitution : of blows. plain : whether torques are constant in a
    flight.
    """

    centre: float
    rho: float
    mu: float
    torque: np.ndarray
    gain: float
    begin: float
    load: float
    bearing: float
    driver_drag: float
    follower_drag: float
    driver_viscous: float
    follower_viscous: float
    driver_journal: float
    follower_journal: float
    spring: float
    weight: float
    rest: float
    restitution: float
    plain: bool


class Mode(NamedTuple):
    """What the bodies do: the pair in contact, or -1, its images, and signs that last.

    sigma : sign of the slip. driver_sense, follower_sense : of the speeds; 0 of a body at rest that
        friction of its bearing holds.
    """

    pair: int
    nose: int
    track: int
    sigma: float
    driver_sense: float
    follower_sense: float


class Push(NamedTuple):
    """Accelerations of both bodies, normal force, slip, and the number A of the contact."""

    driver: float
    follower: float
    force: float
    slip: float
    yielding: float


@inner_jit
def torques(law, y):
    """Torques on both bodies without contact and without constant friction."""
    torque = law.gain * law.torque[2]
    if len(law.torque) != 3:
        torque = torque_after(y[0] - law.begin, law)[0]
    driver = torque - (law.driver_drag * abs(y[2]) + law.driver_viscous) * y[2]
    follower = -(law.follower_drag * abs(y[3]) + law.follower_viscous) * y[3]
    if law.spring != 0.0 or law.weight != 0.0:
        follower -= law.spring * (y[1] - law.rest) + law.weight * np.sin(y[1] - law.rest)
    return driver, follower


@inner_jit
def free(law, mode, y):
    """Both bodies without contact."""
    driver, follower = torques(law, y)
    driver, follower = (
        driver - mode.driver_sense * law.bearing,
        follower - mode.follower_sense * law.load,
    )
    still = law.bearing > 0.0 and mode.driver_sense == 0.0
    held = law.load > 0.0 and mode.follower_sense == 0.0
    return Push(
        driver=0.0 if still else driver / law.rho, follower=0.0 if held else follower, force=0.0,
        slip=0.0, yielding=1.0,
    )  # fmt: skip


@inner_jit
def pushed(law, mode, touch, y):
    """Both bodies with the contact at a touch."""
    driver, follower = torques(law, y)
    driver, follower = (
        driver - mode.driver_sense * law.bearing,
        follower - mode.follower_sense * law.load,
    )
    rubbing = law.mu * mode.sigma
    b0 = touch.g0 - rubbing * touch.h0 - mode.driver_sense * law.driver_journal
    b1 = touch.g1 - rubbing * touch.h1 - mode.follower_sense * law.follower_journal
    yielding = touch.g0 * b0 / law.rho + touch.g1 * b1
    force = -(touch.kappa + touch.g0 * driver / law.rho + touch.g1 * follower) / yielding
    return Push(
        driver=(driver + force * b0) / law.rho, follower=follower + force * b1, force=force,
        slip=touch.h0 * y[2] + touch.h1 * y[3], yielding=yielding,
    )  # fmt: skip


@inner_jit
def touching(law, pairs, mode, y):
    """The touch of the pair in contact."""
    pair = pairs[mode.pair]
    return touch_at(pair, place(pair, law.centre, y, mode.nose, mode.track))


@inner_jit
def push_at(law, pairs, mode, y):
    """Accelerations and force in a state."""
    if mode.pair < 0:
        return free(law, mode, y)
    return pushed(law, mode, touching(law, pairs, mode, y), y)


@inner_jit
def rates(law, pairs, mode, y, out):
    """Write the rates of a state; those of lost work only where there is room for them."""
    push = push_at(law, pairs, mode, y)
    out[0], out[1], out[2], out[3] = y[2], y[3], push.driver, push.follower
    if len(out) > MOTION:
        driver, follower, force = abs(y[2]), abs(y[3]), push.force
        out[4] = law.mu * force * abs(push.slip)
        out[5] = (law.bearing + force * law.driver_journal) * driver
        out[6] = force * law.follower_journal * follower
        out[7] = (law.driver_drag * driver + law.driver_viscous) * driver * driver
        out[8] = (law.follower_drag * follower + law.follower_viscous) * follower * follower
        out[9] = law.load * follower


@inner_jit
def stored(law, phi):
    """Energy in the follower's spring and weight at an angle of the follower."""
    turn = phi - law.rest
    return 0.5 * law.spring * turn * turn + 2.0 * law.weight * np.sin(0.5 * turn) ** 2
