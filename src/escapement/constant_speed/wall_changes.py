"""Where the pin of a drive at constant speed changes walls, compiled.

The scene is in the units of `cycle_figures`. The pin changes walls where the moment of the contact
on the follower, F = k + load + nu_f g, changes its sign.
"""

import numpy as np

from escapement.dynamics.law import dragged_slope, resistance
from escapement.dynamics.load import load_at, whole_load
from escapement.mechanisms.slotted import pose_at, transmission_on
from escapement.numerics.gauss import POINTS, N
from escapement.numerics.jit import inner_jit
from escapement.numerics.roots import newton_in_bracket

_PANELS = 4  # between two edges, in which F is sampled at Gauss points
_MOST = 4096
_HALVINGS = 60  # of a bracket, or steps of Newton's method, at most
_DEAD_CENTRE = 1e-15  # an angle this close to zero is zero [rad]
_STEP = 1e-6  # of difference quotients by the angle [rad]
_FOUND = 1e-15  # rad, how exactly an angle is known
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
def _carried(theta, g, dg, scene):
    """F at a driver angle with its g and g', and 0 where it is rounding."""
    load = load_at(theta, 1.0, scene)
    moment = resistance(g, dragged_slope(g, dg, scene), 1.0, 1.0, scene, load)
    slack = _CONSTANT * abs(g) + _ROUNDING * abs(whole_load(load, scene))
    return moment if abs(moment) > slack else 0.0


@inner_jit
def _carried_at(theta, scene):
    """As `_carried`, at a driver angle alone."""
    g, _u, dg, _radius = pose_at(scene.path, theta)
    return _carried(theta, g, dg, scene)


@inner_jit
def _dips(before, value, after):
    """Whether a square could have its zero nearest to the middle one of three samples."""
    return value <= min(before, after) and 2.0 * value < max(before, after)


@inner_jit(allocates=True)
def reversals_between(edges, scene):
    """Driver angles inside (edges[0], edges[-1]) at which F changes its sign, ascending.

    Two that are closer to each other than the samples are found where F is least between them.
    """
    found, (g, u, dg, radius) = np.empty(_MOST), np.empty((4, N))
    used, count = 0, _PANELS * N + 1
    older, before, oldest, value = edges[0], edges[0], 0.0, _carried_at(edges[0], scene)
    for j in range(edges.size - 1):
        half = 0.5 * (edges[j + 1] - edges[j]) / _PANELS
        for i in range(count):
            left = edges[j] + 2.0 * half * (i // N)
            if i == count - 1:
                theta = edges[j + 1]
                here = _carried_at(theta, scene)
            else:
                if i % N == 0:
                    transmission_on(scene.path, left, half, POINTS, g.size, g, u, dg, radius)
                theta = left + half * (1.0 + POINTS[i % N])
                here = _carried(theta, g[i % N], dg[i % N], scene)
            if here == 0.0 or used + 2 > _MOST:
                continue
            if here * value < 0.0:
                found[used] = _sign_change(before, theta, value > 0.0, scene)
                used += 1
            # three samples of one sign, the middle one the least as beside a double zero
            elif here * oldest > 0.0 and _dips(abs(oldest), abs(value), abs(here)):
                middle = _least(older, theta, np.copysign(1.0, here), scene)
                if _carried_at(middle, scene) * here < 0.0:
                    found[used] = _sign_change(older, middle, here > 0.0, scene)
                    found[used + 1] = _sign_change(middle, theta, here < 0.0, scene)
                    used += 2
                    value = 0.0  # so that the next three samples do not find them again
            older, oldest, before, value = before, value, theta, here
    return found[:used]


@inner_jit
def _sign_change(low, high, falling, scene):
    """Angle between two at which F changes its sign, by Newton's method to rounding."""
    theta = 0.5 * (low + high)
    for _ in range(_HALVINGS):
        behind = follower_moment(theta + _STEP, scene)
        slope = (behind - follower_moment(theta - _STEP, scene)) / (2.0 * _STEP)
        value, at = follower_moment(theta, scene), theta
        theta, low, high = newton_in_bracket(at, value, slope, low, high, not falling)
        if abs(theta - at) <= _FOUND:
            break
    return theta if abs(theta) > _DEAD_CENTRE else 0.0


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


@inner_jit(allocates=True)
def united(one, other):
    """The values of two ascending rows as one ascending row, each value once."""
    # `np.union1d` and `np.sort` take longer to compile
    found, used, i, j = np.empty(one.size + other.size), 0, 0, 0
    while i < one.size or j < other.size:
        if j == other.size or (i < one.size and one[i] <= other[j]):
            value, i = one[i], i + 1
        else:
            value, j = other[j], j + 1
        if used == 0 or value > found[used - 1]:
            found[used], used = value, used + 1
    return found[:used]
