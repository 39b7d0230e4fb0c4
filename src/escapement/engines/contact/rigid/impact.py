"""An impact: the impulse between pin and wall, with Coulomb friction.

Per unit of normal impulse the follower gains the speed s h, and the driver loses s h p/rho. With
the friction f along the wall, between -mu and mu,

    h = R - f (s delta + r_p) - s b_f sign(phi_dot),     s h p = s g (R - f (..)) + f v + b_d

where f is mu times the sense of sliding, or the smaller value that keeps a contact sticking. Behind
trains that lose power, `_felt` gives the inertias. These rates are constant until the sliding speed
U, or the speed of a body, reaches zero; friction then holds it at zero if it is large enough.
Compression ends where the speed of approach is zero, restitution where the impulse is (1 + e) times
that of compression (Poisson).

Source: the equations of impulsive motion with dry friction in two dimensions, as in W. J.
Stronge, Impact Mechanics (2000), chapter 3.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from escapement.engines.contact.rigid.walls import wall_of
from escapement.mechanisms.path import OFFSET, PIN_RATE
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.jit import inner_jit
from escapement.numerics.roots import newton_in_bracket

CHATTER = 1e-5
"""A rebound slower than this, in crank radii over sqrt(I_f/torque), is neglected."""
_MOST = 40
"""Greatest number of changes in one impact."""


class _Change(IntEnum):
    """What happens next in an impact, at which its rates change.

    FOREVER : nothing: the impact has no end, and no solution. ENDS : compression, or restitution,
    ends. STICKS : the contact stops sliding. DRIVER_RESTS, FOLLOWER_RESTS : a body comes to rest.
    """

    FOREVER = 0
    ENDS = 1
    STICKS = 2
    DRIVER_RESTS = 3
    FOLLOWER_RESTS = 4


class Impact(NamedTuple):
    """Speeds of driver and follower behind an impact, the speed of approach and the normal impulse.

    rebounds : whether the pin leaves the wall again.
    sound : whether the impact has a solution; beyond the Painleve limit there may be none.
    """

    speed: float
    turning: float
    approach: float
    impulse: float
    rebounds: bool
    sound: bool


@inner_jit
def _left(push, journal, speed):
    """A push on a body minus the friction of its journal, which can hold the body at rest."""
    if speed != 0.0:
        return push - journal * np.sign(speed)
    return np.sign(push) * max(abs(push) - journal, 0.0)


@inner_jit
def _felt(inertia, far, efficiency, left, speed):
    """Inertia with which a body resists an impact, if the part `far` of it is behind a train.

    The part behind the train counts 1/eta times where the body speeds up, and eta times where it
    slows down.
    """
    if efficiency == 1.0:
        return inertia
    return inertia + (1.0 / efficiency if left * speed >= 0.0 else efficiency) * far - far


@inner_jit
def _pushes(scene, side, g, radius, slide, f, speed, turning):
    """Impulses on driver and follower per unit of normal impulse, and their inertias."""
    # a contact that sticks loads the bearings with less than the friction of sliding
    share = np.sqrt((1.0 + f * f) / (1.0 + scene.mu_plus**2))
    lever = radius - f * (scene.pin + side * scene.path.numbers[OFFSET])
    on_driver = _left(-side * g * lever - f * slide, share * scene.driver_journal, speed)
    on_follower = _left(side * lever, share * scene.follower_journal, turning)
    driver = _felt(scene.rho, scene.barrel, scene.barrel_efficiency, on_driver, speed)
    train = scene.load_train, scene.load_train_efficiency
    return on_driver, on_follower, driver, _felt(1.0, *train, on_follower, turning)


@inner_jit
def _rates(scene, side, g, radius, slide, f, speed, turning):
    """Changes of the speeds of driver and follower per unit of normal impulse."""
    a, b, driver, follower = _pushes(scene, side, g, radius, slide, f, speed, turning)
    return a / driver, b / follower


@inner_jit
def _sticking(scene, side, g, radius, slide, by_speed, by_turning, speed, turning):
    """The friction f that keeps the sliding speed at zero, and whether mu is large enough."""
    low, high, f = -scene.mu_plus, scene.mu_plus, 0.0
    for end in (low, high):
        a, b = _rates(scene, side, g, radius, slide, end, speed, turning)
        if (by_speed * a + by_turning * b) * end >= 0.0:
            return end, False
    for _ in range(80):
        a, b, driver, follower = _pushes(scene, side, g, radius, slide, f, speed, turning)
        slides = by_speed * a / driver + by_turning * b / follower
        if slides == 0.0:
            break
        # a body that its journal holds does not yield to f
        slope = -by_speed * by_speed / driver if a != 0.0 or speed != 0.0 else 0.0
        slope -= by_turning * by_turning / follower if b != 0.0 or turning != 0.0 else 0.0
        guess, low, high = newton_in_bracket(f, slides, slope, low, high, False)
        step, f = abs(guess - f), guess
        if step <= 1e-15:
            break
    return f, True


@inner_jit
def strike(walls, side, theta, speed, turning):
    """The impact on the wall that the pin reaches at a driver angle with these speeds."""
    scene, restitution = wall_of(walls, side), walls.clearance.restitution
    g, u, _dg, radius = pose_at(scene.path, theta)
    numbers, mu = scene.path.numbers, scene.mu_plus
    beta, offset = numbers[PIN_RATE], numbers[OFFSET]
    slide = radius * u + side * scene.pin * (g - beta)
    # U = by_speed theta_dot + by_turning phi_dot
    by_speed = radius * u - g * offset - side * scene.pin * beta
    by_turning = offset + side * scene.pin
    # speed at which the gap opens
    opening = side * radius * (turning - g * speed)
    approach, impulse, goal = -opening, 0.0, np.inf
    sliding = by_speed * speed + by_turning * turning
    stuck, f = False, mu * np.sign(sliding)
    # journals and trains take another part of the impulse once a body turns the other way
    turns_driver = scene.driver_journal > 0.0 or scene.barrel_efficiency != 1.0
    turns_follower = scene.follower_journal > 0.0 or scene.load_train_efficiency != 1.0
    for _ in range(_MOST):
        a, b = _rates(scene, side, g, radius, slide, f, speed, turning)
        opens, slides = side * radius * (b - g * a), by_speed * a + by_turning * b
        step, change = np.inf, _Change.FOREVER
        if goal < np.inf:
            step, change = goal - impulse, _Change.ENDS
        elif opens > 0.0:
            step, change = -opening / opens, _Change.ENDS
        if not stuck and sliding * slides < 0.0 and -sliding / slides < step:
            step, change = -sliding / slides, _Change.STICKS
        if turns_driver and speed * a < 0.0 and -speed / a < step:
            step, change = -speed / a, _Change.DRIVER_RESTS
        if turns_follower and turning * b < 0.0 and -turning / b < step:
            step, change = -turning / b, _Change.FOLLOWER_RESTS
        if change == _Change.FOREVER:
            return Impact(speed, turning, approach, impulse, rebounds=False, sound=False)
        speed, turning, impulse = speed + a * step, turning + b * step, impulse + step
        opening, sliding = opening + opens * step, sliding + slides * step
        if change == _Change.ENDS:
            rebound = restitution * opens * impulse
            if goal < np.inf or not rebound > CHATTER:
                return Impact(speed, turning, approach, impulse, rebounds=goal < np.inf, sound=True)
            goal = (1.0 + restitution) * impulse
        speed = 0.0 if change == _Change.DRIVER_RESTS else speed
        turning = 0.0 if change == _Change.FOLLOWER_RESTS else turning
        if change == _Change.STICKS or stuck:
            sliding = 0.0
            f, stuck = _sticking(
                scene, side, g, radius, slide, by_speed, by_turning, speed, turning
            )
    return Impact(speed, turning, approach, impulse, rebounds=False, sound=False)
