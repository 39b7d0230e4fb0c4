"""Figures of a drive at constant speed over one engagement, compiled.

The scene is in units of which the driver's speed is one: I_f, I_f W^2 and 1/W are those of
inertia, torque and time. With theta_dot = 1 and theta_ddot = 0 the equation of motion of
`dynamics.law` gives everything explicitly:

    F = k + load + nu_f g        moment of the contact on the follower
    s = sign F                   wall that carries the force
    N = |F|/h                    contact force, with the lever arm h
    p F + c_d + nu_d + bearing   torque of the drive, before its efficiency

An engagement is cut at the kinks of these quantities: breaks of the path, places where sliding
reverses, and zeros of F. On each part they are integrated over Gauss points, and their extremes
lie at an end of the part or where their difference quotient is zero.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.law import (
    dragged_slope,
    friction_ratio,
    grip,
    resistance,
    scene_of,
    slide_at,
)
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.gauss import POINTS, N, integral, tail_of
from escapement.numerics.jit import inner_jit, jit

TORQUE, MOMENT, FORCE, RATIO, BEND = range(5)
"""Indices of what `contact_at` returns."""
# What is searched for its greatest value, and the sign with which that is done, 0 for magnitudes.
_SEARCHED = (TORQUE, TORQUE, MOMENT, FORCE, RATIO, BEND)
_SIGNS = (1.0, -1.0, 0.0, 1.0, 0.0, 0.0)
_MOST_CUTS = 4096
# A part is halved until the tail of the squared torque is below this share of its greatest value.
_RESOLVED = 1e-13
_NARROWEST = 1e-7  # rad
_CANCELS = 1e-14
# Step of the difference quotient by which an extremum is found [rad].
_STEP = 1e-5


class CycleFigures(NamedTuple):
    """Figures over one engagement, in the scene's units; angles from dead centre [rad].

    torque_max, torque_min, moment_max, force_max : greatest and least torque of the drive,
        greatest magnitudes of the moment on the follower and of the contact force, each with the
        angle that has it.
    ratio_max, bend_max : greatest magnitudes of g and g'.
    torque_integral, square_integral : integrals of the torque and of its square.
    first_half : integral of the torque up to `half`, see `cycle_figures`.
    """

    torque_max: float
    torque_max_angle: float
    torque_min: float
    torque_min_angle: float
    moment_max: float
    moment_max_angle: float
    force_max: float
    force_max_angle: float
    ratio_max: float
    bend_max: float
    torque_integral: float
    square_integral: float
    first_half: float


@inner_jit
def follower_moment(theta, scene):
    """F: moment of the contact on the follower at constant speed."""
    g, _u, dg, _radius = pose_at(scene.path, theta)
    return resistance(g, dragged_slope(g, dg, scene), 1.0, 1.0, scene)


@inner_jit
def contact_at(theta, side, slide_sign, scene, efficiency):
    """Torque of the drive, moment on the follower, contact force on the wall `side`, g and g'.

    With the given side and sign of sliding they continue smoothly beyond a kink.
    """
    g, u, dg, radius = pose_at(scene.path, theta)
    moment = resistance(g, dragged_slope(g, dg, scene), 1.0, 1.0, scene)
    _slide, lever = grip(g, u, radius, side, scene, slide_sign)
    ratio = g + friction_ratio(g, u, radius, side, scene, slide_sign)
    torque = ratio * moment + scene.driver_drag + scene.driver_viscous + scene.bearing
    torque = torque / efficiency if torque >= 0.0 else torque * efficiency
    return torque, moment, side * moment / lever, g, dg


@inner_jit
def sliding_sign(theta, side, scene):
    """Sign of the sliding speed on a wall."""
    g, u, _dg, radius = pose_at(scene.path, theta)
    return np.copysign(1.0, slide_at(g, u, radius, side, scene))


@jit(allocates=True)
def reversals_between(scene_tuple, edges):
    """Driver angles inside (edges[0], edges[-1]) at which F changes its sign, ascending."""
    scene = scene_of(scene_tuple)
    found = np.empty(_MOST_CUTS)
    used = 0
    for j in range(edges.size - 1):
        left, half = edges[j], 0.5 * (edges[j + 1] - edges[j])
        before, value = left, follower_moment(left, scene)
        for i in range(4 * N + 1):
            panel, point = i // N, i % N
            x = POINTS[point] if i < 4 * N else 1.0
            theta = left + half * (0.25 * (x + 1.0 + 2.0 * panel) if i < 4 * N else 2.0)
            here = follower_moment(theta, scene)
            if (here > 0.0) != (value > 0.0) and here != value and used < _MOST_CUTS:
                found[used] = _sign_change(before, theta, value > 0.0, scene)
                used += 1
            before, value = theta, here
    return found[:used]


@inner_jit
def _sign_change(low, high, falling, scene):
    """Angle between two at which F changes its sign, by bisection to rounding."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        if (follower_moment(middle, scene) > 0.0) == falling:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@inner_jit
def _extreme(low, high, which, sign, side, slide_sign, scene, efficiency):
    """Angle between two where sign times a quantity is greatest, by bisection of its slope."""
    for _ in range(50):
        middle = 0.5 * (low + high)
        behind = contact_at(middle + _STEP, side, slide_sign, scene, efficiency)[which]
        before = contact_at(middle - _STEP, side, slide_sign, scene, efficiency)[which]
        if sign * (behind - before) > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@jit(allocates=True)
def cycle_figures(scene_tuple, cuts, half, efficiency):
    """Figures of an engagement.

    Parameters
    ----------
    scene_tuple : as `model.scene.scene_tuple` makes it, in the units above.
    cuts : driver angles between which the quantities are smooth, ascending, reversals included.
    half : driver angle at which the first half of the engagement ends; one of `cuts`.
    efficiency : of the drive, in (0, 1].

    Returns
    -------
    CycleFigures
    """
    scene = scene_of(scene_tuple)
    torque, square = np.empty(N), np.empty(N)
    tops, angles = np.full(len(_SIGNS), -np.inf), np.full(len(_SIGNS), np.nan)
    whole = squares = first = sizes = 0.0
    pending = np.empty((64, 2))
    for j in range(cuts.size - 1):
        middle = 0.5 * (cuts[j] + cuts[j + 1])
        side = 1.0 if follower_moment(middle, scene) >= 0.0 else -1.0
        slide = sliding_sign(middle, side, scene)
        pending[0, 0], pending[0, 1] = cuts[j], cuts[j + 1]
        count = 1
        while count > 0:
            count -= 1
            left, right = pending[count, 0], pending[count, 1]
            width = 0.5 * (right - left)
            for i in range(N):
                theta = left + width * (1.0 + POINTS[i])
                torque[i] = contact_at(theta, side, slide, scene, efficiency)[TORQUE]
                square[i] = torque[i] * torque[i]
            size = max(np.max(square), 1e-300)
            rough = tail_of(square, N) > _RESOLVED * size
            if rough and width > _NARROWEST and count < 62:
                inside = left + width
                pending[count, 0], pending[count, 1] = inside, right
                pending[count + 1, 0], pending[count + 1, 1] = left, inside
                count += 2
                continue
            part = width * integral(torque, N)
            whole += part
            sizes += abs(part)
            squares += width * integral(square, N)
            first += part if right <= half else 0.0
            _raise_tops(tops, angles, left, right, side, slide, scene, efficiency)
    # where driving and driven work cancel, what is left is rounding
    whole = 0.0 if abs(whole) <= _CANCELS * sizes else whole
    return CycleFigures(
        torque_max=tops[0], torque_max_angle=angles[0], torque_min=-tops[1],
        torque_min_angle=angles[1], moment_max=tops[2], moment_max_angle=angles[2],
        force_max=tops[3], force_max_angle=angles[3], ratio_max=tops[4], bend_max=tops[5],
        torque_integral=whole, square_integral=squares, first_half=first,
    )  # fmt: skip


@inner_jit
def _raise_tops(tops, angles, left, right, side, slide_sign, scene, efficiency):
    """Raise the greatest values to those on one part, whose sides do not change."""
    half = 0.5 * (right - left)
    for k in range(tops.size):
        which, sign = _SEARCHED[k], _SIGNS[k]
        if sign == 0.0:
            middle = contact_at(left + half, side, slide_sign, scene, efficiency)[which]
            sign = np.copysign(1.0, middle)
        best, top = 0, -np.inf
        for i in range(N + 2):
            x = -1.0 if i == 0 else 1.0 if i > N else POINTS[i - 1]
            theta = left + half * (1.0 + x)
            value = sign * contact_at(theta, side, slide_sign, scene, efficiency)[which]
            if value > top:
                best, top = i, value
        low = left if best <= 1 else left + half * (1.0 + POINTS[best - 2])
        high = right if best >= N else left + half * (1.0 + POINTS[best])
        at = _extreme(low, high, which, sign, side, slide_sign, scene, efficiency)
        inside = sign * contact_at(at, side, slide_sign, scene, efficiency)[which]
        if inside <= top:  # it is at an end
            at = left if best == 0 else right if best > N else at
        top = max(top, inside)
        if top > tops[k]:
            tops[k], angles[k] = top, at


@jit
def contact_states(scene_tuple, theta, efficiency, table):
    """Fill rows of `table`, shape (n, 5), at driver angles of the engagement.

    The columns are torque of the drive, moment on the follower, magnitude of the contact force,
    g and g'.
    """
    scene = scene_of(scene_tuple)
    for i in range(theta.size):
        side = 1.0 if follower_moment(theta[i], scene) >= 0.0 else -1.0
        slide = sliding_sign(theta[i], side, scene)
        table[i] = contact_at(theta[i], side, slide, scene, efficiency)
