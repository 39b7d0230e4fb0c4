"""One engagement in the driver-angle domain, panel by panel.

The march finds the panels too coarse for what it meets on the way (a reversal,
an extremum, a start from rest, a near stop), halves them and goes on; the chain
of panels is thus made by the scene, and later engagements reuse it.
"""

import numpy as np

from escapement._jit import jit
from escapement.dynamics import side_at
from escapement.engines._inside import (
    SMOOTH,
    A,
    C,
    F,
    braking,
    contact_at_end,
    dips,
    find_extremum,
    first_against,
    locate,
    rate_at_end,
    rest_before,
    rough,
    rough_from_rest,
    run_over,
    state_inside,
    time_from_low_speed,
    turn,
    way_from_rest,
)
from escapement.engines._panels import (
    ENDS,
    GEOMETRY,
    HALF,
    KINK,
    LEFT,
    MAX_PANELS,
    NEXT,
    NOISE,
    RIGHT,
    SMALLEST,
    TAIL,
    UNBUILT,
    N,
    halve,
    part_of,
    solve_side,
    survey,
    whole,
)
from escapement.mechanisms._slotted import singularities

OK, STALL, GAVE_UP = 0, 2, 4
NEARLY_STOPPED = 4e-13  # half width of a panel in which a stop is taken as even braking
REVERSAL, MINIMUM, MAXIMUM, BREAK = 0.0, 1.0, 2.0, 3.0
EVENTS = 4  # columns of an event: kind, angle from dead centre, time, w


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
def _note(events, used, kind, angle, time, w):
    if used < events.shape[0]:
        events[used, 0] = kind
        events[used, 1] = angle
        events[used, 2] = time
        events[used, 3] = w
        used += 1
    return used


@jit
def turned(events, used):
    """Whether the events of an engagement hold a pin reversal."""
    count = 0
    for i in range(used):
        count += events[i, 0] == REVERSAL
    return count > 0


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
    time, exponent, source = 0.0, 0.0, 0.0
    panel = 0
    noted = False
    way = 0.0
    row = store[0, GEOMETRY]
    energy = w * (rho + row[ENDS] ** 2)
    if side == 0.0:
        side = side_at(row[ENDS], row[ENDS + 2], w, rho, load)
    if w == 0.0 and rate_at_end(row, 0, side, 0.0, mu, load) <= 0.0:
        return STALL, row[LEFT], time, exponent, source, side, rising, count, used
    while panel >= 0:
        row = store[panel, GEOMETRY]
        solution = store[panel, part_of(side)]
        if solution[TAIL] == UNBUILT:
            solve_side(row, solution, side, rho, mu, load, scratch)
        tail = solution[TAIL]
        split = tail > loose
        reversal, extremum = -1, -1
        even = False
        z = 2.0
        e_right = solution[RIGHT] * energy + solution[RIGHT + 1]
        w_right = e_right / (rho + row[ENDS + 3] ** 2)
        if not split:
            against, stopped = run_over(row, solution, energy, side, rho, load, scratch)
            c_right = side * contact_at_end(row, 1, w_right, rho, load)
            if stopped > 0 or not w_right > 0.0:
                if against == 0 and row[HALF] <= NEARLY_STOPPED:
                    way = -w / braking(row, side, w, rho, mu, load)
                    time += 2.0 * way / np.sqrt(w)
                    angle = row[LEFT] + way
                    return STALL, angle, time, exponent, source, side, rising, count, used
                split = True
            elif against > 0 or c_right <= 0.0:
                # a panel may hold one reversal: behind it all is on the other side
                reversal = first_against(scratch)
                split = N - reversal != against or c_right > 0.0
            else:
                split = dips(scratch)
        if not split:
            z = rest_before(row, w, side, rho, mu, load, scratch)
            if z < SMOOTH:
                split = z > 1.05 or tail > strict or reversal >= 0
                if not split:
                    way = way_from_rest(row, w, z, rho, scratch)
                    split = rough_from_rest(way, strict, scratch)
            else:
                # near a stop the errors of all panels have one sign, hence the tenth
                limit = strict if reversal >= 0 else 0.1 * loose
                split = rough(scratch, max(limit, solution[NOISE]))
                if split and reversal < 0 and row[HALF] <= NEARLY_STOPPED:
                    # next to a stop: so short a way is braked evenly
                    split, even = False, True
        if record and not split:
            if row[KINK] > 0.0 and not noted:
                used = _note(events, used, BREAK, row[LEFT], time, w)
                noted = True
            now = rate_at_end(row, 0, side, w, mu, load)
            if now * rising < 0.0:
                kind = MAXIMUM if rising > 0.0 else MINIMUM
                used = _note(events, used, kind, row[LEFT], time, w)
            rising = np.sign(now) if now != 0.0 else rising
            last = N if reversal < 0 else reversal
            changes, extremum = find_extremum(row, side, w, w_right, last, mu, load, scratch)
            split = changes > 1 or (changes == 1 and (tail > strict or reversal >= 0 or z < SMOOTH))
        if reversal >= 0 and not split:
            other = store[panel, part_of(-side)]
            if other[TAIL] == UNBUILT:
                solve_side(row, other, -side, rho, mu, load, scratch)
            split = tail > strict or other[TAIL] > strict
            if not split:
                c_left = side * contact_at_end(row, 0, w, rho, load)
                c_right = side * contact_at_end(row, 1, w_right, rho, load)
                x = locate(C, reversal, c_left, c_right, scratch)
                angle, elapsed, w_turn = state_inside(row, path, x, rho, scratch)
                good, e_right, length, shrunk, added = turn(
                    row, solution, other, side, reversal, rho, mu, load, strict, record,
                    source, scratch,
                )  # fmt: skip
                split = not good
            if not split:
                used = _note(events, used, REVERSAL, angle, time + elapsed, w_turn)
                w_right = e_right / (rho + row[ENDS + 3] ** 2)
                time += length
                exponent += shrunk
                source = added
                side = -side
                rising = 1.0
        elif not split:
            if extremum >= 0:
                a_left = rate_at_end(row, 0, side, w, mu, load)
                a_right = rate_at_end(row, 1, side, w_right, mu, load)
                x = locate(A, extremum, a_left, a_right, scratch)
                angle, elapsed, w_top = state_inside(row, path, x, rho, scratch)
                kind = MAXIMUM if rising > 0.0 else MINIMUM
                used = _note(events, used, kind, angle, time + elapsed, w_top)
                rising = -rising
            if even:
                time += 4.0 * row[HALF] / (np.sqrt(w) + np.sqrt(w_right))
            elif z < SMOOTH:
                time += time_from_low_speed(row, way, scratch)
            else:
                time += row[HALF] * whole(scratch, F)
            exponent += solution[RIGHT + 2]
            source = solution[RIGHT] * source + solution[RIGHT + 1]
        if split:
            if count >= MAX_PANELS or row[HALF] < SMALLEST:
                return GAVE_UP, row[LEFT], time, exponent, source, side, rising, count, used
            count = halve(store, panel, path, rho, count)
            continue
        energy, w = e_right, w_right
        panel = int(row[NEXT])
        noted = False
    return OK, w, time, exponent, source, side, rising, count, used
