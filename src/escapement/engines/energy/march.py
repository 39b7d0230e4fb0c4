"""One engagement in the driver-angle domain, panel by panel.

The march finds the panels too coarse for what it meets on the way (a reversal, an
extremum, a start from rest, a near stop), halves them and goes on; the chain of
panels is thus made by the scene, and later engagements reuse it.
"""

import numpy as np

from escapement.dynamics import side_at
from escapement.engines.energy.events import BREAK, MAXIMUM, MINIMUM, REVERSAL, note, note_extremum
from escapement.engines.energy.gauss import N
from escapement.engines.energy.locate import locate, reversal_at, turn, weights_to
from escapement.engines.energy.panels import (
    ENDS,
    HALF,
    HEAD,
    KINK,
    LEFT,
    MANY,
    MAX_PANELS,
    NEXT,
    NO_PANELS,
    NOISE,
    RIGHT,
    SMALLEST,
    START,
    TAIL,
    UNBUILT,
    A,
    C,
    halve,
    lay_out,
    place_of,
    solution_of,
)
from escapement.engines.energy.sampling import (
    EVERY_POINT,
    LEFT_END,
    MERGED,
    NO_POINT,
    NOTHING,
    RIGHT_END,
    contact_at_end,
    dips,
    duration,
    find_extremum,
    first_against,
    rate_at_end,
    run_over,
)
from escapement.engines.energy.solve import solve_side
from escapement.engines.energy.start import begin, braking, clearly_against
from escapement.jit import jit
from escapement.status import Status

OK, NO_TERMINAL = int(Status.OK), int(Status.NO_TERMINAL)
STALL, PAINLEVE, NOT_CONVERGED = int(Status.STALL), int(Status.PAINLEVE), int(Status.NOT_CONVERGED)
SLOW = 1e-8  # energy over that gained in a panel, below which the panel is one of a start
NEARLY_STOPPED = 4e-13  # half width of a panel in which a stop is taken as even braking
MAP, TIME, EXTREMA, EVERYTHING = (np.int64(i) for i in range(4))  # what a march is asked for


@jit
def march(
    s, count, path, breaks, cells, rho, mu, load, w, side, rising, loose, strict, record, events,
    used,
):  # fmt: skip
    """Advance from entry to exit of one engagement.

    Parameters
    ----------
    s, count : store, and panels in use; the chain starts with panel 0. It is laid out where
        there is none, and anew where the events of many engagements, each elsewhere, left
        too many.
    w : squared driver speed at entry.
    side, rising : side of the slot (0: find out), and sign of the acceleration
        before the entry (0: none).
    loose, strict : tail allowed in a panel for whole-panel integrals, and for
        values inside it.
    record : MAP: only the map from w to w, blind for a pair of reversals inside a panel;
        TIME, EXTREMA, or EVERYTHING: also where and when reversals are.
    events, used : array (k, EVENTS) to be filled from row `used` on; too short a one
        ends the march.

    Returns
    -------
    status, w, time, exponent, source, side, rising, count, used
        w_out (rho + g_out^2) = exp(-exponent) w_in (rho + g_in^2) + source for the
        side switched at the same angles. On a stall w is the angle.
    """
    if count == NO_PANELS or count > MANY + 2 * breaks.size:
        count = lay_out(s, path, breaks, cells, rho, loose)
    time, exponent, source = 0.0, 0.0, 0.0
    panel = HEAD
    noted = False
    at = place_of(HEAD)
    energy = w * (rho + s[at + ENDS] ** 2)
    if side == 0.0:
        side = side_at(s[at + ENDS], s[at + ENDS + 2], w, rho, load)
    if w == 0.0 and rate_at_end(s, at, LEFT_END, side, 0.0, mu, load) <= 0.0:
        return STALL, s[at + LEFT], time, exponent, source, side, rising, count, used
    while panel >= 0:
        chained = place_of(panel)
        at = chained
        to = solution_of(at, side)
        if w > 0.0 and s[to + TAIL] == UNBUILT:
            solve_side(s, at, side, rho, mu, load)
        if w == 0.0 or energy <= SLOW * s[to + RIGHT + 1]:
            at = begin(s, at, side, path, rho, mu, load, w, strict)
            to = solution_of(at, side)
        tail = s[to + TAIL]
        # next to rest an error of the energy counts in full
        split = tail > (strict if at == START else loose)
        reversal, extremum, changes = -1, -1, 0
        even = False
        passed = 0.0
        e_right = s[to + RIGHT] * energy + s[to + RIGHT + 1]
        w_right = e_right / (rho + s[at + ENDS + 3] ** 2)
        c_right = side * contact_at_end(s, at, RIGHT_END, w_right, rho, load)
        # where only the map is asked for, the right end says whether more has to be known
        inside = record != MAP or not (c_right > 0.0 and w_right > 0.0)
        if inside and not split:
            against, stopped, slower = run_over(s, at, side, energy, rho, mu, load)
            if at == START and against > 0:
                against = clearly_against(s)
            c_left = side * contact_at_end(s, at, LEFT_END, w, rho, load)
            nothing = NOTHING * (rho + s[at + ENDS] ** 2)
            if stopped > 0 or not w_right > 0.0:
                if against == 0 and s[at + HALF] <= NEARLY_STOPPED:
                    way = -w / braking(s, at, side, w, rho, mu, load)
                    time += 2.0 * way / np.sqrt(w)
                    angle = s[at + LEFT] + way
                    return STALL, angle, time, exponent, source, side, rising, count, used
                split = True
            elif against > 0 or c_right <= 0.0:
                # a panel may hold one reversal: behind it all is on the other side
                reversal = first_against(s)
                split = N - reversal != against or c_right > 0.0 or at == START or tail > strict
                split = split or dips(s, C, nothing, c_left, c_right, NO_POINT, reversal)
                if split and s[at + HALF] <= MERGED:
                    # so close a pair does nothing; of one the order of points is rounding
                    split = False
                    reversal = reversal if c_right <= 0.0 else -1
        if inside and not split:
            # near a stop the errors of all panels have one sign, hence the tenth
            limit = strict if reversal >= 0 else 0.1 * loose
            passed, roughness = duration(s)
            split = roughness > max(limit, s[to + NOISE])
            if split and reversal < 0 and s[at + HALF] <= NEARLY_STOPPED:
                # next to a stop: so short a way is braked evenly
                split, even = False, True
            if not split and reversal < 0 and s[at + HALF] > MERGED:
                split = dips(s, C, nothing, c_left, c_right, NO_POINT, EVERY_POINT)
        now, final = 1.0, 1.0
        if record > TIME and not split:
            if s[chained + KINK] > 0.0 and not noted:
                used = note(events, used, BREAK, s[at + LEFT], time, w)
                noted = True
            now = rate_at_end(s, at, LEFT_END, side, w, mu, load)
            if now * rising < 0.0:
                kind = MAXIMUM if rising > 0.0 else MINIMUM
                used = note(events, used, kind, s[at + LEFT], time, w)
            rising = np.sign(now) if now != 0.0 else rising
            # on a reversal the driver turns free of the follower and gains speed
            final, last = 1.0, reversal
            if reversal < 0:
                final, last = rate_at_end(s, at, RIGHT_END, side, w_right, mu, load), N
            gains = slower == 0 and now > 0.0 and final > 0.0
            if not gains and not (slower == N and now < 0.0 and final < 0.0):
                changes, extremum = find_extremum(s, last, now, final)
            split = changes > 1 or (changes == 1 and at == START)
            if not split and s[at + HALF] > MERGED:
                split = dips(s, A, NOTHING, now, final, NO_POINT, last)
        if reversal >= 0 and not split:
            other = solution_of(at, -side)
            if s[other + TAIL] == UNBUILT:
                solve_side(s, at, -side, rho, mu, load)
            split = s[other + TAIL] > strict
        before = used
        length, shrunk, turned_source = 0.0, 0.0, 0.0
        if not split and (reversal >= 0 or extremum >= 0):
            high, x, slope = 1.0, 1.0, 0.0
            if reversal >= 0:
                # rounding alone may have it that the force is on the other side all along
                x = -1.0
                if c_left > 0.0:
                    x, slope = locate(s, C, reversal, c_left, c_right, 1.0)
                high = x
            if extremum >= 0:
                kind = MAXIMUM if rising > 0.0 else MINIMUM
                used = note_extremum(
                    events, used, kind, s, at, side, time, energy, extremum, now, final, high,
                    tail > strict, mu,
                )  # fmt: skip
            if reversal >= 0:
                if record == EVERYTHING:
                    angle, elapsed, w_turn = reversal_at(s, at, side, x, slope, path, w, rho, load)
                else:
                    # of a place that is off by d energy and time are by its square
                    weights_to(s, x)
                    angle, elapsed, w_turn = np.nan, np.nan, np.nan
                used = note(events, used, REVERSAL, angle, time + elapsed, w_turn)
                good, e_right, length, shrunk, turned_source = turn(
                    s, at, side, reversal, rho, mu, load, strict, record > TIME, source
                )
                split = not good
        if split:
            used = before
            if count >= MAX_PANELS or s[at + HALF] < SMALLEST:
                return NOT_CONVERGED, w, time, exponent, source, side, rising, count, used
            count = halve(s, panel, path, cells, rho, count)
            continue
        if reversal >= 0:
            w_right = e_right / (rho + s[at + ENDS + 3] ** 2)
            time += length
            exponent += shrunk
            source = turned_source
            side = -side
            rising = 1.0
        else:
            if extremum >= 0:
                rising = -rising
            if even:
                time += 4.0 * s[at + HALF] / (np.sqrt(w) + np.sqrt(w_right))
            else:
                time += passed
            exponent += s[to + RIGHT + 2]
            source = s[to + RIGHT] * source + s[to + RIGHT + 1]
        if used >= events.shape[0]:
            return NOT_CONVERGED, w, time, exponent, source, side, rising, count, used
        energy, w = e_right, w_right
        panel = np.int64(s[chained + NEXT])
        noted = False
    return OK, w, time, exponent, source, side, rising, count, used
