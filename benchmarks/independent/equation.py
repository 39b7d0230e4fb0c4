"""The problem, and the power series of its equation of motion about an angle."""

import math
from typing import NamedTuple

import numpy as np

from .compiling import compiled
from .series import SIZE, inverse_root, product, quotient, reach, value


class Case(NamedTuple):
    """Dimensionless problem; `kind` is +1 for an external wheel, -1 for an internal one."""

    a: float
    beta: float
    dwell: float
    kind: float
    rho: float
    mu: float
    load: float


def case_of(slots, pins, internal, rho, mu, load):
    """Geometry of a Geneva wheel from its counts."""
    step, kind = math.pi / slots, -1.0 if internal else 1.0
    beta = math.pi / 2 - kind * step
    dwell = 2 * math.pi / pins - 2 * beta
    return Case(1 / math.sin(step), beta, dwell if dwell > 1e-12 else 0.0, kind, rho, mu, load)


@compiled
def transmission(a, kind, angle, unit, work):
    """Series of g, g' (by the angle) and u in units of `unit`; work is (6, SIZE)."""
    g, dg, u, square, top, tmp = work[0], work[1], work[2], work[3], work[4], work[5]
    half = math.sin(0.5 * angle)
    c, s = math.cos(angle), math.sin(angle)
    factor = 1.0
    for k in range(SIZE):
        if k == 0:
            cosine = c
        elif k % 4 == 1:
            cosine = -s
        elif k % 4 == 2:
            cosine = -c
        elif k % 4 == 3:
            cosine = s
        else:
            cosine = c
        # derivatives of the sine, as those of the cosine above
        if k % 4 == 0:
            sine = s
        elif k % 4 == 1:
            sine = c
        elif k % 4 == 2:
            sine = -s
        else:
            sine = -c
        square[k] = -2.0 * kind * a * cosine * factor
        top[k] = a * cosine * factor
        tmp[k] = kind * a * sine * factor  # half the derivative of the square
        factor *= unit / (k + 1)
    square[0] = (a - kind) ** 2 + kind * 4.0 * a * half * half
    top[0] = (a - kind) - 2.0 * a * half * half
    quotient(top, square, g)
    quotient(tmp, square, u)
    # C = c - kind e^(-i kind theta): g' = u (a + b - 2 g), computed from the quotient instead
    for k in range(SIZE - 1):
        dg[k] = (k + 1) * g[k + 1] / unit
    dg[SIZE - 1] = 0.0


@compiled
def expand(case, angle, half, sense, w0, unit, work):
    """Series about `angle` with W = w0 there; returns J and two valid lengths, in units of `unit`.

    half = +1 after dead centre, -1 before: the sign of theta. work rows: 0 g, 1 g',
    2 u, 6 c, 7 p, 8 J, 9 D, 10 W, 11 K, 12 W^(-1/2) (of W/x at rest), 13 l', 14 S'
    without its last term, 15.. scratch.
    """
    a, kind, rho, mu, load = case[0], case[3], case[4], case[5], case[6]
    transmission(a, kind, angle, unit, work)
    g, dg, u = work[0], work[1], work[2]
    c, p, j, d, w, contact = work[6], work[7], work[8], work[9], work[10], work[11]
    last = SIZE - 2  # g' is known one order less
    for k in range(SIZE):
        c[k] = sense * mu * half * kind * u[k]
        p[k] = g[k] + c[k]
    product(g, p, j)
    product(g, g, d)
    j[0] += rho
    d[0] += rho
    damping = work[15]
    product(p, dg, damping)
    w[0] = w0
    for k in range(SIZE - 1):
        r = -2.0 * load * p[k]
        if k == 0:
            r += 2.0
        for i in range(k + 1):
            r -= 2.0 * damping[i] * w[k - i]
        r *= unit
        for i in range(1, k + 1):
            r -= j[i] * (k + 1 - i) * w[k + 1 - i]
        w[k + 1] = r / (j[0] * (k + 1))
    product(dg, w, contact)
    for k in range(SIZE):
        contact[k] = rho * contact[k] + g[k]
    contact[0] += rho * load
    contact[SIZE - 1] = 0.0
    slow = work[12]
    slow[:] = 0.0
    if w0 > 0.0:
        inverse_root(w, SIZE, slow)
        far_slow = reach(slow, last)
    else:
        grown = work[16]
        sign = 1.0 if w[1] > 0.0 else -1.0
        for k in range(SIZE - 1):
            grown[k] = sign * w[k + 1]
        inverse_root(grown, SIZE - 1, slow)
        far_slow = reach(slow, last)
    both, inverse = work[17], work[18]
    product(j, d, both)
    work[16][:] = 0.0
    work[16][0] = 1.0
    quotient(work[16], both, inverse)
    far = min(reach(inverse, last), reach(g, last))
    grown_w = work[16]
    for k in range(SIZE - 1):
        grown_w[k] = w[k] if w0 > 0.0 else w[k + 1]
    far = min(far, reach(grown_w, last))
    product(c, dg, work[16])
    product(work[16], inverse, work[13])
    for k in range(SIZE):
        work[13][k] *= -2.0 * rho * unit
        work[16][k] = -load * p[k]
    work[16][0] += 1.0
    product(d, work[16], work[17])
    quotient(work[17], j, work[14])
    for k in range(SIZE):
        work[14][k] *= 2.0 * unit
    return j[0], far, far_slow


@compiled
def advance_source(work, h, s):
    """S after a step: S' = forcing + l' S by its series."""
    rate, forcing, series = work[13], work[14], work[16]
    series[0] = s
    for k in range(SIZE - 2):
        total = forcing[k]
        for i in range(k + 1):
            total += rate[i] * series[k - i]
        series[k + 1] = total / (k + 1)
    series[SIZE - 1] = 0.0
    return value(series, h)


@compiled
def critical_friction(case):
    """Painleve limit by golden section on the half cell."""
    a, beta, kind, rho = case[0], case[1], case[3], case[4]
    best, at = np.inf, 0.0
    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    cells = 400
    for k in range(1, cells + 1):
        x = beta * k / cells
        value = _limit_at(a, kind, rho, x)
        if value < best:
            best, at = value, x
    low, high = max(at - beta / cells, 1e-300), min(at + beta / cells, beta)
    for _ in range(90):
        x, y = high - ratio * (high - low), low + ratio * (high - low)
        if _limit_at(a, kind, rho, x) < _limit_at(a, kind, rho, y):
            high = y
        else:
            low = x
    return min(best, _limit_at(a, kind, rho, 0.5 * (low + high)))


@compiled
def _limit_at(a, kind, rho, x):
    half = math.sin(0.5 * x)
    square = (a - kind) ** 2 + kind * 4.0 * a * half * half
    g = ((a - kind) - 2.0 * a * half * half) / square
    u = a * math.sin(x) / square
    return (rho + g * g) / (abs(g) * abs(u)) if g != 0.0 else np.inf
