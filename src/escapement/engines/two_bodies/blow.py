"""A blow: the impulse between nose and track, with Coulomb friction and Poisson's restitution.

A unit of normal impulse changes the speeds by I^-1 (G - f H - sense journal), where the friction
ratio f is mu with the sign of the slip, or the smaller value that keeps the contact sticking. The
changes are constant until the slip, or the speed of a body whose journal has friction, is zero.

Source: as of `engines.contact.rigid.impact`.
"""

import numpy as np

from escapement.numerics.jit import inner_jit, jit

SOFTEST = 1e-7
"""A blow slower than this, in units of length over time, has no rebound."""
_MOST = 40


@inner_jit
def _yields(speed, push, journal, inertia):
    """What a body yields to a unit of impulse, and what the friction of its journal takes of it."""
    if speed == 0.0 and abs(push) <= journal:
        return 0.0, 0.0
    return 1.0 / inertia, journal * np.sign(push if speed == 0.0 else speed)


@jit
def strike(law, touch, y, restitution):
    """The blow at a touch, which changes the speeds; returns its impulse, NaN if it has no end."""
    driver, follower, f = y[2], y[3], 0.0
    gap = touch.g0 * driver + touch.g1 * follower
    slip = touch.h0 * driver + touch.h1 * follower
    impulse, goal = 0.0, np.inf
    rebound = restitution if -gap >= SOFTEST else 0.0
    for _ in range(_MOST):
        f = law.mu_plus * np.sign(slip) if slip != 0.0 else f
        light0, j0 = _yields(driver, touch.g0 - f * touch.h0, law.driver_journal, law.rho)
        light1, j1 = _yields(follower, touch.g1 - f * touch.h1, law.follower_journal, 1.0)
        if slip == 0.0:
            stiff = light0 * touch.h0 * touch.h0 + light1 * touch.h1 * touch.h1
            f = light0 * touch.h0 * (touch.g0 - j0) + light1 * touch.h1 * (touch.g1 - j1)
            f = min(max(f / max(stiff, 1e-300), -law.mu_plus), law.mu_plus)
        a0 = light0 * (touch.g0 - j0 - f * touch.h0)
        a1 = light1 * (touch.g1 - j1 - f * touch.h1)
        opens, slides = touch.g0 * a0 + touch.g1 * a1, touch.h0 * a0 + touch.h1 * a1
        step, change = goal - impulse, 1
        if goal == np.inf and opens > 0.0:
            step = max(-gap / opens, 0.0)
        if slip * slides < 0.0 and -slip / slides < step:
            step, change = -slip / slides, 2
        if j0 * driver > 0.0 and driver * a0 < 0.0 and -driver / a0 < step:
            step, change = -driver / a0, 3
        if j1 * follower > 0.0 and follower * a1 < 0.0 and -follower / a1 < step:
            step, change = -follower / a1, 4
        if step == np.inf:
            break
        impulse, gap = impulse + step, gap + opens * step
        slip = 0.0 if change == 2 or slip == 0.0 else slip + slides * step
        driver = 0.0 if change == 3 else driver + a0 * step
        follower = 0.0 if change == 4 else follower + a1 * step
        if change == 1 and (goal < np.inf or rebound == 0.0):
            y[2], y[3] = driver, follower
            return impulse
        goal = (1.0 + rebound) * impulse if change == 1 else goal
    return np.nan
