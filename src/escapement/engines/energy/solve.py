"""The energy equation solved on a panel, for one side of the slot.

Twice the kinetic energy, E = (rho + g^2) w, obeys on a panel with side s

    E' = A - B E,   c = p - g,   J = rho + g^2 + g c,
    A = 2 (1 - g load) - 2 c (rho load + g)/J,   B = 2 c rho g'/(J (rho + g^2)),

so E = alpha E_left + beta with alpha = exp(-int B), beta = alpha int A/alpha:
two quadratures, whatever the energy at the left end. B vanishes without a loss,
so nothing is lost by cancellation in the frictionless limit.
"""

import numpy as np

from escapement.dynamics import bend
from escapement.engines.energy.gauss import N, cumulate, points_of, tail_of, whole
from escapement.engines.energy.panels import (
    ALPHA,
    BETA,
    DECAY,
    DG,
    GAIN,
    INVERSE,
    NOISE,
    RIGHT,
    SHARP,
    SOLVED,
    STEP,
    TAIL,
    B,
    G,
    U,
    solution_of,
)
from escapement.jit import jit
from escapement.mechanisms.slotted import PLACES

LEAST = 1e-9  # of |u| g' by angle: less is lost next to a stop, or is a table's rounding


@jit
def _exponentials(b):
    """exp(-b) and exp(b) for |b| <= 0.7, by their series: vector code."""
    y = b * b
    z = y * y
    even = 1.0 + y * (1.0 / 2.0) + (1.0 / 24.0 + y * (1.0 / 720.0)) * z
    last = 1.0 / 40320.0 + y * (1.0 / 3628800.0)
    last += (1.0 / 479001600.0 + y * (1.0 / 87178291200.0)) * z
    even += last * (z * z)
    odd = 1.0 + y * (1.0 / 6.0) + (1.0 / 120.0 + y * (1.0 / 5040.0)) * z
    last = 1.0 / 362880.0 + y * (1.0 / 39916800.0)
    last += (1.0 / 6227020800.0 + y * (1.0 / 1307674368000.0)) * z
    odd = (odd + last * (z * z)) * b
    return even - odd, even + odd


@jit
def _decay(s):
    """alpha = exp(-b) at the points and, in the gain, what is gained over alpha."""
    large = 0
    for i in range(points_of(s)):
        large += abs(s[SOLVED + B + i]) > 0.7
    if large > 0:
        for i in range(N):
            s[SOLVED + ALPHA + i] = np.exp(-s[SOLVED + B + i])
            s[GAIN + i] /= s[SOLVED + ALPHA + i]
        return
    for i in range(points_of(s)):
        falling, growing = _exponentials(s[SOLVED + B + i])
        s[SOLVED + ALPHA + i] = falling
        s[GAIN + i] *= growing


@jit
def solve_side(s, at, side, rho, mu, load):
    """Solve the energy equation on a panel for one side of the slot."""
    at &= PLACES
    loss = bend(side, mu)
    for k in range(points_of(s)):
        g = s[at + G + k]
        inverse = s[at + INVERSE + k]
        c = loss * s[at + U + k]
        share = 1.0 / (1.0 + g * c * inverse)  # (rho + g^2) / J
        twice = 2.0 * s[at + STEP + k]
        s[DECAY + k] = twice * c * rho * s[at + DG + k] * share * inverse * inverse
        s[GAIN + k] = twice * ((1.0 - g * load) - c * (rho * load + g) * share * inverse)
        s[SOLVED + BETA + k] = share
    # J is a difference near the Painleve limit: finer panels cannot help below this
    noise = 1e-15 * (1.0 + whole(s, SOLVED + BETA))
    total = whole(s, DECAY)
    cumulate(s, DECAY, SOLVED + B)
    _decay(s)
    source = whole(s, GAIN)
    cumulate(s, GAIN, SOLVED + BETA)
    for i in range(points_of(s)):
        s[SOLVED + BETA + i] *= s[SOLVED + ALPHA + i]
    largest = max(abs(s[SOLVED + BETA + N - 1]), abs(s[SOLVED + BETA + N // 2]))
    alpha = _exponentials(total)[0] if abs(total) <= 0.7 else np.exp(-total)
    # next to a cycle that hardly loses, what is lost has to be accurate by itself
    lost = max(abs(total), max(abs(s[SOLVED + B + N // 2]), abs(s[SOLVED + B + N - 1])))
    lost = max(lost, LEAST * abs(loss) * rho * s[at + INVERSE + N // 2] ** 2)
    tail = tail_of(s, SOLVED + B) / max(lost, 1e-300)
    tail = max(tail, tail_of(s, SOLVED + ALPHA) / max(1.0, alpha))
    tail = max(tail, tail_of(s, SOLVED + BETA) / max(largest, 1e-300))
    tail = max(tail, s[at + SHARP])
    noise *= max(1.0, abs(total))
    if tail < noise:
        tail = 0.0
    if not tail < 1.0 or abs(total) > 20.0:
        tail = 1.0
    to = solution_of(at, side)
    for i in range(3 * points_of(s)):
        s[to + i] = s[SOLVED + i]
    s[to + RIGHT], s[to + RIGHT + 1], s[to + RIGHT + 2] = alpha, alpha * source, total
    s[to + TAIL], s[to + NOISE] = tail, noise
