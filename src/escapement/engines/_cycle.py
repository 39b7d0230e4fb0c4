"""From engagement to motion: the transient, and the cycle it ends in.

An engagement maps the squared handoff speed affinely once its reversals are
known, and to first order they do not move the result. Newton's method on the
fixed point is therefore the affine map's own fixed point, found again for the
reversals found: it converges quadratically, and its contraction is exact.
"""

import numpy as np

from escapement._jit import jit
from escapement.engines._march import EVENTS, MAXIMUM, MINIMUM, OK, SCRATCH, STALL, lay_out, march
from escapement.engines._panels import ENDS, MAX_PANELS, ROW
from escapement.mechanisms._slotted import transmission_at

NO_TERMINAL = 1
FIGURES = 8
(V_MAX, V_MIN, PERIOD, RISE, SETTLING, W_HANDOFF, CONTRACTION, SOLVES) = range(FIGURES)
RISE_BAND, SETTLING_BAND = 0.02, 0.01
MAX_ENGAGEMENTS = 1_000_000
_EVENTS_PER_ENGAGEMENT = 16


@jit
def tolerances(rtol):  # type: ignore[no-untyped-def]
    """Tails allowed in panels for a relative error: whole panel, and inside.

    Measured on random scenes the error is at most a hundredth of the square of
    the first and a twentieth of the second.
    """
    return 3.0 * np.sqrt(rtol), max(5.0 * rtol, 1e-14)


@jit
def free_turn(w, angle, rho):  # type: ignore[no-untyped-def]
    """Squared speed after a dwell of the follower, and the time it takes."""
    after = w + 2.0 * angle / rho
    return after, 2.0 * angle / (np.sqrt(w) + np.sqrt(after)) if angle > 0.0 else 0.0


@jit
def handoffs(path, breaks, dwell, rho, mu, load, w, limit, rtol, times, squares):  # type: ignore[no-untyped-def]
    """March engagements until `times` is full, `limit` is passed or a stall.

    Parameters
    ----------
    dwell : driver angle between exit and handoff.
    w : squared driver speed at the first entry.
    limit : time after which to stop.
    times, squares : arrays to fill with handoff times and squared speeds.

    Returns
    -------
    status, done, angle, w_last
        Engagements completed and w at the last handoff; on a stall its angle and
        w at the entry before it, its time being in times[done].
    """
    loose, strict = tolerances(rtol)
    store = np.empty((MAX_PANELS, ROW))
    events = np.empty((_EVENTS_PER_ENGAGEMENT, EVENTS))
    scratch = np.empty(SCRATCH)
    count = lay_out(store, breaks, path, rho)
    time = 0.0
    for k in range(times.size):
        status, out, length, exponent, _s, _side, _r, count, _u = march(
            store, count, path, rho, mu, load, w, 0.0, 0.0, loose, strict, False, events, scratch
        )
        if status != OK:
            times[k] = time + length
            return status, k, out, w
        out, free = free_turn(out, dwell, rho)
        length += free
        time += length
        times[k] = time
        squares[k] = out
        if time >= limit:
            return OK, k + 1, 0.0, out
        # what is left to converge, and what it can still do to the sum of times
        gap = -np.expm1(-exponent)
        if abs(out - w) <= 0.05 * rtol * gap * gap * w:
            for j in range(k + 1, times.size):
                times[j] = time + (j - k) * length
                squares[j] = out
                if times[j] >= limit:
                    return OK, j + 1, 0.0, out
            return OK, times.size, 0.0, out
        w = out
    return OK, times.size, 0.0, w


@jit
def fixed_point(store, count, path, exit_, dwell, rho, mu, load, w, rtol, events, scratch):  # type: ignore[no-untyped-def]
    """Terminal squared handoff speed by Newton's method.

    Returns
    -------
    status, w, contraction, count, marches
    """
    loose, strict = tolerances(rtol)
    previous = w
    free = 2.0 * dwell / rho
    g_in = store[0, ENDS]
    g_out = transmission_at(path, exit_)[0]
    leave = rho + g_out * g_out
    unequal = (g_out - g_in) * (g_out + g_in) / leave
    marches = 0
    plain = 0
    for _ in range(MAX_ENGAGEMENTS):
        status, out, _t, exponent, source, _side, _r, count, _u = march(
            store, count, path, rho, mu, load, w, 0.0, 0.0, loose, strict, False, events, scratch
        )
        marches += 1
        if status == STALL and plain == 0 and marches > 1:
            # Newton overshot into a stop: follow the motion itself for a while
            w = previous
            plain = 20
            continue
        if status != OK:
            return status, out, 0.0, count, marches
        # E_out = exp(-exponent) E_in + source, w = E/(rho + g^2) at either end; the gap
        # 1 - shrink keeps its relative accuracy when next to nothing is lost
        shrink = np.exp(-exponent) * (1.0 - unequal)
        gap = -np.expm1(-exponent) + np.exp(-exponent) * unequal
        previous = out + free
        if plain == 0 and gap <= 1e-14 and previous > w:
            # too slow for a pin reversal, friction only borrows: go where it takes
            w = 4.0 * previous
            continue
        better = (source / leave + free) / gap
        if plain > 0 or not better > 0.0:
            w = previous
            plain = max(plain - 1, 0)
            continue
        change = abs(better - w)
        w = better
        if change <= 1e-7 * np.sqrt(rtol / 1e-13) * w:
            return OK, w, shrink, count, marches
    return 4, w, 0.0, count, marches


@jit
def figures(path, breaks, dwell, rho, mu, load, w_start, rtol, store, events, scratch, out):  # type: ignore[no-untyped-def]
    """Figures of merit of one case into out (natural units); returns the status.

    On a stall out[0:2] holds its angle and the engagement.
    """
    for i in range(FIGURES):
        out[i] = np.nan
    if mu == 0.0:
        return NO_TERMINAL
    loose, strict = tolerances(rtol)
    count = lay_out(store, breaks, path, rho)
    # the first engagements settle most of the way: a good start for Newton
    status, w, _t, _x, _s, _side, _r, count, _u = march(
        store, count, path, rho, mu, load, w_start, 0.0, 0.0, loose, strict, False, events, scratch
    )
    if status != OK:
        out[0], out[1] = w, 0.0
        return status
    w, _free = free_turn(w, dwell, rho)
    status, w, shrink, count, marches = fixed_point(
        store, count, path, breaks[-1], dwell, rho, mu, load, w, rtol, events, scratch
    )
    if status != OK:
        out[0], out[1] = w, marches
        return status
    status, exit_w, length, _x, _s, side, rising, count, used = march(
        store, count, path, rho, mu, load, w, 0.0, 0.0, loose, strict, True, events, scratch
    )
    if status != OK:
        return status
    fast = max(w, exit_w)
    slow = min(w, exit_w)
    for i in range(used):
        if events[i, 0] == MAXIMUM or events[i, 0] == MINIMUM:
            fast = max(fast, events[i, 3])
            slow = min(slow, events[i, 3])
    _w, free = free_turn(exit_w, dwell, rho)
    out[V_MAX] = np.sqrt(fast)
    out[V_MIN] = np.sqrt(slow)
    out[PERIOD] = length + free
    out[W_HANDOFF] = w
    out[CONTRACTION] = shrink
    out[SOLVES] = marches
    _transient(path, dwell, rho, mu, load, w_start, loose, strict, store, count, events, scratch, out)
    return OK


@jit
def _transient(path, dwell, rho, mu, load, w, loose, strict, store, count, events, scratch, out):  # type: ignore[no-untyped-def]
    """Rise and settling time: follow the extrema from the start.

    The greatest and least speed of each engagement tend monotonically to the
    terminal ones, so the motion is settled with the first engagement whose
    extremes are within the band and whose handoffs are converging.
    """
    time = 0.0
    rising = 0.0
    side = 0.0
    settled = np.nan
    for _ in range(MAX_ENGAGEMENTS):
        status, exit_w, length, _x, _s, side, rising, count, used = march(
            store, count, path, rho, mu, load, w, 0.0, rising, loose, strict, True, events, scratch
        )
        if status != OK:
            return
        if dwell > 0.0:
            if rising < 0.0 and used < events.shape[0]:
                events[used, 0], events[used, 2], events[used, 3] = MINIMUM, length, exit_w
                used += 1
            rising = 1.0
        best, least = -1, -1
        for i in range(used):
            if events[i, 0] == MAXIMUM and (best < 0 or events[i, 3] > events[best, 3]):
                best = i
            if events[i, 0] == MINIMUM and (least < 0 or events[i, 3] < events[least, 3]):
                least = i
        for i in range(used):
            if events[i, 0] != MAXIMUM and events[i, 0] != MINIMUM:
                continue
            target = out[V_MAX] if events[i, 0] == MAXIMUM else out[V_MIN]
            error = abs(np.sqrt(events[i, 3]) / target - 1.0)
            if np.isnan(out[RISE]) and error <= RISE_BAND:
                out[RISE] = time + events[i, 2]
            if i == best or i == least:
                if error > SETTLING_BAND:
                    settled = np.nan
                elif np.isnan(settled):
                    settled = time + events[i, 2]
        out_w, free = free_turn(exit_w, dwell, rho)
        time += length + free
        w = out_w
        near = abs(w / out[W_HANDOFF] - 1.0)
        if near <= 0.1 * SETTLING_BAND and not np.isnan(settled):
            break
    out[SETTLING] = settled
