"""Engagement after engagement: the times and speeds of handoffs, and nothing else."""

import numpy as np

from escapement.dynamics import beyond_painleve, free_turn
from escapement.engines.energy.calls import march
from escapement.engines.energy.events import EVENTS, NONE, most_events
from escapement.engines.energy.march import OK, PAINLEVE, TIME
from escapement.engines.energy.panels import MAX_PANELS, NO_PANELS, new_store, tolerances
from escapement.jit import jit
from escapement.mechanisms.slotted import transmission_at


@jit(allocates=True)
def handoffs(
    calls, cells, path, breaks, dwell, rho, mu, load, w, limit, rtol, clock, times, speeds
):
    """March engagements until `times` is full, `limit` is passed or a stall.

    Parameters
    ----------
    dwell : driver angle between exit and handoff.
    w, limit : squared driver speed at the first entry, time after which to
        stop; natural units.
    clock : unit of time of the results.
    times, speeds : arrays to fill with handoff times and driver speeds.

    Returns
    -------
    status, done, angle
        Engagements completed; on a stall its angle, its time being in times[done].
    """
    if beyond_painleve(path, rho, mu[1], breaks[0], breaks[-1]):
        return PAINLEVE, 0, 0.0
    loose, strict = tolerances(rtol)
    store = new_store(MAX_PANELS)
    events = np.empty((most_events(breaks), EVENTS))
    count = NO_PANELS
    time, carry, carry_w = 0.0, 0.0, 0.0
    inertia = transmission_at(path, breaks[0])[0] ** 2 + rho
    start = w
    record = TIME
    same = inertia == transmission_at(path, breaks[-1])[0] ** 2 + rho
    for k in range(times.size):
        status, out, length, exponent, source, _side, _r, count, _u = march(
            calls, store, count, path, breaks, cells, rho, mu, load, w, 0.0, 0.0, loose, strict,
            record, events, NONE,
        )  # fmt: skip
        if status != OK:
            times[k] = (time + length) * clock
            return status, k, out
        out, free = free_turn(out, dwell, rho)
        if mu[0] == 0.0 and same:
            # every engagement adds the same energy: no sum, no rounding that adds up
            out = start + (k + 1) * (source / inertia + 2.0 * dwell / rho)
        elif same and abs(exponent) < 0.1:
            # little is lost: what changes is added, its rounding errors carried along
            change = np.expm1(-exponent) * w + source / inertia + 2.0 * dwell / rho - carry_w
            out = w + change
            carry_w = (out - w) - change
        length += free
        # Kahan's sum: the rounding errors of a million engagements must not add up
        step = length - carry
        total = time + step
        carry = (total - time) - step
        time = total
        times[k] = time * clock
        speeds[k] = np.sqrt(out) / clock
        if time >= limit:
            return OK, k + 1, 0.0
        # what is left to converge, and what it can still do to the sum of times
        gap = -np.expm1(-exponent)
        if abs(out - w) <= 0.05 * rtol * gap * gap * w:
            for j in range(k + 1, times.size):
                passed = time + (j - k) * length
                times[j] = passed * clock
                speeds[j] = speeds[k]
                if passed >= limit:
                    return OK, j + 1, 0.0
            return OK, times.size, 0.0
        w = out
    return OK, times.size, 0.0
