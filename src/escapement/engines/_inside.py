"""What a march meets inside one panel: speeds, reversals, extrema, slow starts.

All of it works on values at the panel's points, kept in `scratch` at fixed
places; a march decides what is asked of which panel.
"""

import numpy as np

from escapement._jit import jit
from escapement.dynamics import bend
from escapement.engines._panels import (
    ALPHA,
    BETA,
    DG,
    DOWN,
    ENDS,
    HALF,
    INVERSE,
    LEFT,
    NOISE,
    POINTS,
    RIGHT,
    SPREAD,
    UP,
    WEIGHTS,
    B,
    G,
    N,
    U,
    combine,
    evaluate,
    root_between,
    tail_of,
    weights_to,
)
from escapement.mechanisms._slotted import transmission_at

# scratch: 2 N for solving panels; then w, 1/sqrt(w), contact, acceleration and energy at
# the points; Legendre coefficients; weights that interpolate, and that integrate, to x
W, F, C, A, E, K, V, Q = (2 * N + N * i for i in range(8))
SCRATCH = 10 * N
SMOOTH = 1.6  # a stop this far (x = -1.6) before a panel's left end needs no special weights


@jit
def rate(row, i, side, w, mu, load):
    """J theta_ddot at a point: the sign of the driver's acceleration."""
    return 1.0 - (row[G + i] + bend(side, mu) * row[U + i]) * (row[DG + i] * w + load)


@jit(inline=True)
def rate_at_end(row, end, side, w, mu, load):
    """J theta_ddot at the left (0) or right (1) end."""
    at = ENDS + 3 * end
    return 1.0 - (row[at] + bend(side, mu) * row[at + 1]) * (row[at + 2] * w + load)


@jit(inline=True)
def contact_at_end(row, end, w, rho, load):
    """Contact function at the left (0) or right (1) end."""
    at = ENDS + 3 * end
    return rho * (row[at + 2] * w + load) + row[at]


@jit
def braking(row, side, w, rho, mu, load):
    """Slope of w by driver angle at the left end."""
    at = ENDS
    j = rho + row[at] * (row[at] + bend(side, mu) * row[at + 1])
    return 2.0 * rate_at_end(row, 0, side, w, mu, load) / j


@jit(inline=True)
def run_over(row, solution, energy, side, rho, load, scratch):
    """Energy, speed, slowness and contact at the points.

    Returns
    -------
    against, stopped : points where the other side carries the force, and where
        there is no speed left.
    """
    against = 0
    stopped = 0
    for i in range(N):
        e = solution[ALPHA + i] * energy + solution[BETA + i]
        w = e * row[INVERSE + i]
        c = side * (rho * (row[DG + i] * w + load) + row[G + i])
        scratch[E + i] = e
        scratch[W + i] = w
        scratch[C + i] = c
        scratch[F + i] = 1.0 / np.sqrt(w)
        against += c <= 0.0
        stopped += not w > 0.0
    return against, stopped


@jit
def first_against(scratch):
    """First point where the other side carries the force; N if there is none."""
    for i in range(N):
        if scratch[C + i] <= 0.0:
            return i
    return N


@jit
def dips(scratch):
    """Whether the contact nearly vanishes between points: a pair of reversals may hide."""
    # a parabola that touches zero is small at one of three points
    first, middle, last = scratch[C], scratch[C + N // 2], scratch[C + N - 1]
    if min(first, min(middle, last)) > 0.2 * max(first, max(middle, last)):
        return False
    for i in range(1, N - 1):
        c = scratch[C + i]
        if c <= scratch[C + i - 1] and c < scratch[C + i + 1]:
            drop = max(scratch[C + i - 1], scratch[C + i + 1]) - c
            return c < 0.5 * drop
    return False


@jit(inline=True)
def rough(scratch, limit):
    """Whether 1/sqrt(w) is less smooth than `limit`."""
    return tail_of(scratch, F) > limit * scratch[F + N // 2]


@jit(inline=True)
def find_extremum(row, side, w_left, w_right, last, mu, load, scratch):
    """Changes of sign of the acceleration before point `last` (N: over the panel).

    Returns
    -------
    changes, place : how many, and the point after the last one.
    """
    previous = rate_at_end(row, 0, side, w_left, mu, load)
    changes = 0
    place = -1
    slower = 0
    for i in range(N):
        a = rate(row, i, side, scratch[W + i], mu, load)
        scratch[A + i] = a
        slower += a <= 0.0
    if last < N or (0 < slower < N) or (slower == 0) != (previous > 0.0):
        for i in range(last):
            a = scratch[A + i]
            if a * previous < 0.0:
                changes += 1
                place = i
            previous = a if a != 0.0 else previous
    # on a reversal the driver turns free of the follower and gains speed
    a = rate_at_end(row, 1, side, w_right, mu, load) if last == N else 1.0
    if a * previous < 0.0:
        changes += 1
        place = last
    return changes, place


@jit(inline=True)
def locate(values, place, left, right, scratch):
    """x where the values at scratch[values:] change sign next to the point `place`."""
    combine(SPREAD, scratch, values, scratch, K)
    low = POINTS[place - 1] if place > 0 else -1.0
    high = POINTS[place] if place < N else 1.0
    value_low = scratch[values + place - 1] if place > 0 else left
    value_high = scratch[values + place] if place < N else right
    x = root_between(scratch, K, low, high, value_low, value_high)
    weights_to(x, scratch, 0, V, Q)
    return x


@jit(inline=True)
def state_inside(row, path, x, rho, scratch):
    """Angle, time since the left end and w at x; the weights are those to x."""
    e = 0.0
    elapsed = 0.0
    for i in range(N):
        e += scratch[V + i] * scratch[E + i]
        elapsed += scratch[Q + i] * scratch[F + i]
    angle = row[LEFT] + row[HALF] * (1.0 + x)
    g, _u, _dg = transmission_at(path, angle)
    return angle, row[HALF] * elapsed, e / (rho + g * g)


@jit
def turn(row, solution, other, side, reversal, rho, mu, load, strict, record, source, scratch):
    """Go on with the other side's solution from the reversal to the right end.

    Both solutions are continued over the whole panel; the weights to the reversal
    take of each the part that happens.

    Returns
    -------
    good, e_right, length, exponent, source
        good is False where the panel is too coarse for this.
    """
    e = 0.0
    before = 0.0
    alpha, beta, b = 0.0, 0.0, 0.0
    alpha_other, beta_other, b_other = 0.0, 0.0, 0.0
    for i in range(N):
        v = scratch[V + i]
        e += v * scratch[E + i]
        before += scratch[Q + i] * scratch[F + i]
        alpha += v * solution[ALPHA + i]
        beta += v * solution[BETA + i]
        b += v * solution[B + i]
        alpha_other += v * other[ALPHA + i]
        beta_other += v * other[BETA + i]
        b_other += v * other[B + i]
    fictive = (e - beta_other) / alpha_other
    after = 0.0
    bad = 0
    for i in range(N):
        w = (other[ALPHA + i] * fictive + other[BETA + i]) * row[INVERSE + i]
        scratch[F + i] = 1.0 / np.sqrt(w)
        after += (WEIGHTS[i] - scratch[Q + i]) * scratch[F + i]
        bad += not w > 0.0
        c = side * (rho * (row[DG + i] * w + load) + row[G + i])
        bad += i >= reversal and c > 0.0
        bad += record and i >= reversal and rate(row, i, -side, w, mu, load) <= 0.0
    e_right = other[RIGHT] * fictive + other[RIGHT + 1]
    w_right = e_right / (rho + row[ENDS + 3] ** 2)
    bad += not w_right > 0.0
    bad += side * contact_at_end(row, 1, w_right, rho, load) > 0.0
    bad += record and rate_at_end(row, 1, -side, w_right, mu, load) <= 0.0
    good = bad == 0 and not rough(scratch, max(strict, other[NOISE]))
    source = (alpha * source + beta - beta_other) / alpha_other
    source = other[RIGHT] * source + other[RIGHT + 1]
    exponent = b - b_other + other[RIGHT + 2]
    return good, e_right, row[HALF] * (before + after), exponent, source


@jit(inline=True)
def rest_before(row, w, side, rho, mu, load, scratch):
    """x = -z where the speed would vanish before the left end; 2 where far away."""
    if not w < 0.25 * scratch[W + N // 2]:
        return 2.0
    slope = braking(row, side, w, rho, mu, load) * row[HALF]
    return 1.0 + w / slope if slope > 0.0 else 2.0


@jit
def way_from_rest(row, w, z, rho, scratch):
    """Distance before the left end, in half widths, at which the energy's extension is 0.

    The time depends on it like its square root, so it must have its own relative
    accuracy: the series is anchored at the energy of the left end, and very near
    the end replaced by a parabola through the slope known from z.
    """
    if w == 0.0:
        return 0.0
    combine(SPREAD, scratch, E, scratch, K)
    energy = w * (rho + row[ENDS] * row[ENDS])
    anchor, slope = evaluate(scratch, K, -1.0)
    way = z - 1.0
    if way < 1e-5:
        second = 0.0
        sign = 1.0
        for k in range(2, N):
            second += scratch[K + k] * sign * ((k - 1) * k * (k + 1) * (k + 2)) / 8.0
            sign = -sign
        # E(-1 - way) = energy - slope way + second way^2 / 2
        way = energy / slope
        return way * (1.0 + 0.5 * second * way / slope)
    x = -z
    for _ in range(6):
        value, slope = evaluate(scratch, K, x)
        x -= (value - anchor + energy) / slope
    return max(0.0, -1.0 - x)


@jit
def rough_from_rest(way, limit, scratch):
    """Whether 1/sqrt(w) over its singular part is less smooth than `limit`."""
    for i in range(N):
        scratch[K + i] = np.sqrt(1.0 + POINTS[i] + way) * scratch[F + i]
    return tail_of(scratch, K) > limit * scratch[K + N // 2]


@jit
def time_from_low_speed(row, way, scratch):
    """Time over a panel whose speed vanishes at x = -1 - way, just before its left end.

    1/sqrt(w) is a smooth function over sqrt(x + 1 + way); the generating function
    of the Legendre polynomials gives the moments of the weight in closed form. The
    way itself counts, by its square root, long after 1 + way is 1.
    """
    t = 1.0 / (1.0 + way + np.sqrt(way * (2.0 + way)))
    scale = np.sqrt(2.0 * t)
    total = 0.0
    for i in range(N):
        x = POINTS[i]
        before, now = 1.0, x
        weight = 1.0 - t * x
        power = -t
        for k in range(1, N - 1):
            after = UP[k] * x * now - DOWN[k] * before
            before, now = now, after
            power *= -t
            weight += power * now
        total += WEIGHTS[i] * scale * weight * np.sqrt(1.0 + x + way) * scratch[F + i]
    return row[HALF] * total
