"""A start from rest, and a stop: what happens where there is next to no speed."""

import numpy as np

from escapement.dynamics import bend
from escapement.engines.energy.gauss import POINTS, N, points_of
from escapement.engines.energy.panels import (
    ENDS,
    HALF,
    LEFT,
    SHARP,
    START,
    STEP,
    TAIL,
    C,
    G,
    K,
    V,
    complete,
    solution_of,
)
from escapement.engines.energy.sampling import LEFT_END, rate_at_end
from escapement.engines.energy.solve import solve_side
from escapement.jit import jit
from escapement.mechanisms.slotted import transmission_on


@jit
def braking(s, at, side, w, rho, mu, load):
    """Slope of w by driver angle at the left end."""
    g = s[at + ENDS]
    j = rho + g * (g + bend(side, mu) * s[at + ENDS + 1])
    return 2.0 * rate_at_end(s, at, LEFT_END, side, w, mu, load) / j


@jit
def start_slowly(s, at, path, rho, way):
    """Fill the start's panel: that at `at`, over the square root of the angle.

    From rest w grows like the angle, and 1/sqrt(w) is singular; over
    y = sqrt(way + (theta - left)/length), with the speed zero at y = 0, neither is.
    `way` is how far before the left end that lies, in lengths of the panel.
    """
    left, half = s[at + LEFT], s[at + HALF]
    first, last = np.sqrt(way), np.sqrt(1.0 + way)
    for i in range(N):
        y = 0.5 * ((last + first) + (last - first) * POINTS[i])
        s[K + i] = 2.0 * (y * y - way) - 1.0
        s[V + i] = 2.0 * half * (last - first) * y
    transmission_on(path, left, half, s, K, START + G)
    for i in range(6):
        s[START + ENDS + i] = s[at + ENDS + i]
    s[START + LEFT], s[START + HALF] = left, half
    complete(s, START, rho)
    for i in range(N):
        s[START + STEP + i] = s[V + i]


@jit
def begin(s, at, side, path, rho, mu, load, w, strict):
    """Solve the start's panel over that at `at`; returns where the panel to be passed lies."""
    slope = braking(s, at, side, w, rho, mu, load)
    if not slope > 0.0:
        return at
    if s[at + SHARP] > strict:
        # over the square root of the angle it would be rougher still
        s[solution_of(at, side) + TAIL] = 1.0
        return at
    start_slowly(s, at, path, rho, w / (2.0 * slope * s[at + HALF]))
    tail = solution_of(START, side) + TAIL
    s[tail] = s[START + SHARP]
    if s[tail] <= strict:
        solve_side(s, START, side, rho, mu, load)
    return START


@jit
def clearly_against(s):
    """Points where the other side carries a force beyond rounding.

    Next to the stop of a mesh, known from a table, g and g' are rounding errors.
    """
    largest = 0.0
    for i in range(points_of(s)):
        largest = max(largest, s[C + i])
    count = 0
    for i in range(N):
        count += s[C + i] < -1e-9 * largest
    return count
