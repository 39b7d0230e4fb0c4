"""The cycle a motion ends in, as the fixed point of an engagement.

An engagement maps the squared handoff speed affinely once its reversals are
known, and to first order they do not move the result. Newton's method on the
fixed point is therefore the affine map's own fixed point, found again for the
reversals found: it converges quadratically, and its contraction is exact.
"""

import numpy as np

from escapement.dynamics import free_turn
from escapement.engines.energy.calls import march, place
from escapement.engines.energy.events import KIND, MAXIMUM, MINIMUM, ROUGH, SQUARE, turned
from escapement.engines.energy.march import (
    EXTREMA,
    MAP,
    NO_TERMINAL,
    NOT_CONVERGED,
    OK,
    STALL,
    TIME,
)
from escapement.engines.energy.panels import NO_PANELS, tolerances
from escapement.jit import jit
from escapement.mechanisms.table import is_table
from escapement.metrics import BOUNDLESS, MAX_ENGAGEMENTS

FIGURES = 7
V_MAX, V_MIN, PERIOD, RISE, SETTLING, W_HANDOFF, CONTRACTION = range(FIGURES)


@jit
def closer(w, out, exponent, source, rho, ends, reversed_):
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
def beyond(w, better, before, better_before):
    """Fixed point from two steps of Newton's, whose errors go like the squares of what they had.

    The better of the two where they are too close for that.
    """
    was, now = before - better, w - better
    if now * now > 0.25 * was * was or abs(better_before - better) > abs(was):
        return better
    further = better - (better_before - better) * now * now / (was * was - now * now)
    return further if further > 0.0 else better


@jit
def terminal_cycle(
    calls, store, count, cells, path, breaks, dwell, rho, mu, load, ends, w, last_good, before,
    better_before, rtol, events, first, out,
):  # fmt: skip
    """Terminal cycle by Newton's method from w; fills out.

    `ends` is what `closer` takes; `last_good` where to go on from when that stalls;
    `better_before` what a step from `before` gave, equal ones counting for nothing. Events
    may be noted from row `first` on.

    Returns
    -------
    status, count
    """
    loose, strict = tolerances(rtol)
    plain, patience = 0, 20
    # a load often turns the pin twice inside a panel, which the map alone is blind for
    near, glance = False, MAP if load == 0.0 else TIME
    for _ in range(MAX_ENGAGEMENTS):
        status, exit_w, length, exponent, source, _side, _r, count, used = march(
            calls, store, count, path, breaks, cells, rho, mu, load, w, 0.0, 0.0, loose, strict,
            EXTREMA if near else glance, events, first,
        )  # fmt: skip
        if status == STALL and plain == 0:
            # Newton overshot into a stop: follow the motion itself for a while, without the
            # panels of that stop
            count = NO_PANELS
            w, plain, near, glance = last_good, patience, False, TIME
            patience *= 2
            continue
        if status != OK:
            return status, count
        turning = turned(events, first, used)
        better, shrink, sound = closer(w, exit_w, exponent, source, rho, ends, turning)
        last_good = exit_w + ends[2]
        change = abs(better - w)
        # small changes of a motion that is only followed prove nothing
        if near and sound and change <= 0.2 * rtol * w:
            break
        if near or not sound:
            # should the map alone have been blind for something after all
            glance = TIME
        if not sound and is_table(path) and w < last_good < (1.0 + BOUNDLESS) * w:
            return NO_TERMINAL, count
        # the next change is about the square of this one
        near = sound and change <= np.sqrt(0.02 * rtol) * w
        if plain > 0 or not better > 0.0:
            better = last_good
            near = False
            plain = max(plain - 1, 0)
        elif sound and better_before != before:
            before, w, better_before = w, beyond(w, better, before, better_before), better
            continue
        before, better_before = w, better
        w = better
    else:
        return NOT_CONVERGED, count
    fast, slow = max(w, exit_w), min(w, exit_w)
    for i in range(first, used):
        if not MINIMUM <= events[i, KIND] <= MAXIMUM:
            continue
        # only what may be the greatest or the least has to be exact
        if not slow * (1.0 + ROUGH) < events[i, SQUARE] < fast * (1.0 - ROUGH):
            place(calls, events, i, store, path, rho, mu, load)
        fast, slow = max(fast, events[i, SQUARE]), min(slow, events[i, SQUARE])
    out[V_MAX], out[V_MIN] = np.sqrt(fast), np.sqrt(slow)
    out[PERIOD] = length + free_turn(exit_w, dwell, rho)[1]
    out[W_HANDOFF], out[CONTRACTION] = better, shrink
    return OK, count
