"""The Painleve limit: the friction at which the equation of motion loses its solution.

Sections 7 and 9 of docs/theory.md derive what this file computes. Where the reduced inertia
J_s = rho + g p_s is zero or negative, the equations of rigid bodies have two solutions or none.
This can happen for the side that holds the follower back, s = -1. After dead centre the force
changes to this side, so there is no motion if friction is at its limit or above. Before dead centre
the side s = +1 carries the force, and this motion goes on, but a second one is possible as well.
For an ideal pin the limits before and after dead centre are equal, and known in closed form.
"""

from typing import Any, NamedTuple

import numpy as np

from escapement.dynamics.law import grip, is_ideal, sign_of, slide_at
from escapement.dynamics.power_flow import FLOWS
from escapement.dynamics.train_losses import in_flow, is_lossy, scene_in_flow
from escapement.mechanisms.path import G0, G1, HALF_RATE, L0, L1
from escapement.mechanisms.protocol import Mechanism
from escapement.mechanisms.slotted import (
    circle,
    is_meshed,
    offset_of,
    pose_at,
    slide_change,
    transmission_at,
)
from escapement.model.escapement import Escapement, Inertia, once_per_escapement
from escapement.model.natural import slid
from escapement.model.scene import Scene
from escapement.numerics.jit import as_python, inner_jit, jit
from escapement.numerics.roots import golden_point, golden_step, golden_trial, newton_in_bracket

# Points of each interval of a table, and of all of it, at which a limit is looked for.
_PARTS, _GRID = 32, 1024


@jit
def painleve_ratio(path, theta, rho):
    """Friction of an ideal pin at which the reduced inertia vanishes at `theta`, or inf."""
    g, u, _dg = transmission_at(path, theta)
    product = abs(g * u)
    return (rho + g * g) / product if product > 0.0 else np.inf


@inner_jit
def _stationary(g1, g2, rho, end):
    """g between 0 and `end` at which (rho + g^2)/(|g| |u|) is stationary on the circle.

    On the circle u^2 = (g1 - g)(g - g2), see `slotted`. The result is a root of the cubic in
    `critical_friction`. `end` is g1 or g2. The cubic is negative at 0 and positive at both of them,
    so Newton's method between 0 and `end` always finds the root.
    """
    total, product = g1 + g2, g1 * g2
    low, high = min(0.0, end), max(0.0, end)
    g = 0.5 * end
    for _ in range(200):
        value = ((total * g + 4.0 * rho - 2.0 * product) * g - 3.0 * rho * total) * g
        value += 2.0 * rho * product
        slope = (3.0 * total * g + 8.0 * rho - 4.0 * product) * g - 3.0 * rho * total
        guess, low, high = newton_in_bracket(g, value, slope, low, high, end > 0.0)
        if abs(guess - g) <= 1e-15 * abs(g):
            break
        g = guess
    return g


@jit
def painleve_limit(path, rho, entry, exit_):
    """Least `painleve_ratio` over the engagement, and a driver angle at which it is reached."""
    if path.table:
        return np.inf, entry
    limit, angle = painleve_ratio(path, entry, rho), entry
    at_exit = painleve_ratio(path, exit_, rho)
    if at_exit < limit:
        limit, angle = at_exit, exit_
    c = path.numbers
    g1, g2 = circle(path)
    for end in (g1, g2):
        g = _stationary(g1, g2, rho, end)
        # solve g = (G0 + G1 x)/(L0 + L1 x) for x, the squared sine of the half angle
        x = (g * c[L0] - c[G0]) / (c[G1] - g * c[L1])
        if not 0.0 < x <= 1.0:
            continue
        turn = np.arcsin(np.sqrt(x)) / abs(c[HALF_RATE])
        for theta in (-turn, turn):
            nearest = min(max(theta, entry), exit_)
            # leave out an angle that lies outside the engagement by more than rounding
            if abs(nearest - theta) > 1e-15 * abs(theta):
                continue
            # |u| comes from the circle: with a light driver the minimum lies so close to the
            # exit that no double for the angle gives g to enough digits
            ratio = (rho + g * g) / (abs(g) * np.sqrt((g1 - g) * (g - g2)))
            if ratio < limit:
                limit, angle = ratio, nearest
    return limit, angle


@jit
def margin(theta, scene):
    """J_s h_s for s = -1, which is (rho + g^2) h - |g| h |c|.

    Below the Painleve limit the reduced inertia J_s and the lever h_s are both positive.
    """
    g, u, _dg, radius = pose_at(scene.path, theta)
    slide, lever = grip(g, u, radius, -1.0, scene)
    lost = scene.mu_minus * slide + scene.driver_journal + scene.follower_journal * abs(g)
    return (scene.rho + g * g) * lever - abs(g) * lost


@inner_jit
def nearness(moment, slope, journal):
    """One over the least mu at which moment - slope mu - journal sqrt(1 + mu^2) vanishes.

    These are A, B and C of docs/theory.md, section 9, where the closed form is derived with
    mu = tan x. The result is infinite if the moment does not exceed the friction of the journals,
    and zero or negative if there is no such mu. Its greatest value over an engagement gives the
    least mu.
    """
    b, c = slope / moment, journal / moment
    if not abs(c) < 1.0:
        return np.inf
    return (b + c * np.sqrt(1.0 + b * b - c * c)) / (1.0 - c * c)


@inner_jit
def _nearness_at(theta, slide_sign, scene):
    """`nearness` of the friction at which `margin` vanishes at an angle; `slide_sign` is the sign
    of v."""
    g, u, _dg, radius = pose_at(scene.path, theta)
    # the journals of a scene contain the factor sqrt(1 + mu^2), named `share`, of its own friction
    inertia, ratio, share = scene.rho + g * g, abs(g), np.hypot(1.0, scene.mu_minus)
    driver, follower = scene.driver_journal / share, scene.follower_journal / share
    slide = slide_sign * slide_at(g, u, radius, -1.0, scene)
    slope = ratio * slide + inertia * slide_sign * (scene.pin - offset_of(scene.path))
    journal = ratio * (driver + ratio * follower) - inertia * sign_of(g) * follower
    return nearness(inertia * radius, slope, journal)


@inner_jit
def _nearest(low, high, scene):
    """The greatest `_nearness_at` between two angles, and its angle.

    The sliding speed v must keep its sign between them. `_nearness_at` then has one maximum, inside
    or at an end, which golden section finds.
    """
    g, u, _dg, radius = pose_at(scene.path, 0.5 * (low + high))
    slide_sign = np.copysign(1.0, slide_at(g, u, radius, -1.0, scene))
    best = golden_point(low, high)
    greatest = _nearness_at(best, slide_sign, scene)
    while high - low > 1e-12:
        trial = golden_trial(low, high, best)
        value = _nearness_at(trial, slide_sign, scene)
        low, high, best, greatest = golden_step(low, high, best, greatest, trial, value)
    return greatest, 0.5 * (low + high)


@inner_jit
def _nearest_of_table(scene, sign):
    """As `_nearest`, over all angles at which g' has a sign; and the least distance R."""
    edges, most, angle, least = scene.edges, 0.0, np.nan, np.inf
    for k in range(edges.size - 1):
        low, step = edges[k], (edges[k + 1] - edges[k]) / _PARTS
        slide_sign = np.sign(pose_at(scene.path, low + 0.5 * _PARTS * step)[1])
        greatest, best = 0.0, np.nan
        for i in range(_PARTS + 1):
            theta = low + i * step
            pose = pose_at(scene.path, theta)
            least = min(least, pose[3])
            value = _nearness_at(theta, slide_sign, scene) if pose[2] * sign > 0.0 else 0.0
            if value > greatest:
                greatest, best = value, theta
        if greatest > 0.0:
            found, nearest = _nearest(max(best - step, low), min(best + step, edges[k + 1]), scene)
            if found > most:
                most, angle = found, nearest
    return most, angle, least


@jit
def friction_limit(scene, low, high):
    """Least friction at which `margin` vanishes between two driver angles, and the angle.

    Of a table the angles only tell which angles count: those before the greatest g, where g' is
    positive, or those behind it. If the lever of the side s = +1 vanishes at less friction, the
    result is that friction, and the angle is NaN. Below the result margin and lever are both
    positive. The friction of the scene itself has no influence on it.
    """
    # `margin` is smooth on either side of the angle at which the sliding changes its direction
    entry, exit_ = scene.edges[0], scene.edges[-1]
    if scene.path.table:
        most, angle, radius = _nearest_of_table(scene, -1.0 if low == 0.0 else 1.0)
    else:
        change = slide_change(scene.path, scene.pin, -1.0, entry, exit_)
        if not low < change < high:
            change = high
        most, angle = _nearest(low, change, scene)
        if change < high:
            behind, nearest = _nearest(change, high, scene)
            if behind > most:
                most, angle = behind, nearest
        radius = min(pose_at(scene.path, 0.0)[3], pose_at(scene.path, exit_)[3])
    arm = scene.pin + abs(offset_of(scene.path))
    lever = nearness(radius, arm, scene.follower_journal / np.hypot(1.0, scene.mu_minus))
    if lever > most:
        most, angle = lever, np.nan
    return 1.0 / most if most > 0.0 else np.inf, angle


@jit
def first_beyond(scene, low, high):
    """First driver angle between two at which `margin` is not positive, NaN if there is none.

    Of a table the first of a grid.
    """
    if scene.path.table:
        for i in range(_GRID + 1):
            theta = low + (high - low) * i / _GRID
            if pose_at(scene.path, theta)[2] < 0.0 and not margin(theta, scene) > 0.0:
                return theta
        return np.nan
    change = slide_change(scene.path, scene.pin, -1.0, scene.edges[0], scene.edges[-1])
    middle = change if low < change < high else high
    while low < high:
        if not margin(low, scene) > 0.0:
            return low
        # From `low` to the angle with the least friction limit the margin changes its sign at most
        # once, and bisection finds this first zero.
        left, right = low, _nearest(low, middle, scene)[1]
        if not margin(right, scene) > 0.0:
            while left < 0.5 * (left + right) < right:
                halfway = 0.5 * (left + right)
                if margin(halfway, scene) > 0.0:
                    left = halfway
                else:
                    right = halfway
            return right
        low, middle = middle, high
    return np.nan if margin(high, scene) > 0.0 else high


@inner_jit
def beyond_painleve(scene):
    """Whether friction is at or above the Painleve limit for any direction of power in trains."""
    if not is_lossy(scene):
        return _beyond(scene)
    count = 0
    for i in range(FLOWS):
        count += _beyond(in_flow(scene, float(i)))
    return count > 0


@inner_jit
def _beyond(scene):
    """Whether friction is at or above the Painleve limit of a scene.

    For an ideal pin the limit is the least (rho + g^2)/|g u|. Here (rho + g^2)/|g| is at least
    2 sqrt(rho), and |u| is at most |g1 - g2|/2, the radius of the circle on which (g, u) moves. For
    most scenes this lower bound of the limit is above their friction. For most others the limit
    follows from the stationary g on the circle, without its driver angle. A mechanism without slots
    has no such limit, because J_s = rho + g^2 eta is positive.
    """
    if is_meshed(scene.path):
        return False
    if scene.path.table or not is_ideal(scene):
        return scene.mu_minus >= friction_limit(scene, 0.0, scene.edges[-1])[0]
    # Where g > 0, J may vanish for s = -1. In a part of one of Meyer's published cells g < 0, and J
    # may vanish for s = +1. This needs no test, because both sides have the same mu there, and the
    # limit of that part is higher.
    mu, rho = scene.mu_minus, scene.rho
    g1, g2 = circle(scene.path)
    if mu * abs(g1 - g2) < 4.0 * np.sqrt(rho) * (1.0 - 1e-12):
        return False
    if g2 < 0.0 < g1:
        # g rises from 0 at entry to g1 at dead centre, so the stationary g lies in between
        g = _stationary(g1, g2, rho, g1)
        # the friction over its limit, mu |g u|/(rho + g^2)
        share = mu * g * np.sqrt((g1 - g) * (g - g2)) / (rho + g * g)
        if abs(share - 1.0) > 1e-9:
            return share > 1.0
    return mu >= painleve_limit(scene.path, rho, scene.edges[0], scene.edges[-1])[0]


class FrictionLimit(NamedTuple):
    """The limit of scenes of one path, and the numbers on which it depends.

    rho, pin : as in `Scene`.
    driver_journal, follower_journal : the same without the factor sqrt(1 + mu^2).
    friction : the least friction at which no motion exists.
    """

    rho: float
    pin: float
    driver_journal: float
    follower_journal: float
    friction: float


@inner_jit
def has_limit_of_its_own(scene):
    """Whether the limit of a scene has to be searched for, and once for all flows of power."""
    searched = scene.path.table or not is_ideal(scene)
    return searched and not (is_meshed(scene.path) or is_lossy(scene))


@inner_jit
def friction_limit_after(limit, scene):
    """The limit of a scene: that of another one with the same path, if it is the same."""
    share = np.hypot(1.0, scene.mu_minus)
    driver, follower = scene.driver_journal / share, scene.follower_journal / share
    alike = limit.rho == scene.rho and limit.pin == scene.pin
    # the factor leaves rounding errors
    alike = alike and abs(driver - limit.driver_journal) <= 1e-15 * driver
    if alike and abs(follower - limit.follower_journal) <= 1e-15 * follower:
        return limit
    found = friction_limit(scene, 0.0, scene.edges[-1])[0]
    return FrictionLimit(scene.rho, scene.pin, driver, follower, found)


def critical_friction(mechanism: Mechanism, inertia: Inertia) -> float:
    """Painleve limit: least friction at which no motion exists [-].

    There J_s reaches zero after dead centre. At or above it the rigid-body problem has no
    solution or two. The load torque does not move it. Minimum over the engagement of
    (rho + g^2)/(|g| |u|); on a slotted path u^2 = (g1 - g)(g - g2), so the
    stationary points are roots of the cubic

        S g^3 + (4 rho - 2 P) g^2 - 3 rho S g + 2 rho P = 0,  S = g1 + g2, P = g1 g2,

    which for the external Geneva is T g^3 + (T + 2 rho) g^2 - 3 rho T g - rho T = 0
    with T = tan^2(pi/n). For pins with a radius, and with friction in the journals, the friction
    at which the product of reduced inertia and lever vanishes has a closed form at each driver
    angle, and its minimum is found numerically.

    Returns
    -------
    float
        The limit; infinite where the pin never slides under force.
    """
    return friction_limits(Escapement(mechanism, inertia, torque=1.0))[0]


@once_per_escapement
def friction_limits(escapement: Escapement) -> tuple[float, float]:
    """The least friction at which no motion exists, and that at which it is not unique [-].

    For an ideal pin the two are equal. With a roller both are for the friction between the roller
    and its pin. Bodies that touch with their outlines have infinite ones.
    """
    if escapement.mechanism.pitch is not None:
        return np.inf, np.inf  # the engine finds out on its way
    scenes = _flows_of(escapement)
    if not all(_is_closed(scene) for scene in scenes):
        return _limit(escapement, before=False), _limit(escapement, before=True)
    ends = [(scene.path, scene.rho, scene.edges[0], scene.edges[-1]) for scene in scenes]
    limit = min(painleve_limit(*row)[0] for row in ends)
    return limit, limit


def _flows_of(escapement: Escapement) -> list[Scene]:
    """The scenes of an escapement; if trains lose power, each for all directions of the power."""
    if not as_python(is_lossy)(escapement.scene):
        return [*escapement.scenes]
    return [scene_in_flow(scene, float(i)) for scene in escapement.scenes for i in range(FLOWS)]


def _is_closed(scene: Scene) -> bool:
    """Whether the limit is that of gears, or of an ideal pin, which has a closed form."""
    path = scene.path
    return path.meshed or bool(not path.table and as_python(is_ideal)(scene))


def _limit(escapement: Escapement, before: bool) -> float:
    """Least friction at which the margin vanishes before dead centre, or after it."""
    limits = [
        friction_limit(scene, *((scene.edges[0], 0.0) if before else (0.0, scene.edges[-1])))[0]
        for scene in _flows_of(escapement)
    ]
    return slid(escapement.mechanism.lengths, float(min(limits)))


def painleve_message(escapement: Escapement) -> str | None:
    """Why no motion can be computed, or None below the limit."""
    limit, friction = friction_limits(escapement)[0], escapement.friction
    if friction < limit:
        return None
    scenes, count = _flows_of(escapement), len(escapement.scenes)
    found = [(first_beyond(scene, 0.0, scene.edges[-1]), k) for k, scene in enumerate(scenes)]
    # x == x leaves out NaN; at the limit itself rounding may leave no angle but that of the limit
    nearest = friction_limit(scenes[0], 0.0, scenes[0].edges[-1])[1]
    angle, k = next(((x, k) for x, k in found if x == x), (nearest, 0))
    wheel: Any = escapement.mechanism
    where = f" of pin {k % wheel.pins} in slot {k % wheel.slots}" if count > 1 else ""
    return (
        f"friction {friction:g} is at or above the Painleve limit {limit:.6g}, first met "
        f"{np.degrees(angle):.3f} degrees from dead centre{where}: no unique rigid motion exists"
        f"{_remedy(escapement)}"
    )


def _remedy(escapement: Escapement) -> str:
    """The end of the message: which option gives a result beyond the limit, if one does."""
    if len(escapement.scenes) > 1 or escapement.curve is not None:
        return ""
    if not escapement.mechanism.takes_clearance:
        return "; jam_rule gives an approximation"
    rule = "jam_rule without the clearance" if escapement.contact else "jam_rule"
    return f"; give stiffness and damping for compliant contact, or {rule} for an approximation"


@once_per_escapement
def uniqueness_note(escapement: Escapement) -> str | None:
    """The message for a motion that is not unique; None for all others."""
    if escapement.mechanism.pitch is not None:
        return None
    if all(_is_closed(scene) for scene in escapement.scenes):
        return None
    if escapement.contact == "compliant":
        # with compliant contact the motion is unique
        return None
    limit = friction_limits(escapement)[1]
    if escapement.friction < limit:
        return None
    return (
        f"a second motion is possible, because friction {escapement.friction:g} is at "
        f"or above the limit of uniqueness {limit:.6g}: an impact before dead centre could jam "
        "the pin"
    )
