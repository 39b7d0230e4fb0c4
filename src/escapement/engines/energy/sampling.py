"""The motion at the points of one panel: energy, speed, contact, acceleration and time.

`sample_panel` evaluates them and keeps them in the workspace. The other functions read from
these values whether the panel holds a reversal, an extremum or a stop; the march decides which of
these it needs for which panel.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.law import (
    contact,
    friction_ratio,
    is_viscous,
    net_torque,
    reduced_inertia,
    root_of,
    settled,
)
from escapement.dynamics.torque import at_speed, same_angle_gap
from escapement.dynamics.train_losses import is_lossy, within_flow
from escapement.engines.energy.panels import points_of, pull_at
from escapement.numerics.gauss import LAST_BUT_ONE_COEFFICIENT, LAST_COEFFICIENT, POINTS, WEIGHTS, N
from escapement.numerics.jit import inner_jit

# These are the distances in x of an end of the panel from the two points next to it.
TO_NEAREST, TO_SECOND = float(1.0 + POINTS[0]), float(1.0 + POINTS[1])
# Values below this share of the driving torque count as rounding. Next to the stop of a mesh,
# rounding makes the sign of a vanishing force or acceleration change many times.
NEGLIGIBLE = 1e-12
# Two reversals in a panel of at most this half width [rad] are so close that they do not change
# the motion, and are not searched for.
CLOSE_PAIR = 1e-9
# A panel in which power turns back through a train is halved down to this half width [rad]. There
# theta_ddot has a corner and does not jump, so that the error of w is of the order of its square.
NARROW_TURN = 3e-9
# This is the relative error of a slope at an end that is read from two points.
SLOPE_ERROR = 0.01


class Points(NamedTuple):
    """The points of a panel from `first` to before `last`."""

    first: int
    last: int


EVERY_POINT = Points(first=0, last=N)


@inner_jit
def friction_ratio_at(end, side, scene):
    """c = p - g at an end of a panel; 0 in a dwell, where g and u are zero."""
    return friction_ratio(end.g, end.u, end.radius, side, scene)


@inner_jit
def net_torque_at(end, side, w, scene):
    """J theta_ddot at an end of a panel."""
    c, root = friction_ratio_at(end, side, scene), root_of(w, scene)
    pull = at_speed(end.pull, end.turned, w, scene)
    return net_torque(end.g, c, end.dg, pull, w, root, scene, end.load)


@inner_jit
def contact_at(end, w, scene):
    """X at an end of a panel."""
    pull = at_speed(end.pull, end.turned, w, scene)
    return contact(end.g, end.dg, pull, w, root_of(w, scene), scene, end.load)


@inner_jit
def beside(scene, panel, value, row, point):
    """A value at an end of a panel, 0 where it has the sign of the nearest point close to it.

    `row` has the values at the points, and `point` is 0 at the left end and N - 1 at the right.
    """
    return settled(value, row[point], panel.dtheta_dx[point] * TO_NEAREST, same_angle_gap(scene))


@inner_jit
def sample_panel(scene, work, panel, solution, side, energy):
    """Fill the workspace with E, w, s X, J theta_ddot and dt/dx at the points of a panel.

    `energy` is E at the left end.

    Returns
    -------
    against, stopped, slowing : numbers of points at which s X <= 0, so that the other side
        carries the force; at which w <= 0; and at which theta_ddot <= 0.
    """
    against = 0
    stopped = 0
    slowing = 0
    viscous, left_pull = is_viscous(scene), panel.entry.pull
    for i in range(points_of(work)):
        # E = alpha E_left + beta, and w = E/(rho + g^2)
        e = solution.alpha[i] * energy + solution.beta[i]
        w = e * panel.inverse_inertia[i]
        speed = np.sqrt(w)
        root = speed if viscous else 0.0
        # X is the contact moment times J > 0
        g, k, pull = panel.g[i], panel.dg[i], pull_at(left_pull, panel.pull, i, scene)
        pull = at_speed(pull, panel.turned[i], w, scene)
        c = side * contact(g, k, pull, w, root, scene, panel.load[i])
        a = net_torque(g, solution.friction_ratio[i], k, pull, w, root, scene, panel.load[i])
        work.energy[i] = e
        work.w[i] = w
        work.contact[i] = c
        work.net_torque[i] = a
        # dt/dx = theta'/sqrt(w); where there is no speed it is infinite or NaN
        work.slowness[i] = panel.dtheta_dx[i] / speed
        against += c <= 0.0
        stopped += not w > 0.0
        slowing += a <= 0.0
    return against, stopped, slowing


@inner_jit
def turns_back(scene, work, panel, solution, side, w_left, w_right):
    """Whether power in a lossy train changes direction, on a panel wide enough to matter.

    The panel is the one just sampled; `w_left` and `w_right` are at its ends. Two changes between
    neighbouring points count as well. The torques at the points whose signs tell the direction are
    left in the rows `decay` and `gain` of the workspace.
    """
    if not is_lossy(scene) or panel.half <= NARROW_TURN:
        return False
    left_q, left_z = flow_at_end(scene, panel.entry, side, w_left)
    right_q, right_z = flow_at_end(scene, panel.exit, side, w_right)
    rounding = NEGLIGIBLE * (1.0 + max(w_left, w_right))
    least = min(right_q, right_z)
    for i in range(N):
        g = panel.g[i]
        rate = work.net_torque[i] / reduced_inertia(g, solution.friction_ratio[i], scene)
        pull = at_speed(panel.pull[i], panel.turned[i], work.w[i], scene)
        q, z = within_flow(g, panel.dg[i], rate, pull, work.w[i], scene)
        work.decay[i], work.gain[i] = q, z
        least = min(least, min(q, z))
    if least < -rounding:
        return True
    return may_vanish(work, work.decay, rounding, left_q, right_q, EVERY_POINT) or may_vanish(
        work, work.gain, rounding, left_z, right_z, EVERY_POINT
    )


@inner_jit
def flow_at_end(scene, end, side, w):
    """`within_flow` at an end of a panel."""
    rate = net_torque_at(end, side, w, scene)
    rate /= reduced_inertia(end.g, friction_ratio_at(end, side, scene), scene)
    pull = at_speed(end.pull, end.turned, w, scene)
    return within_flow(end.g, end.dg, rate, pull, w, scene)


@inner_jit
def first_against(work):
    """The first point at which s X <= 0; N if there is none."""
    for i in range(N):
        if work.contact[i] <= 0.0:
            return i
    return N


@inner_jit
def clearly_against(work):
    """Number of points at which s X is negative by more than rounding.

    Next to the stop of a mesh that is known from a table, g and g' are rounding errors.
    """
    largest = 0.0
    for i in range(points_of(work)):
        largest = max(largest, work.contact[i])
    count = 0
    for i in range(N):
        count += work.contact[i] < -1e-9 * largest
    return count


@inner_jit
def may_vanish(work, values, negligible, left, right, tried):
    """Whether a function of one sign at the points may vanish between them.

    Two zeros may lie between two points. `tried` are the `Points` that are tried, and the ends of
    the panel, at which the values are `left` and `right`, are tried where these points reach them.
    A minimum of the absolute value is ignored where the values on both sides of it are below
    `negligible` too. `values` is a row of `work`.
    """
    count, steep = 0, 0
    # two halves of eight pairs, with one pair in common, become vector code without a rest
    for i in range(points_of(work) // 2):
        # the product is positive for neighbours of one sign that are within a factor of two;
        # without a steeper pair the loop below can find nothing
        one, two = values[i], values[i + 1]
        steep += (one - 2.0 * two) * (two - 2.0 * one) < 0.0
        one, two = values[i + N // 2 - 1], values[i + N // 2]
        steep += (one - 2.0 * two) * (two - 2.0 * one) < 0.0
    if steep > 0:
        for i in range(max(1, tried.first), min(tried.last, N - 1)):
            count += _touches(negligible, values[i - 1], values[i], values[i + 1])
    if tried.first == 0 < tried.last:
        count += _touches_at_end(negligible, left, values[0], values[1])
    if tried.last == N:
        count += _touches_at_end(negligible, right, values[N - 1], values[N - 2])
    return count > 0


@inner_jit
def _touches(negligible, before, here, after):
    """Whether a function may touch zero next to the middle one of three neighbours.

    Where a parabola touches zero, its value at the nearest point is less than half of its
    value at one of the two points beside that one.
    """
    if not (before * here > 0.0 and here * after > 0.0):
        return False
    here, before, after = abs(here), abs(before), abs(after)
    high = max(before, after)
    return here <= min(before, after) and 2.0 * here < high and high > negligible


@inner_jit
def _touches_at_end(negligible, end, one, two):
    """Whether the parabola through an end and two points falls between them to half of `end`.

    Where `end` is nearly zero, a small slope is enough for that; it is therefore taken at
    the lower bound of its error.
    """
    if end < 0.0:
        end, one, two = -end, -one, -two
    if not max(end, two) > negligible:
        return False
    # the parabola is end + a t + b t^2 at the distance t; slope and rise are a and b by `scale`
    one, two = one - end, two - end
    unsure = SLOPE_ERROR * abs(two) * TO_NEAREST * (TO_SECOND - TO_NEAREST)
    slope = one * TO_SECOND**2 - two * TO_NEAREST**2 - unsure
    if not (slope < 0.0 and end > 0.0):
        return False
    rise = two * TO_NEAREST - one * TO_SECOND
    scale = TO_NEAREST * TO_SECOND * (TO_SECOND - TO_NEAREST)
    # its least value lies at t = -a/(2 b) and is end - a^2/(4 b)
    return -slope < 2.0 * rise * TO_SECOND and slope * slope > 2.0 * rise * scale * end


@inner_jit(reorders=True)
def duration(work):
    """Time over the panel, int dt/dx, and the tail of dt/dx relative to its middle value."""
    total = last = last_but_one = 0.0
    for i in range(points_of(work)):
        total += WEIGHTS[i] * work.slowness[i]
        last += LAST_COEFFICIENT[i] * work.slowness[i]
        last_but_one += LAST_BUT_ONE_COEFFICIENT[i] * work.slowness[i]
    return total, (abs(last) + abs(last_but_one)) / work.slowness[N // 2]


@inner_jit
def find_extremum(torque, last, first, final):
    """Changes of the sign of theta_ddot before the point `last`, or on the whole panel if it is N.

    `torque` is J theta_ddot at the points, `first` at the left end, and `final` at the right
    end or at the reversal.

    Returns
    -------
    changes, point : number of changes, and the first point after the last one, -1 if none.
    """
    if last == 0:
        return (1, 0) if first * final < 0.0 else (0, -1)
    changes, point = (1, 0) if first * torque[0] < 0.0 else (0, -1)
    for i in range(1, last):
        if (torque[i - 1] <= 0.0) != (torque[i] <= 0.0):
            changes += 1
            point = i
    if torque[last - 1] * final < 0.0:
        changes += 1
        point = last
    return changes, point
