"""An impact: the impulse between pin and wall, with Coulomb friction.

A unit of normal impulse changes the speeds of driver and follower as a force would, which acts
alone for a short time: `slot.pushes` are the torques, and `dynamics.free_bodies.move` gives what
they effect.
The friction f along the wall is mu times the sense of sliding, or the smaller value that keeps a
contact sticking. The changes are constant until the sliding speed U, or the speed of a body,
reaches zero; friction then holds it at zero if it is large enough.
Compression ends where the speed of approach is zero, restitution where the impulse is (1 + e) times
that of compression (Poisson).

Source: the equations of impulsive motion with dry friction in two dimensions, as in W. J.
Stronge, Impact Mechanics (2000), chapter 3.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from escapement.dynamics.free_bodies import driver_of, follower_of, move
from escapement.engines.contact.slot import (
    Pose,
    frame_of,
    journal_share,
    pose_across,
    pushes,
    slide_factors,
)
from escapement.numerics.jit import inner_jit
from escapement.numerics.roots import newton_in_bracket

CHATTER = 1e-5
"""A rebound slower than this, in crank radii over sqrt(I_f/torque), is neglected."""
_ROUNDING = 1e-15
"""A body whose momentum is a smaller share of the impulse is at rest."""
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


class _Touch(NamedTuple):
    """The pin at the wall s = `side`.

    at : its pose in the slot. by_driver, by_follower : U = by_driver theta_dot + by_follower
        phi_dot.
    """

    at: Pose
    side: float
    by_driver: float
    by_follower: float


@inner_jit
def _thrust(body, speed, push, journal):
    """Change of a body's speed per unit of normal impulse, and the inertia that resists it."""
    at_rest = speed == 0.0
    moved = move(body, 0.0, np.sign(push if at_rest else speed), 0.0, push, journal)
    # its journal can hold a body at rest
    return 0.0 if at_rest and abs(push) <= journal else moved.rate, moved.inertia


@inner_jit
def _rates(scene, touch, f, speed, turning):
    """`_thrust` of driver and follower with the friction f."""
    on_driver, on_follower = pushes(touch.at, touch.side, f, scene)
    share = journal_share(f, scene)
    return (
        _thrust(driver_of(scene), speed, on_driver, share * scene.driver_journal),
        _thrust(follower_of(scene), turning, on_follower, share * scene.follower_journal),
    )


@inner_jit
def _sticking(scene, touch, speed, turning):
    """The friction f that keeps the sliding speed at zero, and whether mu is large enough."""
    low, high, f = -scene.mu_plus, scene.mu_plus, 0.0
    for end in (low, high):
        (a, _heavy), (b, _light) = _rates(scene, touch, end, speed, turning)
        if (touch.by_driver * a + touch.by_follower * b) * end >= 0.0:
            return end, False
    for _ in range(80):
        (a, driver), (b, follower) = _rates(scene, touch, f, speed, turning)
        slides = touch.by_driver * a + touch.by_follower * b
        if slides == 0.0:
            break
        # a body that its journal holds does not yield to f
        slope = -(touch.by_driver**2) / driver if a != 0.0 or speed != 0.0 else 0.0
        slope -= touch.by_follower**2 / follower if b != 0.0 or turning != 0.0 else 0.0
        guess, low, high = newton_in_bracket(f, slides, slope, low, high, False)
        step, f = abs(guess - f), guess
        if step <= 1e-15:
            break
    return f, True


@inner_jit
def strike(walls, side, theta, speed, turning):
    """The impact on the wall that the pin reaches at a driver angle with these speeds."""
    scene, restitution = walls.plus, walls.clearance.restitution
    across = side * walls.clearance.half_clearance
    at = pose_across(frame_of(scene), theta, across, 0.0, 0.0)
    by_driver, by_follower = slide_factors(at, side, scene)
    touch = _Touch(at=at, side=side, by_driver=by_driver, by_follower=by_follower)
    # speed at which the gap opens
    opening = side * (at.radius * turning - at.cosine * speed)
    approach, impulse, goal = -opening, 0.0, np.inf
    sliding = by_driver * speed + by_follower * turning
    stuck, f = False, scene.mu_plus * np.sign(sliding)
    # journals and trains take another part of the impulse once a body turns the other way
    turns_driver = scene.driver_journal > 0.0 or scene.barrel_efficiency != 1.0
    turns_follower = scene.follower_journal > 0.0 or scene.load_train_efficiency != 1.0
    for _ in range(_MOST):
        (a, _heavy), (b, _light) = _rates(scene, touch, f, speed, turning)
        opens = side * (at.radius * b - at.cosine * a)
        slides = by_driver * a + by_follower * b
        step, change = np.inf, _Change.FOREVER
        if goal < np.inf:
            step, change = goal - impulse, _Change.ENDS
        elif opens > 0.0:
            # by rounding, the pin may have turned back already
            step, change = max(-opening / opens, 0.0), _Change.ENDS
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
            speed = 0.0 if abs(speed) * scene.rho <= _ROUNDING * impulse else speed
            turning = 0.0 if abs(turning) <= _ROUNDING * impulse else turning
            if goal < np.inf or not rebound > CHATTER:
                return Impact(speed, turning, approach, impulse, rebounds=goal < np.inf, sound=True)
            goal = (1.0 + restitution) * impulse
        speed = 0.0 if change == _Change.DRIVER_RESTS else speed
        turning = 0.0 if change == _Change.FOLLOWER_RESTS else turning
        if change == _Change.STICKS or stuck:
            sliding = 0.0
            f, stuck = _sticking(scene, touch, speed, turning)
    return Impact(speed, turning, approach, impulse, rebounds=False, sound=False)
