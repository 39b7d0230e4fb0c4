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
lie at an end of the part or where their slope is zero.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.constant_speed.wall_changes import follower_moment, reversals_between, united
from escapement.dynamics.law import (
    dragged_slope,
    friction_ratio,
    grip,
    resistance,
    scene_of,
    slide_at,
)
from escapement.dynamics.load import load_at
from escapement.mechanisms.slotted import pose_at, transmission_on
from escapement.numerics.gauss import POINTS, N, integral, tail_of
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.roots import newton_in_bracket

TORQUE, MOMENT, FORCE, RATIO, BEND, RUBBING = range(6)
"""Indices of what `contact_at` returns."""
# What is searched for its greatest value, and the sign with which that is done, 0 for magnitudes.
_SEARCHED = (TORQUE, TORQUE, MOMENT, FORCE, RATIO, BEND, BEND, RUBBING)
_SIGNS = (1.0, -1.0, 0.0, 1.0, 0.0, 1.0, -1.0, 1.0)
_PENDING = 64  # parts that wait to be integrated
# Extremes that wait to be found, and the numbers of each.
_WAITING, _ROW = 256, 8
# A part is halved until the tail of the squared torque is below this share of its greatest value,
# or is rounding of the torque. Its rounding is this share of its summands, which cancel at a zero.
_RESOLVED, _ROUNDING = 1e-13, 32.0 * float(np.finfo(float).eps)
_NARROWEST = 1e-7  # rad
_CANCELS = 1e-14
# Step of the difference quotients by which an extremum is found, and a step of Newton's method
# after which the next one would be rounding [rad].
_STEP, _FOUND = 1e-5, 1e-7


class CycleFigures(NamedTuple):
    """Figures over one engagement, in the scene's units; angles from dead centre [rad].

    With a load that repeats in a turn of the follower they are those of all its engagements, and
    angles count from the first dead centre; integrals are then means over them.

    torque_max, torque_min, moment_max, force_max : greatest and least torque of the drive,
        greatest magnitudes of the moment on the follower and of the contact force, each with the
        angle that has it.
    ratio_max, bend_max : greatest magnitudes of g and g'.
    rubbing_max : greatest product of the contact force and the sliding speed.
    bend_min, bend_exit : least g', and g' at the exit.
    reversals, last_side : number of reversals, and the wall that carries the force at the exit.
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
    rubbing_max: float
    bend_min: float
    bend_exit: float
    reversals: float
    last_side: float
    torque_integral: float
    square_integral: float
    first_half: float


def _places(*names: str) -> NDArray[np.int64]:
    """Indices of figures by their names."""
    return np.array([CycleFigures._fields.index(name) for name in names])


_TOPS, _SIGNS_OF_TOPS = (
    _places("torque_max", "torque_min", "moment_max", "force_max"),
    (1, -1, 1, 1),
)
_GREATEST = _places("ratio_max", "bend_max", "rubbing_max")
_LEAST = _places("bend_min", "bend_exit", "last_side")
_MEANS, _COUNT = (
    _places("torque_integral", "square_integral", "first_half"),
    _places("reversals")[0],
)


@inner_jit
def contact_at(theta, side, slide_sign, scene, efficiency):
    """Torque of the drive, moment on the follower, contact force on the wall `side`, g, g', and the
    product of the force and the sliding speed.

    With the given side and sign of sliding they continue smoothly beyond a kink.
    """
    return _contact(pose_at(scene.path, theta), theta, side, slide_sign, scene, efficiency)


@inner_jit
def _contact(pose, theta, side, slide_sign, scene, efficiency):
    """As `contact_at`, with g, u, g' and R at the angle."""
    g, u, dg, radius = pose
    load = load_at(theta, 1.0, scene)
    moment = resistance(g, dragged_slope(g, dg, scene), 1.0, 1.0, scene, load)
    slide, lever = grip(g, u, radius, side, scene, slide_sign)
    ratio = g + friction_ratio(g, u, radius, side, scene, slide_sign)
    torque = ratio * moment + scene.driver_drag + scene.driver_viscous + scene.bearing
    torque = torque / efficiency if torque >= 0.0 else torque * efficiency
    force = side * moment / lever
    return torque, moment, force, g, dg, force * slide


@inner_jit
def sliding_sign(theta, side, scene):
    """Sign of the sliding speed on a wall."""
    g, u, _dg, radius = pose_at(scene.path, theta)
    return np.copysign(1.0, slide_at(g, u, radius, side, scene))


@inner_jit
def _extreme(theta, low, high, which, sign, side, slide_sign, scene, efficiency):
    """Angle between two where sign times a quantity is greatest, by Newton's method."""
    for _ in range(60):
        behind = sign * contact_at(theta + _STEP, side, slide_sign, scene, efficiency)[which]
        here = sign * contact_at(theta, side, slide_sign, scene, efficiency)[which]
        before = sign * contact_at(theta - _STEP, side, slide_sign, scene, efficiency)[which]
        slope = (behind - before) / (2.0 * _STEP)
        bend = (behind - 2.0 * here + before) / (_STEP * _STEP)
        guess, low, high = newton_in_bracket(theta, slope, bend, low, high, False)
        step = abs(guess - theta)
        theta = guess
        if step <= _FOUND:
            break
    return theta


@jit(allocates=True)
def cycle_figures(packed, edges, half, efficiency):
    """Figures of an engagement, and the driver angles of its reversals.

    Parameters
    ----------
    packed : as `model.scene.packed` makes it, in the units above.
    edges : driver angles between which the quantities are smooth but for reversals, ascending.
    half : driver angle at which the first half of the engagement ends, between the edges.
    efficiency : of the drive, in (0, 1].

    Returns
    -------
    CycleFigures, ndarray
    """
    return figures_of(scene_of(packed), edges, half, efficiency)


@inner_jit(allocates=True)
def figures_of(scene, edges, half, efficiency):
    """As `cycle_figures`, of a scene."""
    reversals = reversals_between(edges, scene)
    cuts = united(united(edges, reversals), np.full(1, half))
    samples, square, pose = np.empty((N + 2, RUBBING + 1)), np.empty(N), np.empty((4, N))
    tops, angles = np.full(len(_SIGNS), -np.inf), np.full(len(_SIGNS), np.nan)
    waiting, used = np.empty((_WAITING, _ROW)), 0
    whole = squares = first = sizes = last_side = 0.0
    pending = np.empty((_PENDING, 2))
    for j in range(cuts.size - 1):
        middle = 0.5 * (cuts[j] + cuts[j + 1])
        side = 1.0 if follower_moment(middle, scene) >= 0.0 else -1.0
        slide = sliding_sign(middle, side, scene)
        pending[0, 0], pending[0, 1] = cuts[j], cuts[j + 1]
        count, last_side = 1, side
        while count > 0:
            count -= 1
            left, right = pending[count, 0], pending[count, 1]
            width = 0.5 * (right - left)
            _fill(samples, pose, left, right, side, slide, scene, efficiency)
            torque, size, summands = samples[1:-1, TORQUE], 1e-300, 0.0
            for i in range(N):
                square[i], here = torque[i] * torque[i], samples[i + 1]
                size = max(size, square[i])
                # the moment is that of the load and of the acceleration g'
                most = abs(here[MOMENT]) + 2.0 * abs(here[BEND])
                summands = max(summands, abs(here[RATIO]) * most)
            least = _RESOLVED * size + _ROUNDING * summands * np.sqrt(size)
            rough = tail_of(square, N) > least
            if rough and width > _NARROWEST and count < _PENDING - 2:
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
            if used + len(_SIGNS) > _WAITING:
                _search(tops, angles, waiting, used, scene, efficiency)
                used = 0
            used = _raise_tops(tops, angles, samples, left, right, side, slide, waiting, used)
    _search(tops, angles, waiting, used, scene, efficiency)
    # where driving and driven work cancel, what is left is rounding
    whole = 0.0 if abs(whole) <= _CANCELS * sizes else whole
    _g, _u, bend_exit, _radius = pose_at(scene.path, edges[-1])
    found = CycleFigures(
        torque_max=tops[0], torque_max_angle=angles[0], torque_min=-tops[1],
        torque_min_angle=angles[1], moment_max=tops[2], moment_max_angle=angles[2],
        force_max=tops[3], force_max_angle=angles[3], ratio_max=tops[4],
        bend_max=max(tops[5], tops[6]), rubbing_max=tops[7], bend_min=-tops[6], bend_exit=bend_exit,
        reversals=float(reversals.size), last_side=last_side,
        torque_integral=whole, square_integral=squares, first_half=first,
    )  # fmt: skip
    return found, reversals


@jit(allocates=True)
def join_steps(steps, cell):
    """The figures of all engagements of a turn, from a row for each; `cell` is a driver angle."""
    found = steps[0].copy()
    for k in range(1, len(steps)):
        step = steps[k]
        for j in range(_TOPS.size):
            # the angle stands behind the value
            i, sign = _TOPS[j], _SIGNS_OF_TOPS[j]
            if sign * step[i] > sign * found[i]:
                found[i], found[i + 1] = step[i], step[i + 1] + k * cell
        for i in _GREATEST:
            found[i] = max(found[i], step[i])
        for i in _LEAST:
            found[i] = min(found[i], step[i])
        for i in _MEANS:
            found[i] += step[i]
        found[_COUNT] += step[_COUNT]
    for i in _MEANS:
        found[i] /= len(steps)
    return found


@inner_jit
def _point(i):
    """Ends and Gauss points of [-1, 1], in order."""
    return -1.0 if i == 0 else 1.0 if i > N else POINTS[i - 1]


@inner_jit
def _fill(samples, pose, left, right, side, slide_sign, scene, efficiency):
    """Fill rows with what `contact_at` returns at the ends and the Gauss points of a part."""
    half, (g, u, dg, radius) = 0.5 * (right - left), pose
    transmission_on(scene.path, left, half, POINTS, g.size, g, u, dg, radius)
    for i in range(N):
        theta, here = left + half * (1.0 + POINTS[i]), (g[i], u[i], dg[i], radius[i])
        found = _contact(here, theta, side, slide_sign, scene, efficiency)
        _fill_row(samples[i + 1], found)
    _fill_row(samples[0], contact_at(left, side, slide_sign, scene, efficiency))
    _fill_row(samples[N + 1], contact_at(right, side, slide_sign, scene, efficiency))


@inner_jit
def _fill_row(row, found):
    """Fill a row with what `contact_at` returns, as far as there is room."""
    for i in range(len(row)):
        row[i] = found[i]


@inner_jit
def _raise_tops(tops, angles, samples, left, right, side, slide_sign, waiting, used):
    """Raise the greatest values to the samples of one part, whose sides do not change.

    Where one may be exceeded beside a sample, a row of `waiting` says what `_search` needs; returns
    how many are used.
    """
    half = 0.5 * (right - left)
    for k in range(tops.size):
        which, sign = _SEARCHED[k], _SIGNS[k]
        if sign == 0.0:
            sign = np.copysign(1.0, samples[N // 2, which])
        best = 0
        for i in range(1, N + 2):
            if sign * samples[i, which] > sign * samples[best, which]:
                best = i
        top, theta = sign * samples[best, which], left + half * (1.0 + _point(best))
        low, high = max(best - 1, 0), min(best + 1, N + 1)
        beside = min(sign * samples[low, which], sign * samples[high, which])
        if top > tops[k]:
            tops[k], angles[k] = top, theta
        # between neighbours a smooth function exceeds the greatest of them by less than it falls
        if top + (top - beside) > tops[k]:
            row = waiting[used]
            row[0], row[1], row[2], row[3] = k, top + (top - beside), sign, theta
            row[4], row[5] = left + half * (1.0 + _point(low)), left + half * (1.0 + _point(high))
            row[6], row[7] = side, slide_sign
            used += 1
    return used


@inner_jit
def _search(tops, angles, waiting, used, scene, efficiency):
    """Raise the greatest values to those between the samples, where these are not greater yet."""
    for i in range(used):
        index, bound, sign, theta, low, high, side, slide_sign = waiting[i]
        k = int(index)
        if bound > tops[k]:
            which = _SEARCHED[k]
            at = _extreme(theta, low, high, which, sign, side, slide_sign, scene, efficiency)
            top = sign * contact_at(at, side, slide_sign, scene, efficiency)[which]
            if top > tops[k]:
                tops[k], angles[k] = top, at


@jit
def contact_states(packed, theta, efficiency, table):
    """Fill rows of `table`, shape (n, 5), at driver angles of the engagement.

    The columns are torque of the drive, moment on the follower, magnitude of the contact force,
    g and g'.
    """
    scene = scene_of(packed)
    for i in range(theta.size):
        side = 1.0 if follower_moment(theta[i], scene) >= 0.0 else -1.0
        slide = sliding_sign(theta[i], side, scene)
        _fill_row(table[i], contact_at(theta[i], side, slide, scene, efficiency))
