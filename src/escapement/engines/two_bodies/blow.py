"""A blow: the impulse between nose and track, with Coulomb friction and Poisson's restitution.

A unit of normal impulse changes the speeds by I^-1 (G - f H - sense journal), where the friction
ratio f is mu with the sign of the slip, or the smaller value that keeps the contact sticking. The
changes are constant until the slip, or the speed of a body whose journal has friction, is zero.

Source: as of `engines.contact.rigid.impact`.
"""

from typing import NamedTuple

import numpy as np

from escapement.numerics.jit import inner_jit

SOFTEST = 1e-7
"""A blow slower than this, in units of length over time, has no rebound."""
_MOST = 40


class Blow(NamedTuple):
    """Speeds behind a blow, its speed of approach and normal impulse, and whether it has an end."""

    driver: float
    follower: float
    approach: float
    impulse: float
    sound: bool


@inner_jit
def _yields(speed, push, journal, inertia):
    """What a body yields to a unit of impulse, and the sense of the friction in its journal."""
    if journal == 0.0:
        return 1.0 / inertia, 0.0
    if speed == 0.0:
        return (0.0, 0.0) if abs(push) <= journal else (1.0 / inertia, np.sign(push))
    return 1.0 / inertia, np.sign(speed)


@inner_jit
def strike(law, touch, driver, follower, restitution):
    """The blow at a touch of bodies with these speeds."""
    gap = touch.g0 * driver + touch.g1 * follower
    slip = touch.h0 * driver + touch.h1 * follower
    approach, impulse, goal = -gap, 0.0, np.inf
    if approach < SOFTEST:
        restitution = 0.0
    f = law.mu * np.sign(slip)
    for _ in range(_MOST):
        light0, sense0 = _yields(driver, touch.g0 - f * touch.h0, law.driver_journal, law.rho)
        light1, sense1 = _yields(follower, touch.g1 - f * touch.h1, law.follower_journal, 1.0)
        b0, b1 = touch.g0 - sense0 * law.driver_journal, touch.g1 - sense1 * law.follower_journal
        if slip == 0.0:
            stiff = light0 * touch.h0 * touch.h0 + light1 * touch.h1 * touch.h1
            holding = (light0 * touch.h0 * b0 + light1 * touch.h1 * b1) / max(stiff, 1e-300)
            f = min(max(holding, -law.mu), law.mu)
        a0, a1 = light0 * (b0 - f * touch.h0), light1 * (b1 - f * touch.h1)
        opens, slides = touch.g0 * a0 + touch.g1 * a1, touch.h0 * a0 + touch.h1 * a1
        step, change = np.inf, 0
        if goal < np.inf:
            step, change = goal - impulse, 1
        elif opens > 0.0:
            step, change = max(-gap / opens, 0.0), 1
        if slip * slides < 0.0 and -slip / slides < step:
            step, change = -slip / slides, 2
        if sense0 * driver > 0.0 and driver * a0 < 0.0 and -driver / a0 < step:
            step, change = -driver / a0, 3
        if sense1 * follower > 0.0 and follower * a1 < 0.0 and -follower / a1 < step:
            step, change = -follower / a1, 4
        if change == 0:
            break
        impulse += step
        gap, slip = gap + opens * step, 0.0 if change == 2 or slip == 0.0 else slip + slides * step
        driver = 0.0 if change == 3 else driver + a0 * step
        follower = 0.0 if change == 4 else follower + a1 * step
        if change == 1:
            if goal < np.inf or restitution == 0.0:
                return Blow(driver, follower, approach, impulse, True)
            goal = (1.0 + restitution) * impulse
        if change == 2:
            f = 0.0
    return Blow(driver, follower, approach, impulse, False)
