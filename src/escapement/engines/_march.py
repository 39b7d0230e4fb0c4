"""One engagement in the driver-angle domain, panel by panel.

The march finds the panels too coarse for what it meets on the way (a reversal,
an extremum, a start from rest, a near stop), halves them and goes on; the chain
of panels is thus made by the scene, and later engagements reuse it.
"""

import numpy as np

from escapement._jit import jit
from escapement.dynamics import side_at
from escapement.engines._panels import (
    ALPHA,
    BETA,
    DG,
    DOWN,
    ENDS,
    GEOMETRY,
    HALF,
    INVERSE,
    KINK,
    LEFT,
    MAX_PANELS,
    NEXT,
    NOISE,
    POINTS,
    RIGHT,
    SMALLEST,
    SPREAD,
    TAIL,
    UNBUILT,
    UP,
    WEIGHTS,
    B,
    G,
    N,
    U,
    combine,
    evaluate,
    halve,
    part_of,
    root_between,
    solve_side,
    survey,
    tail_of,
    weights_to,
    whole,
)
from escapement.mechanisms._slotted import singularities, transmission_at

OK, STALL, GAVE_UP = 0, 2, 4
NEARLY_STOPPED = 1e-9  # half width of a panel in which a stop is taken as even braking
REVERSAL, MINIMUM, MAXIMUM, BREAK = 0.0, 1.0, 2.0, 3.0
EVENTS = 4  # columns of an event: kind, angle from dead centre, time, w

# scratch: two blocks for solve_side, then W or E, 1/sqrt(w), contact, rate, coefficients, weights
_W, _F, _C, _A, _K, _V, _Q, _E = (2 * N + N * i for i in range(8))
SCRATCH = 10 * N


@jit
def _fits(left, right, re, im, reach):
    """Whether +-re + i im lies outside the Bernstein ellipse with half axis `reach`."""
    most = (right - left) * reach
    for place in (re, -re):
        behind, ahead = place - left, place - right
        near = np.sqrt(behind * behind + im * im) + np.sqrt(ahead * ahead + im * im)
        if near < most:
            return False
    return True


@jit
def lay_out(store, breaks, path, rho, loose):
    """First panels of an engagement; returns their number.

    Between two breaks the interval is halved until no singularity of the
    coefficients is so near that the Legendre series would miss `loose`.
    """
    re_c, im_c, re_d, im_d = singularities(path, rho)
    rate = (0.3 * loose) ** (-1.0 / (N - 1))
    reach = 0.5 * (rate + 1.0 / rate)
    count = 0
    for k in range(breaks.size - 1):
        left, end = breaks[k], breaks[k + 1]
        first = True
        while left < end:
            right = end
            # the dyadic panel at `left` that fits: halved from the whole interval
            while (
                not (
                    _fits(left, right, re_c, im_c, reach) and _fits(left, right, re_d, im_d, reach)
                )
                and right - left > 1e-6
                and count < MAX_PANELS // 8
            ):
                right = 0.5 * (left + right)
            survey(store[count], path, rho, left, right)
            store[count, GEOMETRY, NEXT] = count + 1.0
            store[count, GEOMETRY, KINK] = 1.0 if first and k > 0 else 0.0
            first = False
            left = right
            count += 1
    store[count - 1, GEOMETRY, NEXT] = -1.0
    return count


@jit
def _rate(row, i, side, w, mu, load):
    """J theta_ddot at a point: the sign of the driver's acceleration."""
    return 1.0 - (row[G + i] + side * mu * row[U + i]) * (row[DG + i] * w + load)


@jit
def _rate_at_end(row, end, side, w, mu, load):
    at = ENDS + 3 * end
    return 1.0 - (row[at] + side * mu * row[at + 1]) * (row[at + 2] * w + load)


@jit
def _contact_at_end(row, end, w, rho, load):
    at = ENDS + 3 * end
    return rho * (row[at + 2] * w + load) + row[at]


@jit
def _time_from_low_speed(row, energy, scratch, z):
    """Time over a panel whose speed vanishes at x = -z, just before its left end.

    1/sqrt(w) is a smooth function over sqrt(x + z); the generating function of
    the Legendre polynomials gives the moments of the weight in closed form.
    """
    t = 1.0 / (z + np.sqrt((z - 1.0) * (z + 1.0)))
    scale = np.sqrt(2.0 * t)
    total = 0.0
    for i in range(N):
        x = POINTS[i]
        before, now = 1.0, x
        weight = 1.0 - t * x
        power = -t
        for k in range(1, N - 1):
            after = UP[k] * x * now - DOWN[k] * before
            before, now = now, after
            power *= -t
            weight += power * now
        total += WEIGHTS[i] * scale * weight * np.sqrt(x + z) * scratch[_F + i]
    return row[HALF] * total


@jit
def _distance_to_rest(scratch, z):
    """Refine the place x = -z where the energy's extension vanishes."""
    combine(SPREAD, scratch, _E, scratch, _K)
    x = -z
    for _ in range(6):
        value, slope = evaluate(scratch, _K, x)
        x -= value / slope
    return max(1.0, -x)


@jit
def _dips(scratch):
    """Whether the contact nearly vanishes between points: a pair of reversals may hide."""
    # a parabola that touches zero is small at one of three points
    first, middle, last = scratch[_C], scratch[_C + N // 2], scratch[_C + N - 1]
    if min(first, min(middle, last)) > 0.2 * max(first, max(middle, last)):
        return False
    for i in range(1, N - 1):
        c = scratch[_C + i]
        if c <= scratch[_C + i - 1] and c < scratch[_C + i + 1]:
            drop = max(scratch[_C + i - 1], scratch[_C + i + 1]) - c
            return c < 0.5 * drop
    return False


@jit
def _note(events, used, kind, angle, time, w):
    if used < events.shape[0]:
        events[used, 0] = kind
        events[used, 1] = angle
        events[used, 2] = time
        events[used, 3] = w
        used += 1
    return used


@jit
def march(
    store, count, path, rho, mu, load, w, side, rising, loose, strict, record, events, scratch
):
    """Advance from entry to exit of one engagement.

    Parameters
    ----------
    store, count : panel rows in a chain from row 0, and how many are in use.
    w : squared driver speed at entry.
    side, rising : side of the slot (0: find out), and sign of the acceleration
        before the entry (0: none).
    loose, strict : tail allowed in a panel for whole-panel integrals, and for
        values inside it.
    record : whether extrema are wanted; reversals always are.
    events : array (k, 4) to be filled; a full array drops the rest.

    Returns
    -------
    status, w, time, exponent, source, side, rising, count, events_used
        w_out (rho + g_out^2) = exp(-exponent) w_in (rho + g_in^2) + source for the
        side switched at the same angles. On a stall w is the angle.
    """
    used = 0
    time = 0.0
    exponent = 0.0
    source = 0.0
    panel = 0
    noted = False
    a = a_left = c_left = c_right = 0.0
    row = store[0, GEOMETRY]
    energy = w * (rho + row[ENDS] ** 2)
    if side == 0.0:
        side = side_at(row[ENDS], row[ENDS + 2], w, rho, load)
    if w == 0.0 and _rate_at_end(row, 0, side, 0.0, mu, load) <= 0.0:
        return STALL, row[LEFT], time, exponent, source, side, rising, count, used
    while panel >= 0:
        row = store[panel, GEOMETRY]
        solution = store[panel, part_of(side)]
        if solution[TAIL] == UNBUILT:
            solve_side(row, solution, side, rho, mu, load, scratch)
        tail = solution[TAIL]
        split = tail > loose
        half = row[HALF]
        reversal = -1
        if not split:
            # speeds, times and contact at the points
            against = 0
            stopped = 0
            for i in range(N):
                e = solution[ALPHA + i] * energy + solution[BETA + i]
                v = e * row[INVERSE + i]
                c = side * (rho * (row[DG + i] * v + load) + row[G + i])
                scratch[_E + i] = e
                scratch[_W + i] = v
                scratch[_C + i] = c
                scratch[_F + i] = 1.0 / np.sqrt(v)
                against += c <= 0.0
                stopped += not v > 0.0
            e_right = solution[RIGHT] * energy + solution[RIGHT + 1]
            w_right = e_right / (rho + row[ENDS + 3] ** 2)
            c_left = side * _contact_at_end(row, 0, w, rho, load)
            c_right = side * _contact_at_end(row, 1, w_right, rho, load)
            if stopped > 0 or not w_right > 0.0:
                if against > 0 or half > NEARLY_STOPPED:
                    split = True
                else:
                    # so close to the stop the driver slows down evenly
                    at = ENDS
                    j = rho + row[at] * (row[at] + side * mu * row[at + 1])
                    way = -0.5 * w * j / _rate_at_end(row, 0, side, w, mu, load)
                    angle = row[LEFT] + way
                    time += 2.0 * way / np.sqrt(w)
                    return STALL, angle, time, exponent, source, side, rising, count, used
            elif against > 0 or c_right <= 0.0:
                # one reversal in a panel: all points behind the first lie on the other side
                first = N
                for i in range(N):
                    if scratch[_C + i] <= 0.0:
                        first = i
                        break
                reversal = first
                if N - first != against or c_right > 0.0:
                    split = True
            elif _dips(scratch):
                split = True
        z = 2.0
        if not split and w < 0.25 * scratch[_W + N // 2]:
            at = ENDS
            j = rho + row[at] * (row[at] + side * mu * row[at + 1])
            slope = 2.0 * _rate_at_end(row, 0, side, w, mu, load) / j * half
            z = 1.0 + w / slope if slope > 0.0 else 2.0
            if z < 1.6 and (z > 1.05 or tail > strict or reversal >= 0):
                split = True
        if not split and z >= 1.6:
            limit = max(strict if reversal >= 0 else loose, solution[NOISE])
            split = tail_of(scratch, _F) > limit * scratch[_F + N // 2]

        # extrema of the speed
        extremum = -1
        if record and not split:
            if row[KINK] > 0.0 and not noted:
                used = _note(events, used, BREAK, row[LEFT], time, w)
                noted = True
            previous = a_left = _rate_at_end(row, 0, side, w, mu, load)
            if previous * rising < 0.0:
                used = _note(events, used, MAXIMUM if rising > 0.0 else MINIMUM, row[LEFT], time, w)
            rising = np.sign(previous) if previous != 0.0 else rising
            last = N if reversal < 0 else reversal
            changes = 0
            slower = 0
            for i in range(N):
                a = _rate(row, i, side, scratch[_W + i], mu, load)
                scratch[_A + i] = a
                slower += a <= 0.0
            if last < N or (0 < slower < N) or (slower == 0) != (previous > 0.0):
                for i in range(last):
                    a = scratch[_A + i]
                    if a * previous < 0.0:
                        changes += 1
                        extremum = i
                    previous = a if a != 0.0 else previous
            # on a reversal the driver turns free of the follower and gains speed
            a = _rate_at_end(row, 1, side, w_right, mu, load) if reversal < 0 else 1.0
            if a * previous < 0.0:
                changes += 1
                extremum = last
            split = changes > 1 or (changes == 1 and (tail > strict or reversal >= 0 or z < 1.6))

        other = solution
        if reversal >= 0 and not split:
            other = store[panel, part_of(-side)]
            if other[TAIL] == UNBUILT:
                solve_side(row, other, -side, rho, mu, load, scratch)
            split = tail > strict or other[TAIL] > strict

        if not split and reversal >= 0:
            combine(SPREAD, scratch, _C, scratch, _K)
            low_x = POINTS[reversal - 1] if reversal > 0 else -1.0
            high_x = POINTS[reversal] if reversal < N else 1.0
            low_c = scratch[_C + reversal - 1] if reversal > 0 else c_left
            high_c = scratch[_C + reversal] if reversal < N else c_right
            x = root_between(scratch, _K, low_x, high_x, low_c, high_c)
            weights_to(x, scratch, 0, _V, _Q)
            e = 0.0
            elapsed = 0.0
            alpha = 0.0
            beta = 0.0
            b = 0.0
            alpha_other = 0.0
            beta_other = 0.0
            b_other = 0.0
            for i in range(N):
                v = scratch[_V + i]
                e += v * scratch[_E + i]
                elapsed += scratch[_Q + i] * scratch[_F + i]
                alpha += v * solution[ALPHA + i]
                beta += v * solution[BETA + i]
                b += v * solution[B + i]
                alpha_other += v * other[ALPHA + i]
                beta_other += v * other[BETA + i]
                b_other += v * other[B + i]
            fictive = (e - beta_other) / alpha_other
            after = 0.0
            bad = 0
            for i in range(N):
                v = (other[ALPHA + i] * fictive + other[BETA + i]) * row[INVERSE + i]
                scratch[_W + i] = v
                scratch[_F + i] = 1.0 / np.sqrt(v)
                after += (WEIGHTS[i] - scratch[_Q + i]) * scratch[_F + i]
                bad += not v > 0.0
                c = side * (rho * (row[DG + i] * v + load) + row[G + i])
                bad += i >= reversal and c > 0.0
                bad += record and i >= reversal and _rate(row, i, -side, v, mu, load) <= 0.0
            e_right = other[RIGHT] * fictive + other[RIGHT + 1]
            w_right = e_right / (rho + row[ENDS + 3] ** 2)
            bad += not w_right > 0.0
            bad += side * _contact_at_end(row, 1, w_right, rho, load) > 0.0
            bad += record and _rate_at_end(row, 1, -side, w_right, mu, load) <= 0.0
            limit = max(strict, other[NOISE])
            split = bad > 0 or tail_of(scratch, _F) > limit * scratch[_F + N // 2]
            if not split:
                angle = row[LEFT] + half * (1.0 + x)
                g, _u, _dg = transmission_at(path, angle)
                used = _note(
                    events, used, REVERSAL, angle, time + half * elapsed, e / (rho + g * g)
                )
                time += half * (elapsed + after)
                exponent += b - b_other + other[RIGHT + 2]
                source = (alpha * source + beta - beta_other) / alpha_other
                source = other[RIGHT] * source + other[RIGHT + 1]
                side = -side
                rising = 1.0
        elif not split:
            if extremum >= 0:
                combine(SPREAD, scratch, _A, scratch, _K)
                low_x = POINTS[extremum - 1] if extremum > 0 else -1.0
                high_x = POINTS[extremum] if extremum < N else 1.0
                low_a = scratch[_A + extremum - 1] if extremum > 0 else a_left
                high_a = scratch[_A + extremum] if extremum < N else a
                x = root_between(scratch, _K, low_x, high_x, low_a, high_a)
                weights_to(x, scratch, 0, _V, _Q)
                e = 0.0
                elapsed = 0.0
                for i in range(N):
                    e += scratch[_V + i] * scratch[_E + i]
                    elapsed += scratch[_Q + i] * scratch[_F + i]
                angle = row[LEFT] + half * (1.0 + x)
                g, _u, _dg = transmission_at(path, angle)
                kind = MAXIMUM if rising > 0.0 else MINIMUM
                used = _note(events, used, kind, angle, time + half * elapsed, e / (rho + g * g))
                rising = -rising
            if z < 1.6:
                if w > 0.0:
                    z = _distance_to_rest(scratch, z)
                time += _time_from_low_speed(row, energy, scratch, z)
            else:
                time += half * whole(scratch, _F)
            exponent += solution[RIGHT + 2]
            source = solution[RIGHT] * source + solution[RIGHT + 1]

        if split:
            if count >= MAX_PANELS or half < SMALLEST:
                return GAVE_UP, row[LEFT], time, exponent, source, side, rising, count, used
            count = halve(store, panel, path, rho, count)
            continue
        energy = e_right
        w = w_right
        panel = int(row[NEXT])
        noted = False
    return OK, w, time, exponent, source, side, rising, count, used
