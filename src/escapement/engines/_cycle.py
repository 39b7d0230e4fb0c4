"""From engagement to motion: the transient, and the cycle it ends in.

An engagement maps the squared handoff speed affinely once its reversals are
known, and to first order they do not move the result. Newton's method on the
fixed point is therefore the affine map's own fixed point, found again for the
reversals found: it converges quadratically, and its contraction is exact.
"""

import numpy as np

from escapement._jit import jit
from escapement.engines._march import EVENTS, MAXIMUM, MINIMUM, OK, STALL, march, turned
from escapement.engines._panels import ENDS, lay_out, new_store, place_of
from escapement.mechanisms._slotted import transmission_at

NO_TERMINAL, PAINLEVE, NOT_CONVERGED = 1, 3, 4
FIGURES = 7
V_MAX, V_MIN, PERIOD, RISE, SETTLING, W_HANDOFF, CONTRACTION = range(FIGURES)
SEEN = 128  # extrema of a transient that are kept
PATIENCE = 40  # engagements after which the terminal cycle is looked for in any case
RISE_BAND, SETTLING_BAND = 0.02, 0.01
MAX_ENGAGEMENTS = 1_000_000
EVENTS_OF_ONE = 16


@jit(allocates=True)
def workspace(breaks):
    """Panel store, events of an engagement and extrema seen, for `figures`."""
    most = EVENTS_OF_ONE + 4 * breaks.size
    return new_store(), np.empty((most, EVENTS)), np.empty((SEEN + 2 * most, EVENTS))


@jit
def tolerances(rtol):
    """Tails allowed in panels for a relative error: whole panel, and inside.

    Measured on random scenes the error is at most a hundredth of the square of
    the first and a twentieth of the second. Beyond 1e-8 that no longer holds of every
    scene, and next to nothing would be saved.
    """
    rtol = min(rtol, 1e-8)
    return 3.0 * np.sqrt(rtol), max(15.0 * rtol, 1e-14)


@jit
def free_turn(w, angle, rho):
    """Squared speed after a dwell of the follower, and the time it takes."""
    after = w + 2.0 * angle / rho
    return after, 2.0 * angle / (np.sqrt(w) + np.sqrt(after)) if angle > 0.0 else 0.0


@jit
def _closer(w, out, exponent, source, rho, ends, reversed_):
    """Fixed point of the affine map an engagement went by, and its contraction.

    E_out = exp(-exponent) E_in + source with w = E/(rho + g^2) at either end;
    `ends` holds g at entry, g at exit and what a dwell adds to w. The gap
    1 - shrink keeps its relative accuracy when next to nothing is lost. The third
    answer is False where the map has no fixed point to be trusted.
    """
    g_in, g_out, free = ends
    leave = rho + g_out * g_out
    unequal = (g_out - g_in) * (g_out + g_in) / leave
    shrink = np.exp(-exponent) * (1.0 - unequal)
    gap = -np.expm1(-exponent) + np.exp(-exponent) * unequal
    following = out + free
    if gap <= 0.0 or (gap <= 1e-12 and not reversed_):
        # too slow for a pin reversal, friction only borrows: go where it takes
        return (4.0 * following if following > w else following), shrink, False
    return (source / leave + free) / gap, shrink, True


@jit
def _beyond(w, better, before, better_before):
    """Fixed point from two steps of Newton's, whose errors go like the squares of what they had.

    The better of the two where they are too close for that.
    """
    was, now = before - better, w - better
    gained = was * was - now * now
    if now * now > 0.25 * was * was or abs(better_before - better) > abs(was):
        return better
    return better - (better_before - better) * now * now / gained


@jit
def _terminal(
    store, count, cells, path, breaks, dwell, rho, mu, load, w, before, better_before, rtol,
    events, out,
):  # fmt: skip
    """Terminal cycle by Newton's method from w; fills out, events hold its extrema.

    `better_before` is what a step from `before` gave; equal ones count for nothing.

    Returns
    -------
    status, count
    """
    loose, strict = tolerances(rtol)
    ends = (store[place_of(0) + ENDS], transmission_at(path, breaks[-1])[0], 2.0 * dwell / rho)
    last_good = w
    plain = 0
    near = better_before != before  # by a value, see `handoffs`
    for k in range(MAX_ENGAGEMENTS):
        status, exit_w, length, exponent, source, _side, _r, count, used = march(
            store, count, path, cells, rho, mu, load, w, 0.0, 0.0, loose, strict, near, events
        )
        if status == STALL and plain == 0 and k > 0:
            # Newton overshot into a stop: follow the motion itself for a while
            w, plain, near = last_good, 20, False
            continue
        if status != OK:
            out[0], out[1] = exit_w, k
            return status, count
        turning = turned(events, used)
        better, shrink, sound = _closer(w, exit_w, exponent, source, rho, ends, turning)
        last_good = exit_w + ends[2]
        change = abs(better - w)
        if near and change <= 0.2 * rtol * w:
            break
        # the next change is about the square of this one
        near = sound and change <= np.sqrt(0.02 * rtol) * w
        if plain > 0 or not better > 0.0:
            better = last_good
            near = False
            plain = max(plain - 1, 0)
        elif sound and better_before != before:
            before, w, better_before = w, _beyond(w, better, before, better_before), better
            continue
        before, better_before = w, better
        w = better
    else:
        return NOT_CONVERGED, count
    fast, slow = max(w, exit_w), min(w, exit_w)
    for i in range(used):
        if events[i, 0] == MAXIMUM or events[i, 0] == MINIMUM:
            fast, slow = max(fast, events[i, 3]), min(slow, events[i, 3])
    out[V_MAX], out[V_MIN] = np.sqrt(fast), np.sqrt(slow)
    out[PERIOD] = length + free_turn(exit_w, dwell, rho)[1]
    out[W_HANDOFF], out[CONTRACTION] = better, shrink
    return OK, count


@jit
def _judge(kind, time, w, leading, calm, out):
    """Let one extremum of the transient decide on rise and settling time.

    Only the greatest and the least speed of an engagement tend to the terminal
    ones, so only they can unsettle a motion. Returns how many in a row did not.
    """
    error = abs(np.sqrt(w) / (out[V_MAX] if kind == MAXIMUM else out[V_MIN]) - 1.0)
    if np.isnan(out[RISE]) and error <= RISE_BAND:
        out[RISE] = time
    if not leading:
        return calm
    if error > SETTLING_BAND:
        out[SETTLING] = np.nan
        return 0
    if np.isnan(out[SETTLING]):
        out[SETTLING] = time
    return calm + 1


@jit
def _leads(events, used, i):
    """Whether no other extremum of its kind in the engagement goes further."""
    for j in range(used):
        if events[j, 0] == events[i, 0]:
            if events[i, 0] == MAXIMUM and events[j, 3] > events[i, 3]:
                return False
            if events[i, 0] == MINIMUM and events[j, 3] < events[i, 3]:
                return False
    return True


@jit
def figures(cells, path, breaks, dwell, rho, mu, load, w, rtol, store, events, seen, out):
    """Figures of merit of one case into out (natural units); returns the status.

    The motion is followed from its start until it has nearly settled, its
    extrema kept in `seen`; Newton's method finds the terminal cycle from there;
    only a motion that settles slowly is followed again. On a stall out[0:2]
    holds its angle and the engagement.
    """
    for i in range(FIGURES):
        out[i] = np.nan
    if mu[0] == 0.0 and load == 0.0:
        return NO_TERMINAL
    loose, strict = tolerances(rtol)
    count = lay_out(store, path, breaks, cells, rho, loose)
    ends = (store[place_of(0) + ENDS], transmission_at(path, breaks[-1])[0], 2.0 * dwell / rho)
    time, rising = 0.0, 0.0
    filled = 0
    found, calm = False, 0
    before, better_before = w, w
    record = out.size > 0  # a value: see `handoffs`
    for k in range(MAX_ENGAGEMENTS):
        status, exit_w, length, exponent, source, _s, rising, count, used = march(
            store, count, path, cells, rho, mu, load, w, 0.0, rising, loose, strict, record, events
        )
        if status != OK:
            for i in range(FIGURES):
                out[i] = np.nan
            out[0], out[1] = exit_w, k
            return status
        if mu[0] == 0.0:
            # every engagement adds the same energy: the load stops the motion, or nothing does
            return NO_TERMINAL if source + 2.0 * dwell > 0.0 else STALL
        if dwell > 0.0:
            if rising < 0.0:
                events[used, 0], events[used, 2], events[used, 3] = MINIMUM, length, exit_w
                used += 1
            rising = 1.0
        for i in range(used):
            kind = events[i, 0]
            if kind != MAXIMUM and kind != MINIMUM:
                continue
            leading = _leads(events, used, i)
            if found:
                calm = _judge(kind, time + events[i, 2], events[i, 3], leading, calm, out)
            else:
                seen[filled, 0], seen[filled, 1] = kind, time + events[i, 2]
                seen[filled, 2], seen[filled, 3] = events[i, 3], leading
                filled += 1
        following, free = free_turn(exit_w, dwell, rho)
        time += length + free
        if not found:
            turning = turned(events, used)
            better, _shrink, sound = _closer(w, exit_w, exponent, source, rho, ends, turning)
            # speeds within the band; every later engagement lies between this and the last
            settled = sound and abs(better - w) <= 4.0 * SETTLING_BAND * better
            if settled or k == PATIENCE or filled + events.shape[0] > seen.shape[0]:
                start = better if better > 0.0 else following
                if sound and better_before != before:
                    start = _beyond(w, better, before, better_before)
                status, count = _terminal(
                    store, count, cells, path, breaks, dwell, rho, mu, load, start, w, better,
                    rtol, events, out,
                )  # fmt: skip
                if status != OK:
                    return status
                found = True
                for i in range(filled):
                    calm = _judge(seen[i, 0], seen[i, 1], seen[i, 2], seen[i, 3] > 0.0, calm, out)
                # far too slow: the band shrinks to 2 % in log(0.02)/log(contraction) engagements
                if out[CONTRACTION] > 1.0 - 1.0 / MAX_ENGAGEMENTS:
                    return OK
            before, better_before = w, better
        w = following
        # motions do not cross: once both its extrema are within the band, so are all to come
        if found and calm >= 2:
            return OK
    if found:
        # beyond the limit a time is not given
        out[SETTLING] = np.nan
    return OK
