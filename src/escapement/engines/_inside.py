"""What a march meets inside one panel: speeds, reversals, extrema, a start from rest.

All of it works on values at the panel's points, kept in the scratch; a march decides
what is asked of which panel.
"""

import numpy as np

from escapement._jit import jit
from escapement.dynamics import bend
from escapement.engines._gauss import (
    BARYCENTRIC,
    CUMULATE,
    FROM_LEFT,
    POINTS,
    POWERS,
    N,
    combine,
    dot,
    root_between,
)
from escapement.engines._panels import (
    ALPHA,
    BETA,
    DG,
    ENDS,
    HALF,
    INVERSE,
    LEFT,
    NOISE,
    RIGHT,
    START,
    STEP,
    WORK,
    A,
    B,
    C,
    E,
    F,
    G,
    K,
    Q,
    U,
    V,
    W,
    solution_of,
    survey,
    tail_of,
    whole,
)
from escapement.mechanisms._slotted import PLACES, transmission_at

MERGED = 1e-9  # half width of a panel in which a pair of reversals does nothing
FROM_REST = 0.5 * (1.0 + POINTS) ** 2 - 1.0
"""Points of a panel that are Gauss points of the square root of the way."""


@jit
def rate_at_end(s, at, end, side, w, mu, load):
    """J theta_ddot at the left (0) or right (1) end: the sign of the acceleration."""
    to = at + ENDS + 3 * end
    return 1.0 - (s[to] + bend(side, mu) * s[to + 1]) * (s[to + 2] * w + load)


@jit
def contact_at_end(s, at, end, w, rho, load):
    """Contact function at the left (0) or right (1) end."""
    to = at + ENDS + 3 * end
    return rho * (s[to + 2] * w + load) + s[to]


@jit
def braking(s, at, side, w, rho, mu, load):
    """Slope of w by driver angle at the left end."""
    g = s[at + ENDS]
    j = rho + g * (g + bend(side, mu) * s[at + ENDS + 1])
    return 2.0 * rate_at_end(s, at, 0, side, w, mu, load) / j


@jit
def start_slowly(s, at, path, rho, way):
    """Fill the start's panel: that at `at`, over the square root of the angle.

    From rest w grows like the angle, and 1/sqrt(w) is singular; over
    y = sqrt(way + (theta - left)/length), with the speed zero at y = 0, neither is.
    `way` is how far before the left end that lies, in lengths of the panel.
    """
    left, half = s[at + LEFT], s[at + HALF]
    if way == 0.0:
        survey(s, START, path, rho, left, left + 2.0 * half, FROM_REST, 0)
        for i in range(N):
            s[START + STEP + i] = half * (1.0 + POINTS[i])
        return
    first, last = np.sqrt(way), np.sqrt(1.0 + way)
    for i in range(N):
        y = 0.5 * ((last + first) + (last - first) * POINTS[i])
        s[K + i] = 2.0 * (y * y - way) - 1.0
        s[V + i] = 2.0 * half * (last - first) * y
    survey(s, START, path, rho, left, left + 2.0 * half, s, K)
    for i in range(N):
        s[START + STEP + i] = s[V + i]


@jit
def run_over(s, at, side, energy, rho, load):
    """Energy, speed, slowness and contact at the points.

    Returns
    -------
    against, stopped : points where the other side carries the force, and where
        there is no speed left.
    """
    at &= PLACES
    to = solution_of(at, side) & PLACES
    against = 0
    stopped = 0
    for i in range(N):
        e = s[to + ALPHA + i] * energy + s[to + BETA + i]
        w = e * s[at + INVERSE + i]
        c = side * (rho * (s[at + DG + i] * w + load) + s[at + G + i])
        s[E + i] = e
        s[W + i] = w
        s[C + i] = c
        s[F + i] = s[at + STEP + i] / np.sqrt(w)
        against += c <= 0.0
        stopped += not w > 0.0
    return against, stopped


@jit
def clearly_against(s):
    """Points where the other side carries a force beyond rounding.

    Next to the stop of a mesh, known from a table, g and g' are rounding errors.
    """
    largest = 0.0
    for i in range(N):
        largest = max(largest, s[C + i])
    count = 0
    for i in range(N):
        count += s[C + i] < -1e-9 * largest
    return count


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
    for i in range(1, N - 1):
        c = s[C + i]
        if c <= s[C + i - 1] and c < s[C + i + 1]:
            drop = max(s[C + i - 1], s[C + i + 1]) - c
            return c < 0.5 * drop
    return False


@jit
def rough(s, limit):
    """Whether the slowness is less smooth than `limit`."""
    return tail_of(s, F) > limit * s[F + N // 2]


@jit
def find_extremum(s, at, side, w_left, w_right, last, mu, load):
    """Changes of sign of the acceleration before point `last` (N: over the panel).

    Returns
    -------
    changes, place : how many, and the point after the last one.
    """
    at &= PLACES
    previous = rate_at_end(s, at, 0, side, w_left, mu, load)
    changes = 0
    place = -1
    slower = 0
    lost = bend(side, mu)
    for i in range(N):
        a = 1.0 - (s[at + G + i] + lost * s[at + U + i]) * (s[at + DG + i] * s[W + i] + load)
        s[A + i] = a
        slower += a <= 0.0
    if last < N or (0 < slower < N) or (slower == 0) != (previous > 0.0):
        for i in range(last):
            a = s[A + i]
            if a * previous < 0.0:
                changes += 1
                place = i
            previous = a if a != 0.0 else previous
    # on a reversal the driver turns free of the follower and gains speed
    a = rate_at_end(s, at, 1, side, w_right, mu, load) if last == N else 1.0
    if a * previous < 0.0:
        changes += 1
        place = last
    return changes, place


@jit
def weights_to(s, x):
    """Weights V that interpolate at x, and Q that do so for what vanishes at -1."""
    for i in range(N):
        way = x - POINTS[i]
        s[V + i] = BARYCENTRIC[i] / (way if way != 0.0 else 1e-17)
    a = b = c = d = 0.0
    for i in range(0, N, 4):
        a += s[V + i]
        b += s[V + i + 1]
        c += s[V + i + 2]
        d += s[V + i + 3]
    scale = 1.0 / ((a + b) + (c + d))
    for i in range(N):
        weight = s[V + i] * scale
        s[V + i] = weight
        s[Q + i] = weight * FROM_LEFT[i] * (1.0 + x)


@jit
def locate(s, values, place, left, right, high):
    """Where values at the points change sign between point `place` and the one before.

    `left` is the value at -1, `right` that at x = `high`, which bounds the last point.

    Returns
    -------
    x, slope : the place, and the derivative of the values there.
    """
    values &= PLACES
    combine(POWERS, s, values, K)
    low, value_low = -1.0, left
    if place > 0:
        low, value_low = POINTS[place - 1], s[values + place - 1]
    value_high = right
    if place < N and POINTS[place] < high:
        high, value_high = POINTS[place], s[values + place]
    # the chord, then the parabola through one more point
    slope = (value_high - value_low) / (high - low)
    x = low - value_low / slope
    third = place + 1 if place < N // 2 else place - 2
    third_x = POINTS[third]
    bend_ = ((s[values + third] - value_low) / (third_x - low) - slope) / (third_x - high)
    x -= bend_ * (x - low) * (x - high) / (slope + bend_ * (2.0 * x - low - high))
    if not low < x < high:
        x = 0.5 * (low + high)
    x, slope = root_between(s, K, x, low, high, value_low < 0.0)
    if place == 0:
        # so near the left end that the way from there should be accurate, not x
        for _ in range(2):
            weights_to(s, x)
            value = left
            for i in range(N):
                value += s[Q + i] * (s[values + i] - left)
            x = max(-1.0, x - value / slope)
    return x, slope


@jit
def state_inside(s, at, x, path, rho):
    """State at x, and the weights to it in V and Q.

    Returns
    -------
    angle, elapsed, w, g, u, dg
        Elapsed is the time since the left end. g may be rougher than what the panel
        was made for: it is evaluated, not interpolated.
    """
    weights_to(s, x)
    combine(CUMULATE, s, F, K)
    angle = s[at + LEFT] + s[at + HALF] * (1.0 + x)
    g, u, dg = transmission_at(path, angle)
    return angle, dot(s, Q, K), dot(s, V, E) / (rho + g * g), g, abs(u), dg


@jit
def extremum_at(s, at, side, x, slope, path, rho, mu, load):
    """Angle, time since the left end and w of an extremum located at x."""
    angle, elapsed, w, g, u, dg = state_inside(s, at, x, path, rho)
    # a last step of Newton's with the evaluated transmission
    way = (1.0 - (g + bend(side, mu) * u) * (dg * w + load)) / -slope
    way = way if abs(way) < 1e-4 else 0.0
    return angle + s[at + HALF] * way, elapsed + way * s[at + HALF] / np.sqrt(w), w


@jit
def reversal_at(s, at, side, x, slope, path, rho, load):
    """Angle, time since the left end and w of a reversal located at x."""
    angle, elapsed, w, g, _u, dg = state_inside(s, at, x, path, rho)
    way = side * (rho * (dg * w + load) + g) / -slope
    way = s[at + HALF] * (way if abs(way) < 1e-4 else 0.0)
    # without a force the driver turns free
    return angle + way, elapsed + way / np.sqrt(w), w + 2.0 * way / rho


@jit
def turn(s, at, side, reversal, rho, mu, load, strict, record, source):
    """Go on with the other side's solution from the reversal to the right end.

    Both solutions are continued over the whole panel; the weights to the reversal
    take of each the part that happens.

    Returns
    -------
    good, e_right, length, exponent, source
        good is False where the panel is too coarse for this.
    """
    at &= PLACES
    one, two = solution_of(at, side) & PLACES, solution_of(at, -side) & PLACES
    e = dot(s, V, E)
    alpha, beta, b = dot(s, V, one + ALPHA), dot(s, V, one + BETA), dot(s, V, one + B)
    alpha_other, beta_other = dot(s, V, two + ALPHA), dot(s, V, two + BETA)
    b_other = dot(s, V, two + B)
    fictive = (e - beta_other) / alpha_other
    bad = 0
    apart = s[at + HALF] > MERGED
    lost = bend(-side, mu)
    for i in range(N):
        w = (s[two + ALPHA + i] * fictive + s[two + BETA + i]) * s[at + INVERSE + i]
        slowness = s[at + STEP + i] / np.sqrt(w)
        s[WORK + i] = s[F + i] - slowness
        s[F + i] = slowness
        moment = s[at + DG + i] * w + load
        bad += not w > 0.0
        bad += apart and i >= reversal and side * (rho * moment + s[at + G + i]) > 0.0
        slower = 1.0 - (s[at + G + i] + lost * s[at + U + i]) * moment <= 0.0
        bad += record and i >= reversal and slower
    # the time of the other side, and what the part before the reversal differs by
    combine(CUMULATE, s, WORK, K)
    length = whole(s, F) + dot(s, Q, K)
    e_right = s[two + RIGHT] * fictive + s[two + RIGHT + 1]
    w_right = e_right / (rho + s[at + ENDS + 3] ** 2)
    bad += not w_right > 0.0
    bad += apart and side * contact_at_end(s, at, 1, w_right, rho, load) > 0.0
    bad += record and rate_at_end(s, at, 1, -side, w_right, mu, load) <= 0.0
    good = bad == 0 and not rough(s, max(strict, s[two + NOISE]))
    source = (alpha * source + beta - beta_other) / alpha_other
    source = s[two + RIGHT] * source + s[two + RIGHT + 1]
    exponent = b - b_other + s[two + RIGHT + 2]
    return good, e_right, length, exponent, source
