"""The times and speeds of handoffs, from one engagement to the next."""

import numpy as np

from escapement.dynamics.law import is_lossless, scene_of
from escapement.dynamics.torque import is_constant, is_spent
from escapement.engines.energy.located_events import NO_EVENTS
from escapement.engines.energy.march import OK, SPENT, STALL
from escapement.engines.energy.pairs import (
    Start,
    engage,
    lay_out_again,
    new_case,
    prepare,
    round_events,
    scene_at,
)
from escapement.engines.energy.panels import NO_PANELS
from escapement.engines.energy.passage import Detail, request_of
from escapement.engines.energy.rundown_series import (
    FORGOTTEN,
    Elapsed,
    fill,
    later,
    least_length,
    longest_stretch,
)
from escapement.numerics.held import held
from escapement.numerics.jit import inner_jit, jit

# Where int B over an engagement is below this, the slope of the map is nearly 1, and the change
# of w is computed instead of w, so that rounding errors do not add up.
SMALL_EXPONENT = 0.1


@jit(allocates=True)
def handoffs(addresses, packed, cells, pattern, w, limit, rtol, clock, times, speeds):
    """March engagements until `times` is full, `limit` is passed, or the motion stalls.

    Parameters
    ----------
    addresses, packed, cells, pattern : as `calls.prepared` gives them.
    w : squared driver speed at the first entry, in natural units.
    limit : time after which to stop, in natural units.
    rtol : relative error asked for.
    clock : unit of time of the results [s].
    times, speeds : arrays to fill with handoff times and driver speeds, those behind an impact.

    Returns
    -------
    status, done, angle
        `done` is the number of engagements completed. Of a stall `angle` is the driver angle
        [rad], and times[done] the time. A plain tuple is returned, because Python makes it in
        a third of the time that a named one takes.
    """
    scene = scene_of(packed)
    room = round_events(scene.edges, min(pattern.size, 1))
    case = new_case(addresses, scene, cells, pattern, room)
    return _follow(case, w, limit, rtol, clock, times, speeds)


@inner_jit
def _follow(inputs, w, limit, rtol, clock, times, speeds):
    """As `handoffs`; here references to arrays are not counted."""
    case = held(inputs)
    prepare(case)
    scene, data = case.scene, case.data
    request, size, constant = request_of(Detail.TIME, rtol), data.size, is_constant(scene)
    alone, whole = size == 1 and not constant, data[0].lap
    start, carry_w, elapsed = w, 0.0, Elapsed(0.0, 0.0)
    adds = size == 1 and constant and is_lossless(scene) and data[0].slope == 0.0
    # the numbers of the engagement, of the first after a knot, and of the next to try a series
    k = line = attempt = 0
    # the pair, the rounds before it, w at the start of the round, and the slope of its map so far
    index, rounds, entry, slope = 0, 0, w, 0.0
    while k < times.size:
        driver_angle = 0.0 if constant else rounds * whole + data[index].begin
        found = engage(case, index, Start(w, 0.0, NO_EVENTS), request, driver_angle)
        if found.status != OK:
            times[k] = (elapsed.total + found.time) * clock
            return _why(case, found, driver_angle), k, found.angle
        # without friction every engagement adds the same energy, so that a product takes the
        # place of a sum, whose rounding errors would add up
        out, carry_w = start + (k + 1) * found.source, 0.0
        if not adds:
            out, carry_w = _led_to(w, found, carry_w)
        elapsed = later(elapsed, found.time)
        times[k] = elapsed.total * clock
        speeds[k] = np.sqrt(out) / clock
        if elapsed.total >= limit:
            return OK, k + 1, 0.0
        w, k, index, slope = out, k + 1, index + 1, slope + found.slope
        if index < size:
            continue
        # the changes of w still to come add up to (w - entry)/gap, and their effect on the sum of
        # times to about (w - entry)/gap^2: where that is negligible, later rounds repeat this one
        change = abs(w - entry)
        if constant and (slope > 0.0 or change <= 0.05 * rtol * entry):  # else it cannot be
            gap = -np.expm1(slope)
            if change <= 0.05 * rtol * gap * gap * entry:
                return OK, _repeat(data, k, elapsed.total, limit, clock, times, speeds), 0.0
        index, rounds, entry, slope = 0, rounds + 1, w, 0.0
        if not alone:
            continue
        line = k if data[0].panels == NO_PANELS else line
        # after this number of engagements the start has no influence
        lead = int(FORGOTTEN / max(-found.slope, SMALL_EXPONENT)) + 2
        if k >= attempt and k - line >= lead:
            most, series = times.size - k, case.store.workspace[0].series
            stretch = longest_stretch(case, request, k, most, lead, w, rtol, series)
            done, w, elapsed = fill(stretch, w, elapsed, limit, clock, series, times, speeds)
            k, rounds = k + done, rounds + done
            if done > 0 and elapsed.total >= limit:
                return OK, k, 0.0
            attempt = k if done > 0 else k + least_length(lead)
            lay_out_again(case)
    return OK, times.size, 0.0


@inner_jit
def _why(case, found, driver_angle):
    """Status of a motion that ends in an engagement after a driver angle turned."""
    scene = scene_at(case, found.pair, driver_angle)
    spent = found.status == STALL and is_spent(found.angle, scene)
    return SPENT if spent else found.status


@inner_jit
def _led_to(w, found, carry):
    """The w to which an engagement from w has led, and what Kahan's sum has left of it."""
    if abs(found.slope) >= SMALL_EXPONENT:
        return found.w, carry
    # w_out - w = (exp(slope) - 1) w + source
    change = np.expm1(found.slope) * w + found.source - carry
    out = w + change
    return out, (out - w) - change


@inner_jit
def _repeat(data, k, time, limit, clock, times, speeds):
    """Repeat the round before engagement k to the end or the limit; returns the number of
    engagements.
    """
    size, length = data.size, 0.0
    for index in range(size):
        length += data[index].time
    index, rounds, since = 0, 0, 0.0
    for j in range(k, times.size):
        since, index = since + data[index].time, index + 1
        if index == size:
            index, rounds, since = 0, rounds + 1, 0.0
        passed = time + (rounds * length + since)
        times[j] = passed * clock
        speeds[j] = speeds[j - size]
        if passed >= limit:
            return j + 1
    return times.size
