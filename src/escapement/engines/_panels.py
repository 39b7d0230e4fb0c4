"""Panels: an engagement cut into pieces on which the energy equation is solved.

Twice the kinetic energy, E = (rho + g^2) w, obeys on a panel with side s

    E' = A - B E,   c = s mu |u|,   J = rho + g^2 + g c,
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

# One row of the panel store. A side's block is: tail, alpha, beta, b = int B at the
# points, then alpha, beta, b at the right end, and the rounding noise in all of these.
LEFT, HALF, NEXT, KINK = 0, 1, 2, 3  # KINK: whether the left end is a break of the mechanism
G, U, DG, INVERSE = 4, 4 + N, 4 + 2 * N, 4 + 3 * N
ENDS = 4 + 4 * N  # g, |u|, g' at the left end, then at the right end
SIDES = ENDS + 6
TAIL, ALPHA, BETA, B, RIGHT = 0, 1, 1 + N, 1 + 2 * N, 1 + 3 * N
NOISE = RIGHT + 3
BLOCK = NOISE + 1
ROW = SIDES + 2 * BLOCK

UNBUILT = -1.0
MAX_PANELS = 2048
SMALLEST = 1e-13  # of a radian: no panel is halved below this


@jit
def block_of(side):
    """Offset of a side's block in a panel's row."""
    return SIDES if side > 0.0 else SIDES + BLOCK


@jit
def survey(row, path, rho, left, right):
    """Fill a panel's geometry and mark both sides as not yet solved."""
    half = 0.5 * (right - left)
    middle = 0.5 * (right + left)
    row[LEFT] = left
    row[HALF] = half
    transmission_on(path, middle, half, POINTS, row[G : G + N], row[U : U + N], row[DG : DG + N])
    for i in range(N):
        row[INVERSE + i] = 1.0 / (rho + row[G + i] * row[G + i])
    for k in range(2):
        g, u, dg = transmission_at(path, left if k == 0 else right)
        row[ENDS + 3 * k] = g
        row[ENDS + 3 * k + 1] = abs(u)
        row[ENDS + 3 * k + 2] = dg
    row[SIDES + TAIL] = UNBUILT
    row[SIDES + BLOCK + TAIL] = UNBUILT


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
def _cumulate(values, out):
    """Integrals from -1 to each point; eight running sums at a time stay in registers."""
    for j in range(0, N, 8):
        s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = 0.0
        for k in range(N):
            value = values[k]
            s0 += CUMULATE[k, j] * value
            s1 += CUMULATE[k, j + 1] * value
            s2 += CUMULATE[k, j + 2] * value
            s3 += CUMULATE[k, j + 3] * value
            s4 += CUMULATE[k, j + 4] * value
            s5 += CUMULATE[k, j + 5] * value
            s6 += CUMULATE[k, j + 6] * value
            s7 += CUMULATE[k, j + 7] * value
        out[j] = s0
        out[j + 1] = s1
        out[j + 2] = s2
        out[j + 3] = s3
        out[j + 4] = s4
        out[j + 5] = s5
        out[j + 6] = s6
        out[j + 7] = s7


@jit
def _decay(exponents, out):
    """exp(-b): by its series, which vectorises, where every b is small."""
    large = 0
    for i in range(N):
        large += abs(exponents[i]) > 0.7
    if large > 0:
        for i in range(N):
            out[i] = np.exp(-exponents[i])
        return
    for i in range(N):
        x = -exponents[i]
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
        out[i] = 1.0 + x * y


@jit
def solve_side(row, side, rho, mu, load, scratch):
    """Solve the energy equation on a panel for one side of the slot."""
    block = block_of(side)
    twice = 2.0 * row[HALF]
    exponents = row[block + B : block + B + N]
    alphas = row[block + ALPHA : block + ALPHA + N]
    betas = row[block + BETA : block + BETA + N]
    rates, sources = scratch[:N], scratch[N : 2 * N]
    for k in range(N):
        g = row[G + k]
        c = side * mu * row[U + k]
        share = 1.0 / (1.0 + g * c * row[INVERSE + k])  # (rho + g^2) / J
        inverse_j = share * row[INVERSE + k]
        rates[k] = twice * c * rho * row[DG + k] * inverse_j * row[INVERSE + k]
        sources[k] = twice * ((1.0 - g * load) - c * (rho * load + g) * inverse_j)
        alphas[k] = share
    # J is a difference near the Painleve limit: finer panels cannot help below this
    noise = 1e-15 * (1.0 + whole(alphas, 0))
    _cumulate(rates, exponents)
    total = whole(rates, 0)
    _decay(exponents, alphas)
    for i in range(N):
        sources[i] /= alphas[i]
    _cumulate(sources, betas)
    source = whole(sources, 0)
    for i in range(N):
        betas[i] *= alphas[i]
    largest = max(abs(betas[N - 1]), abs(betas[N // 2]))
    alpha = np.exp(-total)
    row[block + RIGHT] = alpha
    row[block + RIGHT + 1] = alpha * source
    row[block + RIGHT + 2] = total
    tail = tail_of(alphas, 0) / max(1.0, alpha)
    tail = max(tail, tail_of(betas, 0) / max(largest, 1e-300))
    tail = max(tail, tail_of(row, INVERSE) / max(row[INVERSE], row[INVERSE + N - 1]))
    noise *= max(1.0, abs(total))
    row[block + NOISE] = noise
    if tail < noise:
        tail = 0.0
    if not tail < 1.0 or abs(total) > 20.0:
        tail = 1.0
    row[block + TAIL] = tail


@jit
def halve(store, panel, path, rho, count):
    """Split a panel in two; returns the new number of panels.

    The left half keeps the row, the right half gets row `count` and the place
    behind it in the chain.
    """
    row = store[panel]
    left = row[LEFT]
    middle = left + row[HALF]
    right = left + 2.0 * row[HALF]
    following = row[NEXT]
    # a break of the mechanism keeps its exact angle
    if following >= 0.0:
        right = store[int(following), LEFT]
    survey(row, path, rho, left, middle)
    survey(store[count], path, rho, middle, right)
    row[NEXT] = count
    store[count, NEXT] = following
    store[count, KINK] = 0.0
    return count + 1


@jit
def series(values, offset, out):
    """Legendre coefficients of N values from `offset` into out."""
    for k in range(N):
        out[k] = 0.0
    for i in range(N):
        value = values[offset + i]
        for k in range(N):
            out[k] += SPREAD[i, k] * value


@jit
def evaluate(coefficients, x):
    """A Legendre series and its derivative at x in [-1, 1]."""
    before, now = 1.0, x
    before_slope, slope = 0.0, 1.0
    value = coefficients[0] + coefficients[1] * x
    derivative = coefficients[1]
    for k in range(1, N - 1):
        after = UP[k] * x * now - DOWN[k] * before
        after_slope = before_slope + (2 * k + 1) * now
        before, now = now, after
        before_slope, slope = slope, after_slope
        value += coefficients[k + 1] * now
        derivative += coefficients[k + 1] * slope
    return value, derivative


@jit
def root_between(coefficients, low, high, value_low, value_high):
    """Root of a Legendre series in a bracket: Newton, kept in by bisection."""
    x = low + (high - low) * value_low / (value_low - value_high)
    for _ in range(60):
        value, slope = evaluate(coefficients, x)
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
def weights_to(x, values, partial):
    """Weights that interpolate at x, and that integrate from -1 to x."""
    for i in range(N):
        values[i] = BASIS[0, i]
        partial[i] = BASIS[0, i] * (1.0 + x)
    before, now = 1.0, x
    for k in range(1, N):
        after = UP[k] * x * now - DOWN[k] * before
        at = (2 * k + 1) * now
        integral = after - before
        for i in range(N):
            values[i] += at * BASIS[k, i]
            partial[i] += integral * BASIS[k, i]
        before, now = now, after
