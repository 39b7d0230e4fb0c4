"""Where in a panel something happens, and what the motion is there.

Reversals and extrema are roots of values at the panel's points; what lies before and
behind them follows from weights that interpolate to the place, and that integrate.
"""

import numpy as np

from escapement.dynamics import bend
from escapement.engines.energy.gauss import (
    BARYCENTRIC,
    FROM_LEFT,
    POINTS,
    N,
    cumulate,
    dot,
    points_of,
    root_between,
    to_powers,
)
from escapement.engines.energy.panels import (
    ALPHA,
    BETA,
    DG,
    ENDS,
    HALF,
    INVERSE,
    LEFT,
    NOISE,
    RIGHT,
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
    solution_of,
)
from escapement.engines.energy.sampling import (
    EVERY_POINT,
    MERGED,
    NOTHING,
    RIGHT_END,
    contact_at_end,
    dips,
    duration,
    rate_at_end,
)
from escapement.jit import jit
from escapement.mechanisms.slotted import PLACES, transmission_at


@jit(reorders=True)
def weights_to(s, x):
    """Weights V that interpolate at x, and Q that do so for what vanishes at -1."""
    total = 0.0
    for i in range(points_of(s)):
        way = x - POINTS[i]
        weight = BARYCENTRIC[i] / (way if way != 0.0 else 1e-17)
        s[V + i] = weight
        total += weight
    scale = 1.0 / total
    for i in range(points_of(s)):
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
    to_powers(s, values, K)
    low, value_low = -1.0, left
    if place > 0:
        low, value_low = POINTS[place - 1], s[values + place - 1]
    value_high = right
    if place < N and POINTS[place] < high:
        high, value_high = POINTS[place], s[values + place]
    x = low - value_low * (high - low) / (value_high - value_low)
    if not low <= x <= high:
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
    cumulate(s, F, K)
    angle = s[at + LEFT] + s[at + HALF] * (1.0 + x)
    g, u, dg = transmission_at(path, angle)
    return angle, dot(s, Q, K), dot(s, V, E) / (rho + g * g), g, abs(u), dg


@jit
def reversal_at(s, at, side, x, slope, path, w, rho, load):
    """Angle, time since the left end, where w is known, and w of a reversal located at x."""
    if x <= -1.0:
        weights_to(s, -1.0)
        return s[at + LEFT], 0.0, w
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
    one, two = solution_of(at, side), solution_of(at, -side)
    e = dot(s, V, E)
    alpha, beta, b = dot(s, V, one + ALPHA), dot(s, V, one + BETA), dot(s, V, one + B)
    alpha_other, beta_other = dot(s, V, two + ALPHA), dot(s, V, two + BETA)
    b_other = dot(s, V, two + B)
    fictive = (e - beta_other) / alpha_other
    bad = 0
    apart = s[at + HALF] > MERGED
    lost = bend(-side, mu)
    for i in range(points_of(s)):
        w = (s[two + ALPHA + i] * fictive + s[two + BETA + i]) * s[at + INVERSE + i]
        slowness = s[at + STEP + i] / np.sqrt(w)
        s[WORK + i] = s[F + i] - slowness
        s[F + i] = slowness
        moment = s[at + DG + i] * w + load
        c = side * (rho * moment + s[at + G + i])
        a = 1.0 - (s[at + G + i] + lost * s[at + U + i]) * moment
        s[C + i] = c
        s[A + i] = a
        bad += not w > 0.0
        bad += apart and i >= reversal and c > 0.0
        bad += record and i >= reversal and a <= 0.0
    # the time of the other side, and what the part before the reversal differs by
    cumulate(s, WORK, K)
    length, roughness = duration(s)
    length += dot(s, Q, K)
    e_right = s[two + RIGHT] * fictive + s[two + RIGHT + 1]
    w_right = e_right / (rho + s[at + ENDS + 3] ** 2)
    bad += not w_right > 0.0
    c_right = side * contact_at_end(s, at, RIGHT_END, w_right, rho, load)
    a_right = rate_at_end(s, at, RIGHT_END, -side, w_right, mu, load)
    bad += apart and c_right > 0.0
    bad += record and a_right <= 0.0
    nothing = NOTHING * (rho + s[at + ENDS] ** 2)
    rest = reversal + 1
    bad += apart and dips(s, C, nothing, c_right, c_right, rest, EVERY_POINT)
    bad += apart and record and dips(s, A, NOTHING, a_right, a_right, rest, EVERY_POINT)
    good = bad == 0 and roughness <= max(strict, s[two + NOISE])
    source = (alpha * source + beta - beta_other) / alpha_other
    source = s[two + RIGHT] * source + s[two + RIGHT + 1]
    exponent = b - b_other + s[two + RIGHT + 2]
    return good, e_right, length, exponent, source
