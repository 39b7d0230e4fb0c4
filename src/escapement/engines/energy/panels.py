"""Panels: an engagement cut into pieces on which the energy equation is solved.

Values live at 16 Gauss points. Integrals over a whole panel converge twice as
fast as interpolation inside it; a panel records the size of its last Legendre
coefficients and is halved when what is asked of it needs better.

Everything lies in one flat array, the store: first the scratch, then panel after
panel. Functions get the store and a place in it: views would take as long to make
as the sums they are made for.
"""

import numpy as np

from escapement.engines.energy.cells import AT_ENDS, AT_G
from escapement.engines.energy.gauss import POINTS, N, points_of, tail_of
from escapement.jit import jit
from escapement.mechanisms.slotted import PLACES, transmission_at, transmission_on
from escapement.mechanisms.table import is_table

# scratch: what two sides of a reversal differ by; w, time by x, contact, acceleration and
# energy at the points; a power series, or times since the left end; weights that interpolate
# to x, and that do so for what vanishes at the left end; a panel's two sources and its
# solution while it is being solved
WORK = np.int64(0)  # int64 as any place: for a plain constant numba compiles its users anew
W, F, C, A, E, K, V, Q = (WORK + 2 * N + N * i for i in range(8))
DECAY, GAIN, SOLVED = (WORK + N * i for i in (10, 11, 12))
START = WORK + 16 * N  # the panel a motion starts in, over the square root of the angle
PANELS = START

# geometry of a panel. NEXT: panel to its right, or -1. KINK: whether its left end is a
# break of the mechanism. INTERVAL, CELL: where the mechanism's cells have it. SHARP: size of
# the last coefficients of INVERSE, 1/(rho + g^2), relative. STEP: driver angle by x at the
# points, ENDS: g, |u|, g' at the left end, then at the right end
LEFT, HALF, NEXT, KINK, INTERVAL, CELL, SHARP = range(7)
G, U, DG, INVERSE, STEP = (WORK + 8 + N * i for i in range(5))
ENDS = WORK + 8 + 5 * N
# its solution for either side: alpha, beta, b = int B at the points, then the three at the
# right end, the size of the last coefficients (UNBUILT: not solved) and the rounding in them
FORWARD, BACKWARD = 8 * (ENDS // 8 + 1), 8 * (ENDS // 8 + 1) + 56
ALPHA, BETA, B, RIGHT, TAIL, NOISE = 0, N, 2 * N, 3 * N, 3 * N + 3, 3 * N + 4
SIZE = BACKWARD + 56
UNBUILT = -1.0
HEAD, MAX_PANELS = np.int64(0), np.int64(2048)
NO_PANELS = np.int64(0)  # have been laid out yet
MANY = 128  # more than one engagement needs
COARSE = 0.1  # of the tail allowed: what is solved for is rougher than its coefficients
SMALLEST = 1e-13  # of a radian: no panel is halved below this


@jit(allocates=True)
def new_store(most):
    """An empty store for `most` panels, its size N more than a multiple of 2 N.

    Untouched memory costs nothing.
    """
    return np.empty((place_of(most) // (2 * N) + 1) * 2 * N + N)


@jit
def place_of(panel):
    """Where a panel of the chain begins in the store."""
    return (PANELS + (1 + panel) * SIZE) & PLACES


@jit
def solution_of(at, side):
    """Where a panel's solution for a side of the slot begins."""
    return (at + (FORWARD if side > 0.0 else BACKWARD)) & PLACES


@jit
def at_gauss_points(s):
    """Have `survey` fill an ordinary panel."""
    for i in range(N):
        s[K + i] = POINTS[i]


@jit
def survey(s, at, path, rho, left, right):
    """Fill a panel's geometry at the points that the scratch holds in K, from -1 to 1."""
    at &= PLACES
    half = 0.5 * (right - left)
    s[at + LEFT] = left
    s[at + HALF] = half
    transmission_on(path, left, half, s, K, at + G)
    g, u, dg = transmission_at(path, left)
    s[at + ENDS], s[at + ENDS + 1], s[at + ENDS + 2] = g, abs(u), dg
    g, u, dg = transmission_at(path, right)
    s[at + ENDS + 3], s[at + ENDS + 4], s[at + ENDS + 5] = g, abs(u), dg
    complete(s, at, rho)


@jit
def recall(s, at, path, cells, rho, left, right):
    """Fill a panel's geometry from the mechanism's cells where they have it."""
    at &= PLACES
    if s[at + CELL] >= cells.shape[1]:
        at_gauss_points(s)
        survey(s, at, path, rho, left, right)
        return
    cell = int(s[at + CELL]) & PLACES
    interval = int(s[at + INTERVAL]) & PLACES
    s[at + LEFT] = left
    s[at + HALF] = 0.5 * (right - left)
    for i in range(3 * points_of(s)):
        s[at + G + i] = cells[interval, cell, AT_G + i]
    for i in range(6):
        s[at + ENDS + i] = cells[interval, cell, AT_ENDS + i]
    complete(s, at, rho)


@jit
def complete(s, at, rho):
    """Fill what follows from a panel's transmission and half width; it is not solved yet."""
    at &= PLACES
    half = s[at + HALF]
    for i in range(points_of(s)):
        s[at + INVERSE + i] = 1.0 / (rho + s[at + G + i] * s[at + G + i])
        s[at + STEP + i] = half
    largest = max(s[at + INVERSE], s[at + INVERSE + N - 1])
    s[at + SHARP] = tail_of(s, at + INVERSE) / largest
    s[at + FORWARD + TAIL] = UNBUILT
    s[at + BACKWARD + TAIL] = UNBUILT


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
        # a corner of a table is none of the friction in a slot
        s[at + KINK] = 1.0 if k > 0 and not is_table(path) else 0.0
        s[at + INTERVAL], s[at + CELL] = k, 1.0
        recall(s, at, path, cells, rho, breaks[k], breaks[k + 1])
    count = intervals
    following = 0.0
    while following >= 0.0:
        panel = int(following)
        at = place_of(panel)
        while s[at + SHARP] > COARSE * loose and count < MAX_PANELS // 8:
            count = halve(s, panel, path, cells, rho, count)
        following = s[at + NEXT]
    return count


@jit
def tolerances(rtol):
    """Tails allowed in panels for a relative error: whole panel, and inside.

    Measured on random scenes the error is at most a hundredth of the square of
    the first and a twentieth of the second. Beyond 1e-8 that no longer holds of every
    scene, and next to nothing would be saved.
    """
    rtol = min(rtol, 1e-8)
    return 3.0 * np.sqrt(rtol), max(15.0 * rtol, 1e-14)
