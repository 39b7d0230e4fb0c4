"""Figures of merit of a case: its transient, and the cycle that ends in."""

import numpy as np

from escapement.dynamics import ends_alike, free_turn
from escapement.engines.energy.calls import march, place
from escapement.engines.energy.cells import AT_ENDS
from escapement.engines.energy.cycle import (
    CONTRACTION,
    FIGURES,
    RISE,
    SETTLING,
    V_MAX,
    V_MIN,
    beyond,
    closer,
    terminal_cycle,
)
from escapement.engines.energy.events import (
    EVENTS,
    KIND,
    MAXIMUM,
    MINIMUM,
    NONE,
    ROUGH,
    SQUARE,
    TIME,
    most_events,
    note,
    turned,
)
from escapement.engines.energy.march import EXTREMA, NO_TERMINAL, NOT_CONVERGED, OK, STALL
from escapement.engines.energy.panels import MAX_PANELS, NO_PANELS, new_store, tolerances
from escapement.jit import jit
from escapement.metrics import MAX_ENGAGEMENTS, RISE_BAND, SETTLING_BAND

SEEN = 256  # events of a transient that are kept
SINCE, LEADING = EVENTS, EVENTS + 1  # its engagement's start, whether it leads
PATIENCE = 40  # engagements after which the terminal cycle is looked for in any case


@jit(allocates=True)
def workspace(breaks):
    """Panel store and events, for `figures`."""
    return new_store(MAX_PANELS), np.empty((SEEN + 2 * most_events(breaks), EVENTS + 2))


@jit
def _judge(calls, events, i, calm, s, path, rho, mu, load, out):
    """Let one extremum of the transient decide on rise and settling time.

    Only the greatest and the least speed of an engagement tend to the terminal
    ones, so only they can unsettle a motion. Returns how many in a row did not.
    """
    final = out[V_MAX] if events[i, KIND] == MAXIMUM else out[V_MIN]
    error = abs(np.sqrt(events[i, SQUARE]) / final - 1.0)
    unsure = 0.5 * ROUGH  # of a speed: that of its square is twice as much
    if not (abs(error - RISE_BAND) > unsure and abs(error - SETTLING_BAND) > unsure):
        place(calls, events, i, s, path, rho, mu, load)
        error = abs(np.sqrt(events[i, SQUARE]) / final - 1.0)
    if np.isnan(out[RISE]) and error <= RISE_BAND:
        place(calls, events, i, s, path, rho, mu, load)
        out[RISE] = events[i, SINCE] + events[i, TIME]
    if not events[i, LEADING] > 0.0:
        return calm
    if error > SETTLING_BAND:
        out[SETTLING] = np.nan
        return 0
    if np.isnan(out[SETTLING]):
        place(calls, events, i, s, path, rho, mu, load)
        out[SETTLING] = events[i, SINCE] + events[i, TIME]
    return calm + 1


@jit
def _leads(calls, events, first, used, i, s, path, rho, mu, load):
    """Whether no other extremum of its kind in the engagement goes further."""
    for j in range(first, used):
        if j == i or events[j, KIND] != events[i, KIND]:
            continue
        if not abs(events[j, SQUARE] / events[i, SQUARE] - 1.0) > ROUGH:
            place(calls, events, i, s, path, rho, mu, load)
            place(calls, events, j, s, path, rho, mu, load)
        further = events[j, SQUARE] > events[i, SQUARE]
        if further == (events[i, KIND] == MAXIMUM) and events[j, SQUARE] != events[i, SQUARE]:
            return False
    return True


@jit
def figures(calls, cells, path, breaks, dwell, rho, mu, load, w, rtol, store, events, out):
    """Figures of merit of one case into out (natural units); returns the status.

    The motion is followed from its start until it has nearly settled, its
    extrema kept; Newton's method finds the terminal cycle from there;
    only a motion that settles slowly is followed again. On a stall out[0:2]
    holds its angle and the engagement.
    """
    for i in range(FIGURES):
        out[i] = np.nan
    last = cells.shape[0] - 1
    ends = (cells[0, 1, AT_ENDS], cells[last, 1, AT_ENDS + 3], 2.0 * dwell / rho)
    even = mu[0] == 0.0 and ends_alike(ends[0], ends[1], rho)
    if even and load == 0.0:
        return NO_TERMINAL
    loose, strict = tolerances(rtol)
    count = NO_PANELS
    time, rising = 0.0, 0.0
    first = NONE
    found, calm, sought = False, NONE, False
    before, better_before = w, w
    record = EXTREMA
    for k in range(MAX_ENGAGEMENTS):
        status, exit_w, length, exponent, source, _s, rising, count, used = march(
            calls, store, count, path, breaks, cells, rho, mu, load, w, 0.0, rising, loose, strict,
            record, events, first,
        )  # fmt: skip
        if status != OK:
            for i in range(FIGURES):
                out[i] = np.nan
            out[0], out[1] = exit_w, k
            return status
        if even:
            # every engagement adds the same energy: the load stops the motion, or nothing does
            return NO_TERMINAL if source + 2.0 * dwell > 0.0 else STALL
        if dwell > 0.0:
            if rising < 0.0:
                used = note(events, used, MINIMUM, breaks[-1], length, exit_w)
            rising = 1.0
        for i in range(first, used):
            if MINIMUM <= events[i, KIND] <= MAXIMUM:
                events[i, SINCE] = time
                events[i, LEADING] = _leads(
                    calls, events, first, used, i, store, path, rho, mu, load
                )
                if found:
                    calm = _judge(calls, events, i, calm, store, path, rho, mu, load, out)
        following, free = free_turn(exit_w, dwell, rho)
        time += length + free
        if not sought:
            turning = turned(events, first, used)
            first = used
            better, _shrink, sound = closer(w, exit_w, exponent, source, rho, ends, turning)
            # its entry speed is within twice the band: it may be the first that is settled
            settled = sound and abs(better - w) <= 4.0 * SETTLING_BAND * better
            if settled or k == PATIENCE or used + most_events(breaks) > events.shape[0]:
                start = better if better > 0.0 else following
                if sound and better > 0.0 and better_before != before:
                    start = beyond(w, better, before, better_before)
                status, count = terminal_cycle(
                    calls, store, count, cells, path, breaks, dwell, rho, mu, load, ends, start,
                    following, w, better, rtol, events, used, out,
                )  # fmt: skip
                sought, found = True, status == OK
                if status in (NOT_CONVERGED, NO_TERMINAL):
                    return status
                for i in range(used if found else 0):
                    if MINIMUM <= events[i, KIND] <= MAXIMUM:
                        calm = _judge(calls, events, i, calm, store, path, rho, mu, load, out)
                first = NONE
                # far too slow: the band shrinks to 2 % in log(0.02)/log(contraction) engagements
                if found and out[CONTRACTION] > 1.0 - 1.0 / MAX_ENGAGEMENTS:
                    return OK
            before, better_before = w, better
        w = following
        # motions do not cross: once both its extrema are within the band, so are all to come
        if found and calm >= 2:
            return OK
    # beyond the limit a time is not given
    out[SETTLING] = np.nan
    return OK if found else NOT_CONVERGED
