"""Sixteen Gauss points on [-1, 1]: quadrature, Legendre series and their roots.

The functions take rows of N values, which are fields of a record. The `count` that some of
them take is N as the workspace of an engine gives it: the compiler unrolls a loop of known
length, and makes vector code from a loop of unknown length. `count & N` is 16 too, and tells the
compiler that the length is a multiple of the vector's.
"""

import numpy as np
from numpy.polynomial.legendre import leg2poly

from escapement.numerics.jit import inner_jit
from escapement.numerics.roots import newton_in_bracket

BLOCK = 16  # driver angles that are evaluated together

N = BLOCK

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(N)
LEGENDRE = np.polynomial.legendre.legvander(POINTS, N).T.copy()
"""Legendre polynomials 0..N (rows) at the points."""
_ORDERS = np.arange(N)
TRANSFORM = ((2 * _ORDERS + 1) / 2.0)[:, None] * LEGENDRE[:N] * WEIGHTS
"""Each row gives one Legendre coefficient from the values at the points."""
LAST_COEFFICIENT, LAST_BUT_ONE_COEFFICIENT = TRANSFORM[N - 1].copy(), TRANSFORM[N - 2].copy()
POWERS = (
    np.array([np.resize(np.append(leg2poly(row), np.zeros(N)), N) for row in np.eye(N)]).T
    @ TRANSFORM
).T.copy()
"""POWERS[k, i]: weight of the value at point k in coefficient i of a power series.

Such a series loses a few digits of the function, which is good enough to find its roots.
"""
SERIES = 0.7
"""Greatest |b| for which `exponentials` is accurate to rounding."""
BARYCENTRIC = np.sqrt((1.0 - POINTS**2) * WEIGHTS) * (-1.0) ** _ORDERS
"""Weights of the barycentric formula at the points."""
FROM_LEFT = 1.0 / (1.0 + POINTS)
"""Inverse distance of each point from the left end."""


def _integrated(x: np.ndarray) -> np.ndarray:
    """Integral of each Legendre polynomial from -1 to x, shape (N, x.size)."""
    # int P_n = (P_(n+1) - P_(n-1))/(2n + 1), and int P_0 = x + 1
    values = np.polynomial.legendre.legvander(x, N + 1).T
    upper = np.vstack([values[1:2] - 1.0 + 2.0, values[2 : N + 1] - values[: N - 1]])
    return upper / np.maximum(2 * _ORDERS + 1, 1)[:, None]


CUMULATE = (_integrated(POINTS).T @ TRANSFORM).T.copy()
"""CUMULATE[k, i]: weight of the value at point k in the integral to point i."""


def _product_with(m):
    """Make a kernel for out[i] = sum over k of m[k, i] values[k] that becomes vector code.

    The matrix is a constant of the kernel. If it were an argument, the compiler would have to
    assume that writing to `out` may change it, and could not compute several i at once.
    """

    @inner_jit(merged=True)
    def product(values, out):
        # all values are read first: after a write to `out`, which the compiler must assume to
        # overlap them, they would be read again in every turn
        c0, c1, c2, c3 = values[0], values[1], values[2], values[3]
        c4, c5, c6, c7 = values[4], values[5], values[6], values[7]
        d0, d1, d2, d3 = values[8], values[9], values[10], values[11]
        d4, d5, d6, d7 = values[12], values[13], values[14], values[15]
        for i in range(N):
            low = (m[0, i] * c0 + m[1, i] * c1) + (m[2, i] * c2 + m[3, i] * c3)
            low += (m[4, i] * c4 + m[5, i] * c5) + (m[6, i] * c6 + m[7, i] * c7)
            high = (m[8, i] * d0 + m[9, i] * d1) + (m[10, i] * d2 + m[11, i] * d3)
            high += (m[12, i] * d4 + m[13, i] * d5) + (m[14, i] * d6 + m[15, i] * d7)
            out[i] = low + high

    return product


cumulate = _product_with(CUMULATE)
"""cumulate(values, out): integrals from the left end to every point."""
to_powers = _product_with(POWERS)
"""to_powers(values, out): coefficients of a power series."""


@inner_jit(reorders=True)
def tail_of(values, count):
    """The tail: sum of the sizes of the last two Legendre coefficients."""
    last = last_but_one = 0.0
    for i in range(count & N):
        last += LAST_COEFFICIENT[i] * values[i]
        last_but_one += LAST_BUT_ONE_COEFFICIENT[i] * values[i]
    return abs(last) + abs(last_but_one)


@inner_jit(reorders=True)
def integral(values, count):
    """Integral over [-1, 1]."""
    total = 0.0
    for i in range(count & N):
        total += WEIGHTS[i] * values[i]
    return total


@inner_jit(reorders=True)
def dot(a, b, count):
    """Sum of the products of two rows."""
    total = 0.0
    for i in range(count & N):
        total += a[i] * b[i]
    return total


@inner_jit(reorders=True)
def weights_to(work, x):
    """Fill the weights of the values at the points in the value at x.

    `work` is a workspace: a record with N as `points`, and rows for the weights.

    Those of `at_x` are for any function. Those of `from_left` are for one that is zero at
    x = -1, such as an integral from the left end, and keep its relative accuracy next to it.
    """
    total = 0.0
    for i in range(work.points & N):
        # barycentric formula; at a point itself a tiny distance gives that point all the weight
        distance = x - POINTS[i]
        weight = BARYCENTRIC[i] / (distance if distance != 0.0 else 1e-17)
        work.at_x[i] = weight
        total += weight
    scale = 1.0 / total
    for i in range(work.points & N):
        weight = work.at_x[i] * scale
        work.at_x[i] = weight
        # interpolate f(x)/(1 + x), and multiply by 1 + x
        work.from_left[i] = weight * FROM_LEFT[i] * (1.0 + x)


@inner_jit
def invert(work, target, whole_time):
    """x in [-1, 1] at the time `target` since the left end; leaves its weights in the workspace.

    `whole_time` is the time over the panel, `work.scratch` holds that to every point, and
    `work.slowness` its derivative by x.
    """
    count = work.points & N
    x = 2.0 * target / whole_time - 1.0
    low, high = -1.0, 1.0
    for _ in range(60):
        weights_to(work, x)
        # Newton's method on the time, whose derivative by x is dt/dx
        over = dot(work.from_left, work.scratch, count) - target
        slope = dot(work.at_x, work.slowness, count)
        guess, low, high = newton_in_bracket(x, over, slope, low, high, whole_time > 0.0)
        step = abs(guess - x)
        x = guess
        if step <= 1e-8:
            break
    weights_to(work, x)
    return x


@inner_jit
def first_change(values, sign, at_end):
    """Points x between which values first lose a sign; 2 for the second one if they keep it.

    `at_end` is the value at x = 1.
    """
    low = -1.0
    for i in range(N):
        if not sign * values[i] > 0.0:
            return low, POINTS[i]
        low = POINTS[i]
    return low, 2.0 if sign * at_end > 0.0 else 1.0


@inner_jit
def series_at(c, x):
    """Value of the power series with coefficients c."""
    value = 0.0
    for k in range(N - 1, -1, -1):
        value = value * x + c[k]
    return value


@inner_jit
def exponentials(b):
    """exp(-b) and exp(b) for |b| <= SERIES.

    The power series of cosh and sinh compile to vector code, which a call of exp does not.
    """
    # cosh b, in powers of y = b^2
    y = b * b
    z = y * y
    even = 1.0 + y * (1.0 / 2.0) + (1.0 / 24.0 + y * (1.0 / 720.0)) * z
    last = 1.0 / 40320.0 + y * (1.0 / 3628800.0)
    last += (1.0 / 479001600.0 + y * (1.0 / 87178291200.0)) * z
    even += last * (z * z)
    # sinh b / b, multiplied by b at the end
    odd = 1.0 + y * (1.0 / 6.0) + (1.0 / 120.0 + y * (1.0 / 5040.0)) * z
    last = 1.0 / 362880.0 + y * (1.0 / 39916800.0)
    last += (1.0 / 6227020800.0 + y * (1.0 / 1307674368000.0)) * z
    odd = (odd + last * (z * z)) * b
    return even - odd, even + odd


@inner_jit(merged=True)
def fill_decay(b, alpha, gain, count):
    """Fill alpha = exp(-b) at the points, and turn the gain A into A/alpha."""
    large = 0
    for i in range(count & N):
        large += abs(b[i]) > SERIES
    # the power series would lose digits at any point where |b| is large
    if large > 0:
        for i in range(N):
            alpha[i] = np.exp(-b[i])
            gain[i] /= alpha[i]
        return
    for i in range(count & N):
        falling, growing = exponentials(b[i])
        alpha[i] = falling
        gain[i] *= growing


@inner_jit
def root_between(c, x, low, high, rising):
    """Root of the power series with coefficients c in a bracket, from the guess x.

    Newton's method is kept inside the bracket by bisection. `rising` says whether the values
    go from negative to positive. The sums run in two halves, so that the processor need not
    wait for one term before it begins the next.

    Returns
    -------
    x, slope : the root, to about 1e-12, the rounding error of the series, and the slope there.
    """
    slope = 0.0
    for _ in range(60):
        # the value of the series at x
        y = x * x
        z = y * y
        first = c[0] + c[1] * x + (c[2] + c[3] * x) * y
        first += (c[4] + c[5] * x + (c[6] + c[7] * x) * y) * z
        second = c[8] + c[9] * x + (c[10] + c[11] * x) * y
        second += (c[12] + c[13] * x + (c[14] + c[15] * x) * y) * z
        value = first + second * (z * z)
        # its derivative at x
        first = c[1] + 2.0 * c[2] * x + (3.0 * c[3] + 4.0 * c[4] * x) * y
        first += (5.0 * c[5] + 6.0 * c[6] * x + (7.0 * c[7] + 8.0 * c[8] * x) * y) * z
        second = 9.0 * c[9] + 10.0 * c[10] * x + (11.0 * c[11] + 12.0 * c[12] * x) * y
        second += (13.0 * c[13] + 14.0 * c[14] * x + 15.0 * c[15] * y) * z
        slope = first + second * (z * z)
        guess, low, high = newton_in_bracket(x, value, slope, low, high, rising)
        step = abs(guess - x)
        x = guess
        # Newton's method squares the error, so the next step would be below rounding
        if step <= 1e-7:
            break
    return x, slope
