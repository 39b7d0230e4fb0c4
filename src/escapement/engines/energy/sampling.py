"""What a march meets inside one panel: speeds, reversals, extrema.

All of it works on values at the panel's points, kept in the workspace; the march decides
what is asked of which panel.
"""

import numpy as np

from escapement.dynamics import contact, driving
from escapement.engines.energy.gauss import LAST, LAST_BUT_ONE, POINTS, WEIGHTS, N
from escapement.engines.energy.panels import points_of
from escapement.jit import inner_jit

NEAREST, SECOND = float(1.0 + POINTS[0]), float(1.0 + POINTS[1])  # ways of two points from an end
NO_POINT, EVERY_POINT = np.int64(0), np.int64(N)  # for plain constants numba compiles users anew
NOTHING = 1e-12  # of the drive's torque: next to the stop of a mesh rounding has more dips
MERGED = 1e-9  # half width [rad] of a panel in which a pair of reversals does nothing
UNSURE = 0.01  # relative error of the slope that two points give at an end


@inner_jit
def driving_at(end, side, w, scene):
    """J theta_ddot at an end of a panel: the sign of the acceleration."""
    return driving(end.g, end.u, end.dg, w, side, scene)


@inner_jit
def contact_at(end, w, scene):
    """Contact function X at an end of a panel."""
    return contact(end.g, end.dg, w, scene)


@inner_jit
def run_over(scene, work, panel, solution, side, energy):
    """Energy, speed, slowness, contact and sign of the acceleration at the points.

    Returns
    -------
    against, stopped, slower : points where the other side carries the force, where
        there is no speed left, and where the driver gains none.
    """
    against = 0
    stopped = 0
    slower = 0
    for i in range(points_of(work)):
        e = solution.alpha[i] * energy + solution.beta[i]
        w = e * panel.inverse[i]
        c = side * contact(panel.g[i], panel.dg[i], w, scene)
        a = driving(panel.g[i], panel.u[i], panel.dg[i], w, side, scene)
        work.energy[i] = e
        work.w[i] = w
        work.contact[i] = c
        work.rate[i] = a
        work.slowness[i] = panel.step[i] / np.sqrt(w)
        against += c <= 0.0
        stopped += not w > 0.0
        slower += a <= 0.0
    return against, stopped, slower


@inner_jit
def first_against(work):
    """First point where the other side carries the force; N if there is none."""
    for i in range(N):
        if work.contact[i] <= 0.0:
            return i
    return N


@inner_jit
def clearly_against(work):
    """Points where the other side carries a force beyond rounding.

    Next to the stop of a mesh, known from a table, g and g' are rounding errors.
    """
    largest = 0.0
    for i in range(points_of(work)):
        largest = max(largest, work.contact[i])
    count = 0
    for i in range(N):
        count += work.contact[i] < -1e-9 * largest
    return count


@inner_jit
def dips(values, nothing, left, right, first, last, points):
    """Whether values of one sign nearly vanish from point `first` to before `last`.

    Two zeros may hide there. `left` and `right` are the values at the ends; what is below
    `nothing` all around does nothing either. `points` is that of `points_of`.
    """
    count, steep = 0, 0
    for i in range(points - 1):
        # neighbours of one sign and within a factor of two have a product above zero
        one, two = values[i], values[i + 1]
        steep += (one - 2.0 * two) * (two - 2.0 * one) < 0.0
    if steep > 0:
        for i in range(max(1, first), min(last, N - 1)):
            count += _touches(nothing, values[i - 1], values[i], values[i + 1])
    if first == 0 < last:
        count += _touches_at_end(nothing, left, values[0], values[1])
    if last == N:
        count += _touches_at_end(nothing, right, values[N - 1], values[N - 2])
    return count > 0


@inner_jit
def _touches(nothing, before, here, after):
    """Whether three values may be next to where a function touches zero.

    Of a parabola that does the one nearest has less than half of what one beside it has.
    """
    if not (before * here > 0.0 and here * after > 0.0):
        return False
    here, before, after = abs(here), abs(before), abs(after)
    high = max(before, after)
    return here <= min(before, after) and 2.0 * here < high and high > nothing


@inner_jit
def _touches_at_end(nothing, end, one, two):
    """Whether the parabola through an end and two points falls between them to half of `end`.

    Where `end` is next to nothing, so may be what its slope, a little uncertain, tells.
    """
    if end < 0.0:
        end, one, two = -end, -one, -two
    if not max(end, two) > nothing:
        return False
    one, two = one - end, two - end
    unsure = UNSURE * abs(two) * NEAREST * (SECOND - NEAREST)
    slope = one * SECOND**2 - two * NEAREST**2 - unsure
    if not (slope < 0.0 and end > 0.0):
        return False
    rise, scale = two * NEAREST - one * SECOND, NEAREST * SECOND * (SECOND - NEAREST)
    return -slope < 2.0 * rise * SECOND and slope * slope > 2.0 * rise * scale * end


@inner_jit(reorders=True)
def duration(work):
    """Time over the panel, and how rough the slowness is: its last coefficients, relative."""
    total = last = last_but_one = 0.0
    for i in range(points_of(work)):
        total += WEIGHTS[i] * work.slowness[i]
        last += LAST[i] * work.slowness[i]
        last_but_one += LAST_BUT_ONE[i] * work.slowness[i]
    return total, (abs(last) + abs(last_but_one)) / work.slowness[N // 2]


@inner_jit
def find_extremum(rate, last, first, final):
    """Changes of sign of the acceleration before point `last` (N: over the panel).

    `rate` has its sign at the points, `first` and `final` at the left end, and at the right
    end or reversal.

    Returns
    -------
    changes, place : how many, and the point after the last one.
    """
    if last == 0:
        return (1, 0) if first * final < 0.0 else (0, -1)
    changes, place = (1, 0) if first * rate[0] < 0.0 else (0, -1)
    for i in range(1, last):
        if (rate[i - 1] <= 0.0) != (rate[i] <= 0.0):
            changes += 1
            place = i
    if rate[last - 1] * final < 0.0:
        changes += 1
        place = last
    return changes, place
