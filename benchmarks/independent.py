"""A third integrator, written without the package, to judge its engines in bulk.

Taylor series in the driver angle, in double precision, from the Lagrangian: with
rho = I_d/I_f, W = theta_dot^2 I_f/torque, m = load/torque, c = s mu |u|, p = g + c,
D = rho + g^2 and J = rho + g p,

    J W' + 2 p g' W = 2 (1 - p m),        s = sign K,   K = rho (g' W + m) + g.

Every step expands the transmission, W, K and W^(-1/2) about its start and goes as far
as their last coefficients are negligible. W ~ x at a start from rest and W ~ -x before
a stop: there the half-integer powers are integrated term by term. Beside W it carries
the logarithm l of the homogeneous solution of E = D W and the particular one S,

    l' = -2 c rho g'/(J D),     S' = 2 D (1 - p m)/J + l' S,

whose end values give the terminal cycle as W = (S/rho + dwell)/(1 - e^l) without
cancellation. Speeds and times are in natural units; angles in rad from dead centre.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

OK, STALL, PAINLEVE, LOST = 0, 2, 3, 4
ORDER = 28
SIZE = ORDER + 1
NEGLIGIBLE = 1e-17
REVERSALS = 4
LONGEST = 4000  # steps of one engagement
# what an engagement returns: status, W (angle on a stall), time, l, S, greatest W,
# least W, number of reversals, steps, total variation of l, then angle and time of each
# reversal
HEAD = 10
VARIATION = 9
ROW = HEAD + 2 * REVERSALS

compiled = njit(cache=True, error_model="numpy", nogil=True)


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
def _product(x, y, z):
    for k in range(x.size):
        total = 0.0
        for i in range(k + 1):
            total += x[i] * y[k - i]
        z[k] = total


@compiled
def _quotient(x, y, z):
    for k in range(x.size):
        total = x[k]
        for i in range(k):
            total -= z[i] * y[k - i]
        z[k] = total / y[0]


@compiled
def _inverse_root(x, count, y):
    """y = x^(-1/2) from 2 x y' = -x' y."""
    y[0] = 1.0 / math.sqrt(x[0])
    for k in range(1, count):
        total = 0.0
        for i in range(1, k + 1):
            total -= (0.5 * i + (k - i)) * x[i] * y[k - i]
        y[k] = total / (k * x[0])


@compiled
def _value(x, h):
    total = 0.0
    for k in range(x.size - 1, -1, -1):
        total = total * h + x[k]
    return total


@compiled
def _slope(x, h):
    total = 0.0
    for k in range(x.size - 1, 0, -1):
        total = total * h + k * x[k]
    return total


@compiled
def _reach(x, last):
    """Distance at which the last two of the coefficients 0..last are negligible."""
    scale = max(abs(x[0]), 1e-3 * abs(x[1]))
    far = 4.0
    for k in (last, last - 1):
        if x[k] != 0.0:
            far = min(far, (NEGLIGIBLE * scale / abs(x[k])) ** (1.0 / k))
    return far


@compiled
def _root(x, low, high, at_low, derivative):
    """Root of a series (or of its derivative) in a bracket: Newton kept in by bisection."""
    h = 0.5 * (low + high)
    for _ in range(200):
        if derivative:
            f = _slope(x, h)
            step = 1e-7 * (high - low)
            df = (_slope(x, h + step) - f) / step if step > 0.0 else 0.0
        else:
            f, df = _value(x, h), _slope(x, h)
        if f == 0.0:
            return h
        if (f > 0.0) == (at_low > 0.0):
            low = h
        else:
            high = h
        guess = h - f / df
        if not low < guess < high:
            guess = 0.5 * (low + high)
        if abs(guess - h) <= 1e-16 * (abs(h) + abs(guess)) or high - low <= 2e-16 * high:
            return guess
        h = guess
    return h


@compiled
def _turns(x, h, out):
    """Roots in (0, h) of the derivative of a series; returns their number."""
    found, before = 0, _slope(x, 0.0)
    for k in range(8):
        after = _slope(x, h * (k + 1) / 8.0)
        if before * after < 0.0 and found < out.size:
            out[found] = _root(x, h * k / 8.0, h * (k + 1) / 8.0, before, True)
            found += 1
        before = after if after != 0.0 else before
    return found


@compiled
def _falls(x, h, sense, turns):
    """First place in (0, h] where sense * series goes from above zero to below, or -1."""
    found = _turns(x, h, turns)
    low, at_low = 0.0, sense * _value(x, 0.0)
    for k in range(found + 1):
        high = turns[k] if k < found else h
        at_high = sense * _value(x, high)
        if at_high < 0.0 and at_low >= 0.0 and (at_low > 0.0 or sense * _slope(x, 0.0) > 0.0):
            place = (
                _root(x, low, high, sense, False) if sense > 0 else _root(x, low, high, -1.0, False)
            )
            if sense * _slope(x, place) < 0.0:
                return place
        low, at_low = high, at_high
    return -1.0


@compiled
def _transmission(a, kind, angle, unit, work):
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
        # the series of cos, of sin beside it
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
    _quotient(top, square, g)
    _quotient(tmp, square, u)
    # C = c - kind e^(-i kind theta): g' = u (a + b - 2 g), worked out from the quotient instead
    for k in range(SIZE - 1):
        dg[k] = (k + 1) * g[k + 1] / unit
    dg[SIZE - 1] = 0.0


@compiled
def _expand(case, angle, half, sense, w0, unit, work):
    """Series about `angle` with W = w0 there; returns J and two reaches, in units of `unit`.

    half = +1 after dead centre, -1 before: the sign of theta. work rows: 0 g, 1 g',
    2 u, 6 c, 7 p, 8 J, 9 D, 10 W, 11 K, 12 W^(-1/2) (of W/x at rest), 13 l', 14 S'
    without its last term, 15.. scratch.
    """
    a, kind, rho, mu, load = case[0], case[3], case[4], case[5], case[6]
    _transmission(a, kind, angle, unit, work)
    g, dg, u = work[0], work[1], work[2]
    c, p, j, d, w, contact = work[6], work[7], work[8], work[9], work[10], work[11]
    last = SIZE - 2  # g' is known one order less
    for k in range(SIZE):
        c[k] = sense * mu * half * kind * u[k]
        p[k] = g[k] + c[k]
    _product(g, p, j)
    _product(g, g, d)
    j[0] += rho
    d[0] += rho
    damping = work[15]
    _product(p, dg, damping)
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
    _product(dg, w, contact)
    for k in range(SIZE):
        contact[k] = rho * contact[k] + g[k]
    contact[0] += rho * load
    contact[SIZE - 1] = 0.0
    slow = work[12]
    slow[:] = 0.0
    if w0 > 0.0:
        _inverse_root(w, SIZE, slow)
        far_slow = _reach(slow, last)
    else:
        grown = work[16]
        sign = 1.0 if w[1] > 0.0 else -1.0
        for k in range(SIZE - 1):
            grown[k] = sign * w[k + 1]
        _inverse_root(grown, SIZE - 1, slow)
        far_slow = _reach(slow, last)
    both, inverse = work[17], work[18]
    _product(j, d, both)
    work[16][:] = 0.0
    work[16][0] = 1.0
    _quotient(work[16], both, inverse)
    far = min(_reach(inverse, last), _reach(g, last))
    grown_w = work[16]
    for k in range(SIZE - 1):
        grown_w[k] = w[k] if w0 > 0.0 else w[k + 1]
    far = min(far, _reach(grown_w, last))
    _product(c, dg, work[16])
    _product(work[16], inverse, work[13])
    for k in range(SIZE):
        work[13][k] *= -2.0 * rho * unit
        work[16][k] = -load * p[k]
    work[16][0] += 1.0
    _product(d, work[16], work[17])
    _quotient(work[17], j, work[14])
    for k in range(SIZE):
        work[14][k] *= 2.0 * unit
    return j[0], far, far_slow


@compiled
def _integral(x, h):
    total = 0.0
    for k in range(x.size - 2, -1, -1):
        total = total * h + x[k] / (k + 1)
    return total * h


@compiled
def _root_integral(x, h, sense):
    """Integral of (sense x)^(-1/2) times a series over (0, h), sense = -1: over (-h, 0)."""
    total = 0.0
    for k in range(x.size - 3, -1, -1):
        total = total * (sense * h) + x[k] / (k + 0.5)
    return total * math.sqrt(h)


@compiled
def _advance_source(work, h, s):
    """S after a step: S' = forcing + l' S by its series."""
    rate, forcing, series = work[13], work[14], work[16]
    series[0] = s
    for k in range(SIZE - 2):
        total = forcing[k]
        for i in range(k + 1):
            total += rate[i] * series[k - i]
        series[k + 1] = total / (k + 1)
    series[SIZE - 1] = 0.0
    return _value(series, h)


@compiled
def engage(case, w, work, turns, out):
    """One engagement from pin entry with squared speed w; fills out (a row)."""
    beta, rho = case[1], case[4]
    out[:] = 0.0
    time, lost_time = 0.0, 0.0
    log, source, variation = 0.0, 0.0, 0.0
    top, bottom = w, w
    sense = 1.0  # at entry g = 0 and g' > 0
    reversals, steps = 0, 0
    unit = 0.05
    if w > 0.0:
        unit = min(unit, max(0.1 * w * rho, 1e-280))
    for half in (-1.0, 1.0):
        angle = -beta if half < 0.0 else 0.0
        end = 0.0 if half < 0.0 else beta
        while angle < end:
            steps += 1
            j, far, far_slow = _expand(case, angle, half, sense, w, unit, work)
            if not j > 0.0:
                out[0] = PAINLEVE
                return
            reach = min(far, far_slow)
            if reach < 1e-4 and steps < LONGEST:
                unit *= max(reach * 2.0, 1e-8)
                continue
            if not reach > 0.0 or steps >= LONGEST:
                out[0] = LOST
                return
            if w == 0.0 and work[10][1] <= 0.0:
                out[0], out[1], out[2] = STALL, angle, time
                return
            final = (end - angle) / unit
            fall = _falls(work[11], min(far, final), sense, turns)
            within = min(far, final) if fall < 0.0 else fall
            stop = _falls(work[10], within, 1.0, turns)
            if stop >= 0.0:
                # time back from the stop, if that series carries so far
                length = stop * unit
                base = work[20]
                base[:] = work[10]
                _j, back, back_slow = _expand(case, angle + length, half, sense, 0.0, unit, work)
                if stop <= min(back, back_slow) and work[10][1] < 0.0:
                    elapsed = unit * _root_integral(work[12], stop, -1.0)
                    out[0], out[1], out[2] = STALL, angle + length, time + elapsed
                    out[7], out[8] = reversals, steps
                    return
                _expand(case, angle, half, sense, w, unit, work)
            h = min(reach, final)
            reverses = 0.0 <= fall <= h
            if reverses:
                h = fall
            for k in range(_turns(work[10], h, turns)):
                here = _value(work[10], turns[k])
                top, bottom = max(top, here), min(bottom, here)
            if w > 0.0:
                elapsed = unit * _integral(work[12], h)
            else:
                elapsed = unit * _root_integral(work[12], h, 1.0)
            # compensated sum
            y = elapsed - lost_time
            t = time + y
            lost_time = (t - time) - y
            time = t
            change = _integral(work[13], h)
            log += change
            variation += abs(change)
            source = _advance_source(work, h, source)
            w = _value(work[10], h)
            top, bottom = max(top, w), min(bottom, w)
            angle = end if h == final else angle + h * unit
            if not w > 0.0:
                out[0] = LOST
                return
            if reverses:
                if reversals < REVERSALS:
                    out[HEAD + 2 * reversals] = angle
                    out[HEAD + 2 * reversals + 1] = time
                reversals += 1
                sense = -sense
            unit = max(min(unit * reach, 0.5), 1e-290)
    out[0], out[1], out[2], out[3], out[4] = OK, w, time, log, source
    out[5], out[6], out[7], out[8], out[9] = top, bottom, reversals, steps, variation


@compiled
def motion(case, w, rows):
    """Engagements until `rows` is full; returns status and how many are complete.

    Row k: as `engage` returns it, W and time being those of the handoff, dwell included.
    """
    work, turns = np.empty((24, SIZE)), np.empty(16)
    dwell, rho = case[2], case[4]
    time, lost = 0.0, 0.0
    for k in range(rows.shape[0]):
        engage(case, w, work, turns, rows[k])
        row = rows[k]
        start = time
        row[HEAD + 1 : HEAD + 2 * REVERSALS : 2] += start
        spent = row[2]
        if row[0] != OK:
            row[2] = time + spent
            return int(row[0]), k
        w = row[1]
        if dwell > 0.0:
            after = w + 2.0 * dwell / rho
            spent += 2.0 * dwell / (math.sqrt(w) + math.sqrt(after))
            w = after
            row[5] = max(row[5], w)
        y = spent - lost
        t = time + y
        lost = (t - time) - y
        time = t
        row[1], row[2] = w, time
    return OK, rows.shape[0]


@compiled
def terminal(case, w, out):
    """Terminal cycle as fixed point; out as a row of `motion`, out[8] being the passes.

    Below the first pin reversal l is zero and every engagement gains the same; above it
    the gain falls as W rises, so there is one fixed point or, where that gain is
    negative, none: then the motion stops sooner or later.
    """
    work, turns = np.empty((24, SIZE)), np.empty(16)
    dwell, rho = case[2], case[4]
    free = 2.0 * dwell / rho
    low, high = 0.0, np.inf
    moving, before = w, np.inf
    for k in range(400):
        engage(case, moving, work, turns, out)
        if out[0] == STALL:
            if k == 0:
                return STALL
            low = max(low, moving)
            if high - low <= 1e-13 * high:
                return STALL
            moving = 0.5 * (low + min(high, 4.0 * low + 1e-300))
            continue
        if out[0] != OK:
            return int(out[0])
        gap = -math.expm1(out[3])
        source = out[4] / rho + free
        gain = source - moving * gap
        dissipates = gap > 1e-12 * out[VARIATION]
        if not dissipates:
            if source <= 0.0:
                return STALL
            low, better = max(low, moving), 4.0 * moving + source
        else:
            if gain > 0.0:
                low = max(low, moving)
            else:
                high = min(high, moving)
            better = source / gap
        change = abs(better - moving)
        if dissipates and (change <= 1e-15 * moving or 0.5 * before < change <= 1e-11 * moving):
            after = out[1] + free
            if dwell > 0.0:
                out[2] += 2.0 * dwell / (math.sqrt(out[1]) + math.sqrt(after))
                out[5] = max(out[5], after)
            out[1] = after
            out[8] = k + 1
            return OK
        before = change
        if change > 1e-11 * moving and not low < better < high:
            if high < np.inf:
                better = 0.5 * (low + high) if low < 1e-3 * high else math.sqrt(low * high)
            else:
                better = 4.0 * moving + source
        moving = better
    return LOST


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
