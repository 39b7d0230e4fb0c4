"""What a march meets inside one panel: speeds, reversals, extrema.

All of it works on values at the panel's points, kept in the scratch; a march decides
what is asked of which panel.
"""

import numpy as np

from escapement._jit import jit
from escapement.dynamics import bend
from escapement.engines._gauss import (
    LAST,
    LAST_BUT_ONE,
    WEIGHTS,
    N,
    points_of,
)
from escapement.engines._panels import (
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
from escapement.mechanisms._slotted import PLACES

LEFT_END, RIGHT_END = np.int64(0), np.int64(1)
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
def dips(s):
    """Whether the contact nearly vanishes between points: a pair of reversals may hide."""
    # a parabola that touches zero is small at one of three points
    first, middle, last = s[C], s[C + N // 2], s[C + N - 1]
    if min(first, min(middle, last)) > 0.2 * max(first, max(middle, last)):
        return False
    count = 0
    for i in range(1, points_of(s) - 1):
        before, c, after = s[C + i - 1], s[C + i], s[C + i + 1]
        higher = before if before > after else after
        # least here, and less than half of what it fell by
        count += (c <= before) & (c < after) & (3.0 * c < higher)
    return count > 0


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
