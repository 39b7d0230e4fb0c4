"""The law of two bodies that are free or touch at one point, in natural units.

With the touch of `touch`, the sign sigma of the slip and the torques Q without the contact,

    B_b = G_b - mu sigma H_b - sense_b journal_b,      A = sum G_b B_b/I_b,
    N = -(kappa + sum G_b Q_b/I_b)/A,                  I_b q_b'' = Q_b + N B_b

The sign of N does not depend on friction while A > 0.
"""

from collections import namedtuple

import numpy as np

from escapement.dynamics.torque import torque_after
from escapement.engines.two_bodies.touch import contact_at, place, touch_at
from escapement.numerics.jit import inner_jit

MOTION, STATE = 4, 10
"""Numbers of a state that move, its angles and speeds, and with the work that is lost: in the
contact, both bearings and the drag of both bodies, and to the load."""


Law = namedtuple("Law", (
    "rho mu_plus torque gain load bearing driver_drag follower_drag "
    "driver_viscous follower_viscous driver_journal follower_journal centre "
    "begin spring weight rest restitution plain"
))  # fmt: skip
"""Two bodies in natural units, see `model.scene.Scene` for the fields of the same name.

centre : distance of the axes. begin : driver angle at the start. spring, weight, rest :
stiffness of the follower's spring, moment of its weight, and the angle at which both are at
rest. restitution : of blows. plain : whether torques are constant in a flight."""


SHARED = Law._fields[: Law._fields.index("centre")]
"""Fields that are those of a `Scene`."""


Mode = namedtuple("Mode", "pair nose track sigma driver_sense follower_sense")
"""What the bodies do: the pair in contact, or -1, its images, and signs that last.

sigma : sign of the slip. driver_sense, follower_sense : of the speeds; 0 of a body at rest that
    friction of its bearing holds."""


Push = namedtuple("Push", "driver follower force moment slip yielding")
"""Accelerations of both bodies, normal force and its torque on the follower, slip, and A."""


@inner_jit(merged=True)
def torques(law, y):
    """Torques on both bodies without contact and without constant friction."""
    return _torques(law, y, np.sign(y[2]), np.sign(y[3]))


@inner_jit(merged=True)
def _torques(law, y, driver_sense, follower_sense):
    """The same for speeds that are taken to have these senses."""
    driver = law.gain * law.torque[2]
    if len(law.torque) != 3:
        driver = torque_after(y[0] - law.begin, law)[0]
    driver -= (law.driver_drag * driver_sense * y[2] + law.driver_viscous) * y[2]
    follower = -(law.follower_drag * follower_sense * y[3] + law.follower_viscous) * y[3]
    if law.spring != 0.0 or law.weight != 0.0:
        follower -= law.spring * (y[1] - law.rest) + law.weight * np.sin(y[1] - law.rest)
    return driver, follower


@inner_jit(merged=True)
def free(law, mode, y):
    """Both bodies without contact; friction of its bearing holds a body whose sense is 0."""
    driver, follower = _torques(law, y, mode.driver_sense, mode.follower_sense)
    driver = (driver - mode.driver_sense * law.bearing) / law.rho
    follower -= mode.follower_sense * law.load
    driver = 0.0 if law.bearing > 0.0 and mode.driver_sense == 0.0 else driver
    follower = 0.0 if law.load > 0.0 and mode.follower_sense == 0.0 else follower
    return Push(driver, follower, 0.0, 0.0, 0.0, 1.0)


@inner_jit(merged=True)
def pushed(law, mode, touch, y):
    """Both bodies with the contact at a touch."""
    driver, follower = _torques(law, y, mode.driver_sense, mode.follower_sense)
    driver -= mode.driver_sense * law.bearing
    follower -= mode.follower_sense * law.load
    rubbing = law.mu_plus * mode.sigma
    b0 = touch.g0 - rubbing * touch.h0 - mode.driver_sense * law.driver_journal
    b1 = touch.g1 - rubbing * touch.h1 - mode.follower_sense * law.follower_journal
    yielding = touch.g0 * b0 / law.rho + touch.g1 * b1
    force = -(touch.kappa + touch.g0 * driver / law.rho + touch.g1 * follower) / yielding
    slip, moment = touch.h0 * y[2] + touch.h1 * y[3], force * b1
    return Push((driver + force * b0) / law.rho, follower + moment, force, moment, slip, yielding)


@inner_jit
def touching(law, pairs, mode, y):
    """The touch of the pair in contact."""
    pair = pairs[mode.pair]
    return touch_at(pair, place(pair, law.centre, y, mode.nose, mode.track))


@inner_jit(merged=True)
def push_at(law, pairs, mode, y):
    """Accelerations and force in a state."""
    if mode.pair < 0:
        return free(law, mode, y)
    pair = pairs[mode.pair]
    at = place(pair, law.centre, y, mode.nose, mode.track)
    return pushed(law, mode, contact_at(pair, at), y)


@inner_jit
def losses(law, mode, push, y, out):
    """Write the powers that are lost, in the order of a state."""
    driver, follower, force = mode.driver_sense * y[2], mode.follower_sense * y[3], push.force
    out[0] = law.mu_plus * force * mode.sigma * push.slip
    out[1] = (law.bearing + force * law.driver_journal) * driver
    out[2] = force * law.follower_journal * follower
    out[3] = (law.driver_drag * driver + law.driver_viscous) * driver * driver
    out[4] = (law.follower_drag * follower + law.follower_viscous) * follower * follower
    out[5] = law.load * follower


@inner_jit
def energy(law, y):
    """Kinetic energy of both bodies, and energy in the follower's spring and weight."""
    turn = y[1] - law.rest
    stored = 0.5 * law.spring * turn * turn + 2.0 * law.weight * np.sin(0.5 * turn) ** 2
    return 0.5 * (law.rho * y[2] * y[2] + y[3] * y[3]), stored
