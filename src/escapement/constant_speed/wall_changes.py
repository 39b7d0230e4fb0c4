"""Where the pin of a drive at constant speed changes walls, compiled.

The scene is in the units of `cycle_figures`. The pin changes walls where the moment of the contact
on the follower, F = k + load + nu_f g, changes its sign.
"""

import numpy as np

from escapement.dynamics.law import dragged_slope, resistance
from escapement.dynamics.load import load_at, whole_load
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.gauss import POINTS, N
from escapement.numerics.jit import inner_jit

_PANELS = 4  # between two edges, in which F is sampled at Gauss points
_MOST = 4096
_HALVINGS = 60  # of a bracket, until an angle is known to rounding
_DEAD_CENTRE = 1e-15  # an angle this close to zero is zero [rad]
_STEP = 1e-6  # of the difference quotient that finds where F is least [rad]
# Shares of |g| and of the load below which a moment is rounding, as in a table of constant ratio.
_CONSTANT = 1e-12
_ROUNDING = 64.0 * float(np.finfo(float).eps)


@inner_jit
def follower_moment(theta, scene):
    """F: moment of the contact on the follower at constant speed."""
    g, _u, dg, _radius = pose_at(scene.path, theta)
    load = load_at(theta, 1.0, scene)
    return resistance(g, dragged_slope(g, dg, scene), 1.0, 1.0, scene, load)


@inner_jit
def _carried(theta, scene):
    """F, and 0 where it is rounding."""
    g, _u, dg, _radius = pose_at(scene.path, theta)
    load = load_at(theta, 1.0, scene)
    moment = resistance(g, dragged_slope(g, dg, scene), 1.0, 1.0, scene, load)
    slack = _CONSTANT * abs(g) + _ROUNDING * abs(whole_load(load, scene))
    return moment if abs(moment) > slack else 0.0


@inner_jit(allocates=True)
def reversals_between(edges, scene):
    """Driver angles inside (edges[0], edges[-1]) at which F changes its sign, ascending.

    Two that are closer to each other than the samples are found where F is least between them.
    """
    found = np.empty(_MOST)
    used, count = 0, _PANELS * N + 1
    older, before, oldest, value = edges[0], edges[0], 0.0, _carried(edges[0], scene)
    for j in range(edges.size - 1):
        left, width = edges[j], (edges[j + 1] - edges[j]) / _PANELS
        for i in range(count):
            x = POINTS[i % N] if i < count - 1 else -1.0
            theta = left + width * (i // N + 0.5 * (x + 1.0))
            here = _carried(theta, scene)
            if here == 0.0 or used + 2 > _MOST:
                continue
            if here * value < 0.0:
                found[used] = _sign_change(before, theta, value > 0.0, scene)
                used += 1
            # three samples of one sign, of which the middle one is so small that F may cross 0
            elif here * oldest > 0.0 and 2.0 * abs(value) < max(abs(here), abs(oldest)):
                middle = _least(older, theta, np.copysign(1.0, here), scene)
                if _carried(middle, scene) * here < 0.0:
                    found[used] = _sign_change(older, middle, here > 0.0, scene)
                    found[used + 1] = _sign_change(middle, theta, here < 0.0, scene)
                    used += 2
                    value = 0.0  # so that the next three samples do not find them again
            older, oldest, before, value = before, value, theta, here
    return found[:used]


@inner_jit
def _sign_change(low, high, falling, scene):
    """Angle between two at which F changes its sign, by bisection to rounding."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if (follower_moment(middle, scene) > 0.0) == falling:
            low = middle
        else:
            high = middle
    middle = 0.5 * (low + high)
    return middle if abs(middle) > _DEAD_CENTRE else 0.0


@inner_jit
def _least(low, high, sign, scene):
    """Angle between two at which sign F is least, by bisection of its slope."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        behind = follower_moment(middle + _STEP, scene)
        if sign * (behind - follower_moment(middle - _STEP, scene)) < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
