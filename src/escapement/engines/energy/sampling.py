"""What a march meets inside one panel: speeds, reversals, extrema.

All of it works on values at the panel's points, kept in the scratch; a march decides
what is asked of which panel.
"""

import numpy as np

from escapement.dynamics import bend
from escapement.engines.energy.gauss import LAST, LAST_BUT_ONE, POINTS, WEIGHTS, N, points_of
from escapement.engines.energy.panels import (
    ALPHA,
    BETA,
    DG,
    ENDS,
    INVERSE,
    STEP,
    A,
    C,
    E,
    F,
    G,
    U,
    W,
    solution_of,
)
from escapement.jit import jit
from escapement.mechanisms.slotted import PLACES

FIRST, SECOND = float(1.0 + POINTS[0]), float(1.0 + POINTS[1])  # ways of two points from an end
LEFT_END, RIGHT_END = np.int64(0), np.int64(1)
NO_POINT, EVERY_POINT = np.int64(0), np.int64(N)  # for plain constants numba compiles users anew
NOTHING = 1e-12  # of the drive's torque: next to the stop of a mesh rounding has more dips
MERGED = 1e-9  # half width of a panel in which a pair of reversals does nothing


@jit
def rate_at_end(s, at, end, side, w, mu, load):
    """J theta_ddot at an end of a panel: the sign of the acceleration."""
    to = at + ENDS + 3 * end
    return 1.0 - (s[to] + bend(side, mu) * s[to + 1]) * (s[to + 2] * w + load)


@jit
def contact_at_end(s, at, end, w, rho, load):
    """Contact function at an end of a panel."""
    to = at + ENDS + 3 * end
    return rho * (s[to + 2] * w + load) + s[to]


@jit
def run_over(s, at, side, energy, rho, mu, load):
    """Energy, speed, slowness, contact and sign of the acceleration at the points.

    Returns
    -------
    against, stopped, slower : points where the other side carries the force, where
        there is no speed left, and where the driver gains none.
    """
    at &= PLACES
    to = solution_of(at, side)
    lost = bend(side, mu)
    against = 0
    stopped = 0
    slower = 0
    for i in range(points_of(s)):
        e = s[to + ALPHA + i] * energy + s[to + BETA + i]
        w = e * s[at + INVERSE + i]
        moment = s[at + DG + i] * w + load
        c = side * (rho * moment + s[at + G + i])
        a = 1.0 - (s[at + G + i] + lost * s[at + U + i]) * moment
        s[E + i] = e
        s[W + i] = w
        s[C + i] = c
        s[A + i] = a
        s[F + i] = s[at + STEP + i] / np.sqrt(w)
        against += c <= 0.0
        stopped += not w > 0.0
        slower += a <= 0.0
    return against, stopped, slower


@jit
def first_against(s):
    """First point where the other side carries the force; N if there is none."""
    for i in range(N):
        if s[C + i] <= 0.0:
            return i
    return N


@jit
def dips(s, values, nothing, left, right, first, last):
    """Whether values of one sign nearly vanish from point `first` to before `last`.

    Two zeros may hide there. `left` and `right` are the values at the ends; what is below
    `nothing` all around does nothing either.
    """
    values &= PLACES
    count, steep = 0, 0
    for i in range(points_of(s)):
        # neighbours of one sign and within a factor of two have a product above zero
        one, two = s[values + i], s[values + i + 1]
        steep += ((one - 2.0 * two) * (two - 2.0 * one) < 0.0) & (i < N - 1)
    if steep > 0:
        for i in range(max(1, first), min(last, N - 1)):
            count += _touches(nothing, s[values + i - 1], s[values + i], s[values + i + 1])
    if first == 0 < last:
        count += _touches_at_end(nothing, left, s[values], s[values + 1])
    if last == N:
        count += _touches_at_end(nothing, right, s[values + N - 1], s[values + N - 2])
    return count > 0


@jit
def _touches(nothing, before, here, after):
    """Whether three values may be next to where a function touches zero.

    Of a parabola that does the one nearest has less than half of what one beside it has.
    """
    if not (before * here > 0.0 and here * after > 0.0):
        return False
    here, before, after = abs(here), abs(before), abs(after)
    high = max(before, after)
    return here <= min(before, after) and 2.0 * here < high and high > nothing


@jit
def _touches_at_end(nothing, end, one, two):
    """Whether the parabola through an end and two points falls between them to half of `end`.

    Where `end` is next to nothing, so may be what its slope, a little uncertain, tells.
    """
    if end < 0.0:
        end, one, two = -end, -one, -two
    if not max(end, two) > nothing:
        return False
    one, two = one - end, two - end
    unsure = 0.01 * abs(two) * FIRST * (SECOND - FIRST)
    slope = one * SECOND**2 - two * FIRST**2 - unsure
    if not (slope < 0.0 and end > 0.0):
        return False
    rise, scale = two * FIRST - one * SECOND, FIRST * SECOND * (SECOND - FIRST)
    return -slope < 2.0 * rise * SECOND and slope * slope > 2.0 * rise * scale * end


@jit(reorders=True)
def duration(s):
    """Time over the panel, and how rough the slowness is: its last coefficients, relative."""
    total = last = last_but_one = 0.0
    for i in range(points_of(s)):
        total += WEIGHTS[i] * s[F + i]
        last += LAST[i] * s[F + i]
        last_but_one += LAST_BUT_ONE[i] * s[F + i]
    return total, (abs(last) + abs(last_but_one)) / s[F + N // 2]


@jit
def find_extremum(s, last, first, final):
    """Changes of sign of the acceleration before point `last` (N: over the panel).

    `first` and `final` have its sign at the left end, and at the right end or reversal.

    Returns
    -------
    changes, place : how many, and the point after the last one.
    """
    if last == 0:
        return (1, 0) if first * final < 0.0 else (0, -1)
    changes, place = (1, 0) if first * s[A] < 0.0 else (0, -1)
    for i in range(1, last):
        if (s[A + i - 1] <= 0.0) != (s[A + i] <= 0.0):
            changes += 1
            place = i
    if s[A + last - 1] * final < 0.0:
        changes += 1
        place = last
    return changes, place
