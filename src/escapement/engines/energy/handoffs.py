"""Engagement after engagement: the times and speeds of handoffs, and nothing else."""

import numpy as np

from escapement.dynamics import dwell_gain, free_turn, scene_of
from escapement.engines.energy.calls import march
from escapement.engines.energy.events import EVENT, NONE, most_events
from escapement.engines.energy.march import OK, PAINLEVE
from escapement.engines.energy.panels import MAX_PANELS, NO_PANELS, new_store, tolerances
from escapement.engines.energy.passage import Record, Request
from escapement.jit import inner_jit, jit
from escapement.mechanisms.slotted import transmission_at
from escapement.painleve import beyond_painleve

LITTLE = 0.1  # exponent of an engagement below which changes of w are summed, not w itself


@jit(allocates=True)
def handoffs(calls, plain, cells, w, limit, rtol, clock, times, speeds):
    """March engagements until `times` is full, `limit` is passed or a stall.

    Parameters
    ----------
    calls, plain, cells : as `prepare.prepared` gives them.
    w, limit : squared driver speed at the first entry, time after which to
        stop; natural units.
    rtol : relative error asked for.
    clock : unit of time of the results.
    times, speeds : arrays to fill with handoff times and driver speeds.

    Returns
    -------
    status, done, angle
        Engagements completed; of a stall its driver angle [rad], its time being in times[done].
        They are a plain tuple, which Python makes in a third of the time of a named one.
    """
    scene = scene_of(plain)
    if beyond_painleve(scene):
        return PAINLEVE, 0, 0.0
    loose, strict = tolerances(rtol)
    request = Request(np.int64(Record.TIME), loose, strict)
    store = new_store(MAX_PANELS)
    events = np.empty(most_events(scene.edges), EVENT)
    count = NO_PANELS
    time, carry, carry_w = 0.0, 0.0, 0.0
    rho, edges = scene.rho, scene.edges
    inertia = transmission_at(scene.path, edges[0])[0] ** 2 + rho
    same = inertia == transmission_at(scene.path, edges[-1])[0] ** 2 + rho
    free_gain = dwell_gain(scene)
    start = w
    for k in range(times.size):
        found = march(calls, scene, cells, store, count, request, w, 0.0, 0.0, events, NONE)
        count = found.panels
        if found.status != OK:
            times[k] = (time + found.time) * clock
            return found.status, k, found.angle
        out, free = free_turn(found.w, scene)
        if scene.mu_plus == 0.0 and same:
            # every engagement adds the same energy: no sum, no rounding that adds up
            out = start + (k + 1) * (found.source / inertia + free_gain)
        elif same and abs(found.exponent) < LITTLE:
            # little is lost: what changes is added, its rounding errors carried along
            change = np.expm1(-found.exponent) * w + found.source / inertia + free_gain - carry_w
            out = w + change
            carry_w = (out - w) - change
        length = found.time + free
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
        gap = -np.expm1(-found.exponent)
        if abs(out - w) <= 0.05 * rtol * gap * gap * w:
            return OK, _repeat(k, time, length, limit, clock, times, speeds), 0.0
        w = out
    return OK, times.size, 0.0


@inner_jit
def _repeat(k, time, length, limit, clock, times, speeds):
    """Repeat engagement k to the end or the limit; returns how many engagements there are."""
    for j in range(k + 1, times.size):
        passed = time + (j - k) * length
        times[j] = passed * clock
        speeds[j] = speeds[k]
        if passed >= limit:
            return j + 1
    return times.size
