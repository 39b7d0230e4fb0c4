"""Sixteen Gauss points: quadrature, Legendre series and their roots.

Numbers are taken from, and put into, a flat array from a given place on.
"""

import numpy as np
from numpy.polynomial.legendre import leg2poly

from escapement.jit import jit
from escapement.mechanisms.slotted import BLOCK, PLACES

N = BLOCK

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(N)
LEGENDRE = np.polynomial.legendre.legvander(POINTS, N).T.copy()
"""Legendre polynomials 0..N (rows) at the points."""
_ORDERS = np.arange(N)
TRANSFORM = ((2 * _ORDERS + 1) / 2.0)[:, None] * LEGENDRE[:N] * WEIGHTS
"""Values at the points to Legendre coefficients (rows)."""
LAST, LAST_BUT_ONE = TRANSFORM[N - 1].copy(), TRANSFORM[N - 2].copy()
POWERS = (
    np.array([np.resize(np.append(leg2poly(row), np.zeros(N)), N) for row in np.eye(N)]).T
    @ TRANSFORM
).T.copy()
"""What each value adds to the coefficients of a power series; good enough for a root."""
BARYCENTRIC = np.sqrt((1.0 - POINTS**2) * WEIGHTS) * (-1.0) ** _ORDERS
"""Weights of the barycentric formula at the points."""
FROM_LEFT = 1.0 / (1.0 + POINTS)


def _integrated(x: np.ndarray) -> np.ndarray:
    """Integral of each Legendre polynomial from -1 to x, shape (N, x.size)."""
    values = np.polynomial.legendre.legvander(x, N + 1).T
    upper = np.vstack([values[1:2] - 1.0 + 2.0, values[2 : N + 1] - values[: N - 1]])
    return upper / np.maximum(2 * _ORDERS + 1, 1)[:, None]


CUMULATE = (_integrated(POINTS).T @ TRANSFORM).T.copy()
"""CUMULATE[k, i]: weight of the value at point k in the integral to point i."""


@jit
def points_of(s):
    """N, unknown to the compiler.

    A loop over the points that it knows the length of it unrolls; of this one it makes
    vector code. The size of a store has the bit set (`new_store`).
    """
    return s.size & N


def _product_with(m):
    """Kernel for s[to + i] = sum over k of m[k, i] s[at + k], as vector code.

    The matrix is a constant of the kernel's: of an argument it could not be known
    that writing to s leaves it as it is.
    """

    @jit
    def product(s, at, to):
        at &= PLACES
        to &= PLACES
        c0, c1, c2, c3 = s[at], s[at + 1], s[at + 2], s[at + 3]
        c4, c5, c6, c7 = s[at + 4], s[at + 5], s[at + 6], s[at + 7]
        d0, d1, d2, d3 = s[at + 8], s[at + 9], s[at + 10], s[at + 11]
        d4, d5, d6, d7 = s[at + 12], s[at + 13], s[at + 14], s[at + 15]
        for i in range(N):
            low = (m[0, i] * c0 + m[1, i] * c1) + (m[2, i] * c2 + m[3, i] * c3)
            low += (m[4, i] * c4 + m[5, i] * c5) + (m[6, i] * c6 + m[7, i] * c7)
            high = (m[8, i] * d0 + m[9, i] * d1) + (m[10, i] * d2 + m[11, i] * d3)
            high += (m[12, i] * d4 + m[13, i] * d5) + (m[14, i] * d6 + m[15, i] * d7)
            s[to + i] = low + high

    return product


cumulate = _product_with(CUMULATE)
"""cumulate(s, at, to): integrals from the left end to every point."""
to_powers = _product_with(POWERS)
"""to_powers(s, at, to): coefficients of a power series."""


@jit(reorders=True)
def tail_of(s, at):
    """Size of the last two Legendre coefficients of N values."""
    at &= PLACES
    last = last_but_one = 0.0
    for i in range(points_of(s)):
        last += LAST[i] * s[at + i]
        last_but_one += LAST_BUT_ONE[i] * s[at + i]
    return abs(last) + abs(last_but_one)


@jit(reorders=True)
def whole(s, at):
    """Integral over [-1, 1] of N values."""
    at &= PLACES
    total = 0.0
    for i in range(points_of(s)):
        total += WEIGHTS[i] * s[at + i]
    return total


@jit(reorders=True)
def dot(s, at, to):
    """Sum of the products of two rows of N values."""
    at &= PLACES
    to &= PLACES
    total = 0.0
    for i in range(points_of(s)):
        total += s[at + i] * s[to + i]
    return total


@jit
def root_between(s, at, x, low, high, rising):
    """Root of a power series in a bracket, from a guess: Newton, kept in by bisection.

    Parameters
    ----------
    at : place of the N coefficients.
    rising : whether the values go from negative to positive.

    Two terms at a time, so that the processor need not wait for one before the next.

    Returns
    -------
    x, slope : the root, to some 1e-12 for a power series' rounding, and the slope there.
    """
    at &= PLACES
    slope = 0.0
    for _ in range(60):
        y = x * x
        z = y * y
        c0, c1, c2, c3 = s[at], s[at + 1], s[at + 2], s[at + 3]
        c4, c5, c6, c7 = s[at + 4], s[at + 5], s[at + 6], s[at + 7]
        d0, d1, d2, d3 = s[at + 8], s[at + 9], s[at + 10], s[at + 11]
        d4, d5, d6, d7 = s[at + 12], s[at + 13], s[at + 14], s[at + 15]
        first = (c0 + c1 * x + (c2 + c3 * x) * y) + (c4 + c5 * x + (c6 + c7 * x) * y) * z
        second = (d0 + d1 * x + (d2 + d3 * x) * y) + (d4 + d5 * x + (d6 + d7 * x) * y) * z
        value = first + second * (z * z)
        first = c1 + 2.0 * c2 * x + (3.0 * c3 + 4.0 * c4 * x) * y
        first += (5.0 * c5 + 6.0 * c6 * x + (7.0 * c7 + 8.0 * d0 * x) * y) * z
        second = 9.0 * d1 + 10.0 * d2 * x + (11.0 * d3 + 12.0 * d4 * x) * y
        second += (13.0 * d5 + 14.0 * d6 * x + 15.0 * d7 * y) * z
        slope = first + second * (z * z)
        if (value < 0.0) == rising:
            low = x
        else:
            high = x
        guess = x - value / slope
        if not low <= guess <= high:
            guess = 0.5 * (low + high)
        step = abs(guess - x)
        x = guess
        # Newton squares the error: the next step would be rounding
        if step <= 1e-7:
            break
    return x, slope
