"""Panels: an engagement cut into pieces on which the energy equation is solved.

Twice the kinetic energy, E = (rho + g^2) w, obeys on a panel with side s

    E' = A - B E,   c = p - g,   J = rho + g^2 + g c,
    A = 2 (1 - g load) - 2 c (rho load + g)/J,   B = 2 c rho g'/(J (rho + g^2)),

so E = alpha E_left + beta with alpha = exp(-int B), beta = alpha int A/alpha:
two quadratures, whatever the energy at the left end. B vanishes with mu, so
nothing is lost by cancellation in the frictionless limit.

Values live at 16 Gauss points. Integrals over a whole panel converge twice as
fast as interpolation inside it; a panel records the size of its last Legendre
coefficients and is halved when what is asked of it needs better.
"""

import numpy as np

from escapement._jit import jit
from escapement.dynamics import bend
from escapement.mechanisms._slotted import transmission_at, transmission_on

N = 16

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(N)
LEGENDRE = np.polynomial.legendre.legvander(POINTS, N).T.copy()
"""Legendre polynomials 0..N (rows) at the points."""
_ORDERS = np.arange(N)
TRANSFORM = ((2 * _ORDERS + 1) / 2.0)[:, None] * LEGENDRE[:N] * WEIGHTS
"""Values at the points to Legendre coefficients (rows)."""
BASIS = (LEGENDRE[:N] * WEIGHTS / 2.0).copy()
"""Legendre polynomials times half the weights: row k, point i."""
SPREAD = TRANSFORM.T.copy()
"""TRANSFORM by point: what each value adds to all coefficients, for wide vectors."""
LAST, LAST_BUT_ONE = TRANSFORM[N - 1].copy(), TRANSFORM[N - 2].copy()
UP, DOWN = (2 * _ORDERS + 1) / (_ORDERS + 1), _ORDERS / (_ORDERS + 1)
"""Recurrence P[k+1] = UP[k] x P[k] - DOWN[k] P[k-1], free of divisions."""


def _integrated(x: np.ndarray) -> np.ndarray:
    """Integral of each Legendre polynomial from -1 to x, shape (N, x.size)."""
    values = np.polynomial.legendre.legvander(x, N + 1).T
    upper = np.vstack([values[1:2] - 1.0 + 2.0, values[2 : N + 1] - values[: N - 1]])
    return upper / np.maximum(2 * _ORDERS + 1, 1)[:, None]


CUMULATE = (_integrated(POINTS).T @ TRANSFORM).T.copy()
"""CUMULATE[k, i]: weight of the value at point k in the integral to point i."""

# The panel store has three rows a panel: its geometry, then a solution for either side
# of the slot. Fixed columns in every row let the compiler make vector code.
LEFT, HALF, NEXT, KINK = 0, 1, 2, 3  # KINK: whether the left end is a break of the mechanism
G, U, DG, INVERSE = 4, 4 + N, 4 + 2 * N, 4 + 3 * N
ENDS = 4 + 4 * N  # g, |u|, g' at the left end, then at the right end
# a solution: alpha, beta, b = int B at the points, then the three at the right end, the
# size of the last coefficients (UNBUILT: not solved yet) and the rounding noise in them
ALPHA, BETA, B, RIGHT, TAIL, NOISE = 0, N, 2 * N, 3 * N, 3 * N + 3, 3 * N + 4
COLUMNS = ENDS + 6
GEOMETRY, FORWARD, BACKWARD = 0, 1, 2
UNBUILT = -1.0
MAX_PANELS = 2048
SMALLEST = 1e-13  # of a radian: no panel is halved below this


@jit
def part_of(side):
    """Row of a panel's solution for a side of the slot."""
    return FORWARD if side > 0.0 else BACKWARD


@jit
def survey(panel, path, rho, left, right):
    """Fill a panel's geometry and mark both sides as not yet solved."""
    row = panel[GEOMETRY]
    half = 0.5 * (right - left)
    middle = 0.5 * (right + left)
    row[LEFT] = left
    row[HALF] = half
    transmission_on(path, middle, half, POINTS, row, G, U, DG)
    for i in range(N):
        row[INVERSE + i] = 1.0 / (rho + row[G + i] * row[G + i])
    for k in range(2):
        g, u, dg = transmission_at(path, left if k == 0 else right)
        row[ENDS + 3 * k] = g
        row[ENDS + 3 * k + 1] = abs(u)
        row[ENDS + 3 * k + 2] = dg
    panel[FORWARD, TAIL] = UNBUILT
    panel[BACKWARD, TAIL] = UNBUILT


@jit
def tail_of(values, offset):
    """Size of the last two Legendre coefficients of N values from `offset`."""
    a = b = c = d = 0.0
    for i in range(0, N, 2):
        a += LAST[i] * values[offset + i]
        b += LAST_BUT_ONE[i] * values[offset + i]
        c += LAST[i + 1] * values[offset + i + 1]
        d += LAST_BUT_ONE[i + 1] * values[offset + i + 1]
    return abs(a + c) + abs(b + d)


@jit
def whole(values, offset):
    """Integral over [-1, 1] of N values from `offset`."""
    a = b = c = d = 0.0
    for i in range(0, N, 4):
        a += WEIGHTS[i] * values[offset + i]
        b += WEIGHTS[i + 1] * values[offset + i + 1]
        c += WEIGHTS[i + 2] * values[offset + i + 2]
        d += WEIGHTS[i + 3] * values[offset + i + 3]
    return (a + b) + (c + d)


@jit
def combine(m, c, at, out, to):
    """out[to + i] = sum over k of m[k, i] c[at + k].

    Written out so that it becomes vector code; places instead of slices, which
    would take as long to make as the sums.
    """
    c0, c1, c2, c3 = c[at], c[at + 1], c[at + 2], c[at + 3]
    c4, c5, c6, c7 = c[at + 4], c[at + 5], c[at + 6], c[at + 7]
    d0, d1, d2, d3 = c[at + 8], c[at + 9], c[at + 10], c[at + 11]
    d4, d5, d6, d7 = c[at + 12], c[at + 13], c[at + 14], c[at + 15]
    for i in range(N):
        low = (m[0, i] * c0 + m[1, i] * c1) + (m[2, i] * c2 + m[3, i] * c3)
        low += (m[4, i] * c4 + m[5, i] * c5) + (m[6, i] * c6 + m[7, i] * c7)
        high = (m[8, i] * d0 + m[9, i] * d1) + (m[10, i] * d2 + m[11, i] * d3)
        high += (m[12, i] * d4 + m[13, i] * d5) + (m[14, i] * d6 + m[15, i] * d7)
        out[to + i] = low + high


@jit
def _decay(row, at, to):
    """exp(-b): by its series, which vectorises, where every b is small."""
    large = 0
    for i in range(N):
        large += abs(row[at + i]) > 0.7
    if large > 0:
        for i in range(N):
            row[to + i] = np.exp(-row[at + i])
        return
    for i in range(N):
        x = -row[at + i]
        y = 1.0 + x * (1.0 / 16.0)
        y = 1.0 + x * (1.0 / 15.0) * y
        y = 1.0 + x * (1.0 / 14.0) * y
        y = 1.0 + x * (1.0 / 13.0) * y
        y = 1.0 + x * (1.0 / 12.0) * y
        y = 1.0 + x * (1.0 / 11.0) * y
        y = 1.0 + x * (1.0 / 10.0) * y
        y = 1.0 + x * (1.0 / 9.0) * y
        y = 1.0 + x * (1.0 / 8.0) * y
        y = 1.0 + x * (1.0 / 7.0) * y
        y = 1.0 + x * (1.0 / 6.0) * y
        y = 1.0 + x * (1.0 / 5.0) * y
        y = 1.0 + x * (1.0 / 4.0) * y
        y = 1.0 + x * (1.0 / 3.0) * y
        y = 1.0 + x * (1.0 / 2.0) * y
        row[to + i] = 1.0 + x * y


@jit
def solve_side(row, solution, side, rho, mu, load, scratch):
    """Solve the energy equation on a panel for one side of the slot."""
    twice = 2.0 * row[HALF]
    lost = bend(side, mu)
    for k in range(N):
        g = row[G + k]
        inverse = row[INVERSE + k]
        c = lost * row[U + k]
        share = 1.0 / (1.0 + g * c * inverse)  # (rho + g^2) / J
        scratch[k] = twice * c * rho * row[DG + k] * share * inverse * inverse
        scratch[N + k] = twice * ((1.0 - g * load) - c * (rho * load + g) * share * inverse)
        solution[BETA + k] = share
    # J is a difference near the Painleve limit: finer panels cannot help below this
    noise = 1e-15 * (1.0 + whole(solution, BETA))
    total = whole(scratch, 0)
    combine(CUMULATE, scratch, 0, solution, B)
    _decay(solution, B, ALPHA)
    for i in range(N):
        scratch[N + i] /= solution[ALPHA + i]
    source = whole(scratch, N)
    combine(CUMULATE, scratch, N, solution, BETA)
    for i in range(N):
        solution[BETA + i] *= solution[ALPHA + i]
    largest = max(abs(solution[BETA + N - 1]), abs(solution[BETA + N // 2]))
    alpha = np.exp(-total)
    solution[RIGHT] = alpha
    solution[RIGHT + 1] = alpha * source
    solution[RIGHT + 2] = total
    tail = tail_of(solution, ALPHA) / max(1.0, alpha)
    tail = max(tail, tail_of(solution, BETA) / max(largest, 1e-300))
    tail = max(tail, tail_of(row, INVERSE) / max(row[INVERSE], row[INVERSE + N - 1]))
    noise *= max(1.0, abs(total))
    solution[NOISE] = noise
    if tail < noise:
        tail = 0.0
    if not tail < 1.0 or abs(total) > 20.0:
        tail = 1.0
    solution[TAIL] = tail


@jit
def halve(store, panel, path, rho, count):
    """Split a panel in two; returns the new number of panels.

    The left half keeps the row, the right half gets row `count` and the place
    behind it in the chain.
    """
    row = store[panel, GEOMETRY]
    left = row[LEFT]
    middle = left + row[HALF]
    right = left + 2.0 * row[HALF]
    following = row[NEXT]
    # a break of the mechanism keeps its exact angle
    if following >= 0.0:
        right = store[int(following), GEOMETRY, LEFT]
    survey(store[panel], path, rho, left, middle)
    survey(store[count], path, rho, middle, right)
    row[NEXT] = count
    store[count, GEOMETRY, NEXT] = following
    store[count, GEOMETRY, KINK] = 0.0
    return count + 1


@jit
def evaluate(c, at, x):
    """The Legendre series with coefficients c[at:], and its derivative, at x in [-1, 1]."""
    before, now = 1.0, x
    before_slope, slope = 0.0, 1.0
    value = c[at] + c[at + 1] * x
    derivative = c[at + 1]
    for k in range(1, N - 1):
        after = UP[k] * x * now - DOWN[k] * before
        after_slope = before_slope + (2 * k + 1) * now
        before, now = now, after
        before_slope, slope = slope, after_slope
        value += c[at + k + 1] * now
        derivative += c[at + k + 1] * slope
    return value, derivative


@jit
def root_between(c, at, low, high, value_low, value_high):
    """Root of a Legendre series in a bracket: Newton, kept in by bisection."""
    x = low + (high - low) * value_low / (value_low - value_high)
    for _ in range(60):
        value, slope = evaluate(c, at, x)
        if value * value_low > 0.0:
            low = x
        else:
            high = x
        guess = x - value / slope
        if not low <= guess <= high:
            guess = 0.5 * (low + high)
        step = abs(guess - x)
        x = guess
        # Newton squares the error: the next step would be rounding
        if step <= 3e-8:
            break
    return x


@jit
def weights_to(x, scratch, work, values, partial):
    """Weights that interpolate at x, and that integrate from -1 to x, at two places."""
    scratch[work], scratch[work + N] = 1.0, 1.0 + x
    before, now = 1.0, x
    for k in range(1, N):
        after = UP[k] * x * now - DOWN[k] * before
        scratch[work + k] = (2 * k + 1) * now
        scratch[work + N + k] = after - before
        before, now = now, after
    combine(BASIS, scratch, work, scratch, values)
    combine(BASIS, scratch, work + N, scratch, partial)
