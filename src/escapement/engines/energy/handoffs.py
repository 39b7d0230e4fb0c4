"""The times and speeds of handoffs, from one engagement to the next."""

import numpy as np

from escapement.dynamics.law import is_lossless
from escapement.dynamics.needs import typed_scene
from escapement.dynamics.painleve import beyond_painleve
from escapement.dynamics.torque import cell_after, cell_of, is_constant, is_spent
from escapement.engines.energy.calls import MarchInputs, march
from escapement.engines.energy.located_events import EVENT, NO_EVENTS, most_events
from escapement.engines.energy.march import OK, PAINLEVE, SPENT, STALL
from escapement.engines.energy.panels import MAX_PANELS, NO_PANELS, new_store
from escapement.engines.energy.passage import Detail, request_of
from escapement.engines.energy.rundown_series import (
    FORGOTTEN,
    NODES,
    add_time,
    fill,
    least_length,
    longest_stretch,
)
from escapement.mechanisms.slotted import transmission_at
from escapement.numerics.jit import inner_jit, jit

# Where the exponent int B of an engagement is below this, the slope of the map is nearly 1, and
# the change of w is computed instead of w, so that rounding errors do not add up.
SMALL_EXPONENT = 0.1


@jit(allocates=True)
def handoffs(addresses, scene_tuple, cells, w, limit, rtol, clock, times, speeds):
    """March engagements until `times` is full, `limit` is passed, or the motion stalls.

    Parameters
    ----------
    addresses, scene_tuple, cells : as `calls.prepared` gives them.
    w : squared driver speed at the first entry, in natural units.
    limit : time after which to stop, in natural units.
    rtol : relative error asked for.
    clock : unit of time of the results [s].
    times, speeds : arrays to fill with handoff times and driver speeds.

    Returns
    -------
    status, done, angle
        `done` is the number of engagements completed. Of a stall `angle` is the driver angle
        [rad], and times[done] the time. A plain tuple is returned, because Python makes it in
        a third of the time that a named one takes.
    """
    scene, cell = typed_scene(scene_tuple), 0.0
    if not is_constant(scene):
        cell = cell_of(scene)
    if beyond_painleve(scene):
        return PAINLEVE, 0, 0.0
    request = request_of(Detail.TIME, rtol)
    store = new_store(MAX_PANELS)
    events = np.empty(most_events(scene.edges), EVENT)
    count = NO_PANELS
    case = MarchInputs(addresses, scene, cells, store, events)
    totals, series, carry_w = np.zeros(2), np.empty((4, NODES if cell > 0.0 else 0)), 0.0
    inertia = transmission_at(scene.path, scene.edges[0])[0] ** 2 + scene.rho
    ends_equal = inertia == transmission_at(scene.path, scene.edges[-1])[0] ** 2 + scene.rho
    start, steady_gain = w, is_constant(scene) and is_lossless(scene)
    # the numbers of the engagement, of the first after a knot, and of the next to try a series
    k = line = attempt = 0
    while k < times.size:
        scene = cell_after(k * cell, scene)
        found = march(addresses, scene, cells, store, count, request, w, 0.0, events, NO_EVENTS)
        count = found.panels
        if found.status != OK:
            times[k] = (totals[0] + found.time) * clock
            spent = found.status == STALL and is_spent(found.angle, scene)
            return SPENT if spent else found.status, k, found.angle
        out = found.w
        if steady_gain and ends_equal:
            # without friction every engagement adds the same energy, so that a product takes the
            # place of a sum, whose rounding errors would add up
            out = start + (k + 1) * found.source / inertia
        elif ends_equal and abs(found.exponent) < SMALL_EXPONENT:
            # w_out - w = (exp(-exponent) - 1) w + source/(rho + g^2), added to w by Kahan's sum
            change = np.expm1(-found.exponent) * w + found.source / inertia - carry_w
            out = w + change
            carry_w = (out - w) - change
        add_time(totals, found.time)
        times[k] = totals[0] * clock
        speeds[k] = np.sqrt(out) / clock
        if totals[0] >= limit:
            return OK, k + 1, 0.0
        # the changes of w still to come add up to (out - w)/gap, and their effect on the sum of
        # times to about (out - w)/gap^2: where that is negligible, later engagements repeat this
        gap = -np.expm1(-found.exponent)
        if cell == 0.0 and abs(out - w) <= 0.05 * rtol * gap * gap * w:
            return OK, _repeat(k, totals[0], found.time, limit, clock, times, speeds), 0.0
        w, k = out, k + 1
        if cell == 0.0:
            continue
        line = k if found.panels == NO_PANELS else line
        # after this number of engagements the start has no influence
        lead = int(FORGOTTEN / max(found.exponent, SMALL_EXPONENT)) + 2
        if k >= attempt and k - line >= lead:
            most = times.size - k
            stretch = longest_stretch(case, request, k, most, lead, w, rtol, series)
            done, w = fill(stretch, w, limit, clock, totals, series, times, speeds)
            k += done
            if done > 0 and totals[0] >= limit:
                return OK, k, 0.0
            attempt, count = k if done > 0 else k + least_length(lead), NO_PANELS
    return OK, times.size, 0.0


@inner_jit
def _repeat(k, time, length, limit, clock, times, speeds):
    """Repeat engagement k to the end or the limit; returns the number of engagements."""
    for j in range(k + 1, times.size):
        passed = time + (j - k) * length
        times[j] = passed * clock
        speeds[j] = speeds[k]
        if passed >= limit:
            return j + 1
    return times.size
