"""Panels: an engagement cut into pieces on which the energy equation is solved.

Twice the kinetic energy, E = (rho + g^2) w, obeys on a panel with side s

    E' = A - B E,   c = p - g,   J = rho + g^2 + g c,
    A = 2 (1 - g load) - 2 c (rho load + g)/J,   B = 2 c rho g'/(J (rho + g^2)),

so E = alpha E_left + beta with alpha = exp(-int B), beta = alpha int A/alpha:
two quadratures, whatever the energy at the left end. B vanishes without a loss,
so nothing is lost by cancellation in the frictionless limit.

Values live at 16 Gauss points. Integrals over a whole panel converge twice as
fast as interpolation inside it; a panel records the size of its last Legendre
coefficients and is halved when what is asked of it needs better.

Everything lies in one flat array, the store: first the scratch, then panel after
panel. Functions get the store and a place in it: views would take as long to make
as the sums they are made for.
"""

import numpy as np

from escapement._jit import jit
from escapement.dynamics import bend
from escapement.engines._cells import AT_ENDS, AT_G, CELLS
from escapement.engines._gauss import CUMULATE, LAST, LAST_BUT_ONE, POINTS, WEIGHTS, N, combine
from escapement.mechanisms._slotted import PLACES, transmission_at, transmission_on

# scratch: interpolation weights in the making; w, time by x, contact, acceleration and
# energy at the points; Legendre coefficients; weights that interpolate, and that integrate,
# to x; a panel's two sources and its solution while it is being solved
WORK = 0
W, F, C, A, E, K, V, Q = (2 * N + N * i for i in range(8))
DECAY, GAIN, SOLVED = 10 * N, 11 * N, 12 * N
START = 16 * N  # the panel a motion starts in, over the square root of the angle
PANELS = START

# geometry of a panel. NEXT: panel to its right, or -1. KINK: whether its left end is a
# break of the mechanism. INTERVAL, CELL: where the mechanism's cells have it. STEP: driver
# angle by x at the points, ENDS: g, |u|, g' at the left end, then at the right end
LEFT, HALF, NEXT, KINK, INTERVAL, CELL = range(6)
G, U, DG, INVERSE, STEP = (8 + N * i for i in range(5))
ENDS = 8 + 5 * N
# its solution for either side: alpha, beta, b = int B at the points, then the three at the
# right end, the size of the last coefficients (UNBUILT: not solved) and the rounding in them
FORWARD, BACKWARD = 8 * (ENDS // 8 + 1), 8 * (ENDS // 8 + 1) + 56
ALPHA, BETA, B, RIGHT, TAIL, NOISE = 0, N, 2 * N, 3 * N, 3 * N + 3, 3 * N + 4
SIZE = BACKWARD + 56
UNBUILT = -1.0
MAX_PANELS = 2048
COARSE = 0.1  # of the tail allowed: what is solved for is rougher than its coefficients
SMALLEST = 1e-13  # of a radian: no panel is halved below this


@jit(allocates=True)
def new_store():
    """An empty store; untouched memory costs nothing."""
    return np.empty(PANELS + (1 + MAX_PANELS) * SIZE)


@jit
def place_of(panel):
    """Where a panel of the chain begins in the store."""
    return PANELS + (1 + panel) * SIZE


@jit
def solution_of(at, side):
    """Where a panel's solution for a side of the slot begins."""
    return at + (FORWARD if side > 0.0 else BACKWARD)


@jit
def survey(s, at, path, rho, left, right, points, first):
    """Fill a panel's geometry at middle + half * points[first:first + 16]."""
    at &= PLACES
    half = 0.5 * (right - left)
    s[at + LEFT] = left
    s[at + HALF] = half
    middle = 0.5 * (right + left)
    transmission_on(path, middle, half, points, first, s, at + G)
    g, u, dg = transmission_at(path, left)
    s[at + ENDS], s[at + ENDS + 1], s[at + ENDS + 2] = g, abs(u), dg
    g, u, dg = transmission_at(path, right)
    s[at + ENDS + 3], s[at + ENDS + 4], s[at + ENDS + 5] = g, abs(u), dg
    _complete(s, at, rho)


@jit
def recall(s, at, path, cells, rho, left, right):
    """Fill a panel's geometry from the mechanism's cells where they have it."""
    at &= PLACES
    if s[at + CELL] >= CELLS:
        survey(s, at, path, rho, left, right, POINTS, 0)
        return
    cell = int(s[at + CELL]) & PLACES
    interval = int(s[at + INTERVAL]) & PLACES
    s[at + LEFT] = left
    s[at + HALF] = 0.5 * (right - left)
    for i in range(3 * N):
        s[at + G + i] = cells[interval, cell, AT_G + i]
    for i in range(6):
        s[at + ENDS + i] = cells[interval, cell, AT_ENDS + i]
    _complete(s, at, rho)


@jit
def _complete(s, at, rho):
    at &= PLACES
    half = s[at + HALF]
    for i in range(N):
        s[at + INVERSE + i] = 1.0 / (rho + s[at + G + i] * s[at + G + i])
        s[at + STEP + i] = half
    s[at + FORWARD + TAIL] = UNBUILT
    s[at + BACKWARD + TAIL] = UNBUILT


@jit
def tail_of(s, at):
    """Size of the last two Legendre coefficients of N values."""
    at &= PLACES
    a = b = c = d = 0.0
    for i in range(0, N, 2):
        a += LAST[i] * s[at + i]
        b += LAST_BUT_ONE[i] * s[at + i]
        c += LAST[i + 1] * s[at + i + 1]
        d += LAST_BUT_ONE[i + 1] * s[at + i + 1]
    return abs(a + c) + abs(b + d)


@jit
def whole(s, at):
    """Integral over [-1, 1] of N values."""
    at &= PLACES
    a = b = c = d = 0.0
    for i in range(0, N, 4):
        a += WEIGHTS[i] * s[at + i]
        b += WEIGHTS[i + 1] * s[at + i + 1]
        c += WEIGHTS[i + 2] * s[at + i + 2]
        d += WEIGHTS[i + 3] * s[at + i + 3]
    return (a + b) + (c + d)


@jit
def _falling(b):
    """exp(-b) for |b| <= 0.7, by its series: vector code, two terms at a time."""
    x = -b
    y = x * x
    z = y * y
    c0 = 1.0 + x + (1.0 / 2.0 + x * (1.0 / 6.0)) * y
    c1 = 1.0 / 24.0 + x * (1.0 / 120.0) + (1.0 / 720.0 + x * (1.0 / 5040.0)) * y
    c2 = 1.0 / 40320.0 + x * (1.0 / 362880.0)
    c2 += (1.0 / 3628800.0 + x * (1.0 / 39916800.0)) * y
    c3 = 1.0 / 479001600.0 + x * (1.0 / 6227020800.0)
    c3 += (1.0 / 87178291200.0 + x * (1.0 / 1307674368000.0)) * y
    return c0 + (c1 + (c2 + c3 * z) * z) * z


@jit
def _decay(s):
    """alpha = exp(-b) at the points, in the scratch."""
    large = 0
    for i in range(N):
        large += abs(s[SOLVED + B + i]) > 0.7
    if large > 0:
        for i in range(N):
            s[SOLVED + ALPHA + i] = np.exp(-s[SOLVED + B + i])
        return
    for i in range(N):
        s[SOLVED + ALPHA + i] = _falling(s[SOLVED + B + i])


@jit
def solve_side(s, at, side, rho, mu, load):
    """Solve the energy equation on a panel for one side of the slot."""
    at &= PLACES
    lost = bend(side, mu)
    for k in range(N):
        g = s[at + G + k]
        inverse = s[at + INVERSE + k]
        c = lost * s[at + U + k]
        share = 1.0 / (1.0 + g * c * inverse)  # (rho + g^2) / J
        twice = 2.0 * s[at + STEP + k]
        s[DECAY + k] = twice * c * rho * s[at + DG + k] * share * inverse * inverse
        s[GAIN + k] = twice * ((1.0 - g * load) - c * (rho * load + g) * share * inverse)
        s[SOLVED + BETA + k] = share
    # J is a difference near the Painleve limit: finer panels cannot help below this
    noise = 1e-15 * (1.0 + whole(s, SOLVED + BETA))
    total = whole(s, DECAY)
    combine(CUMULATE, s, DECAY, SOLVED + B)
    _decay(s)
    for i in range(N):
        s[GAIN + i] /= s[SOLVED + ALPHA + i]
    source = whole(s, GAIN)
    combine(CUMULATE, s, GAIN, SOLVED + BETA)
    for i in range(N):
        s[SOLVED + BETA + i] *= s[SOLVED + ALPHA + i]
    largest = max(abs(s[SOLVED + BETA + N - 1]), abs(s[SOLVED + BETA + N // 2]))
    alpha = _falling(total) if abs(total) <= 0.7 else np.exp(-total)
    tail = tail_of(s, SOLVED + ALPHA) / max(1.0, alpha)
    tail = max(tail, tail_of(s, SOLVED + BETA) / max(largest, 1e-300))
    tail = max(tail, tail_of_inverse(s, at))
    noise *= max(1.0, abs(total))
    if tail < noise:
        tail = 0.0
    if not tail < 1.0 or abs(total) > 20.0:
        tail = 1.0
    to = solution_of(at, side) & PLACES
    for i in range(3 * N):
        s[to + i] = s[SOLVED + i]
    s[to + RIGHT], s[to + RIGHT + 1], s[to + RIGHT + 2] = alpha, alpha * source, total
    s[to + TAIL], s[to + NOISE] = tail, noise


@jit
def tail_of_inverse(s, at):
    """Relative size of the last coefficients of 1/(rho + g^2)."""
    return tail_of(s, at + INVERSE) / max(s[at + INVERSE], s[at + INVERSE + N - 1])


@jit
def halve(s, panel, path, cells, rho, count):
    """Split a panel in two; returns the new number of panels.

    The left half keeps the place, the right half gets place `count` and follows it
    in the chain.
    """
    at, new = place_of(panel), place_of(count)
    left = s[at + LEFT]
    middle = left + s[at + HALF]
    right = left + 2.0 * s[at + HALF]
    following = s[at + NEXT]
    # a break of the mechanism keeps its exact angle
    if following >= 0.0:
        right = s[place_of(int(following)) + LEFT]
    s[new + INTERVAL] = s[at + INTERVAL]
    s[new + CELL] = 2.0 * s[at + CELL] + 1.0
    s[at + CELL] = 2.0 * s[at + CELL]
    recall(s, at, path, cells, rho, left, middle)
    recall(s, new, path, cells, rho, middle, right)
    s[at + NEXT] = count
    s[new + NEXT] = following
    s[new + KINK] = 0.0
    return count + 1


@jit
def lay_out(s, path, breaks, cells, rho, loose):
    """First panels of an engagement, fine enough for its geometry; returns their number."""
    intervals = breaks.size - 1
    for k in range(intervals):
        at = place_of(k)
        s[at + NEXT] = k + 1.0 if k + 1 < intervals else -1.0
        s[at + KINK] = 1.0 if k > 0 else 0.0
        s[at + INTERVAL], s[at + CELL] = k, 1.0
        recall(s, at, path, cells, rho, breaks[k], breaks[k + 1])
    count = intervals
    panel = 0
    while panel >= 0:
        at = place_of(panel)
        while tail_of_inverse(s, at) > COARSE * loose and count < MAX_PANELS // 8:
            count = halve(s, panel, path, cells, rho, count)
        panel = int(s[at + NEXT])
    return count
