"""Figures of merit of a case: its transient, and the cycle that ends in."""

import numpy as np

from escapement.dynamics import dwell_gain, ends_alike, free_turn
from escapement.engines.energy.calls import march_case, place
from escapement.engines.energy.cycle import (
    CONTRACTION,
    FIGURES,
    RISE,
    SETTLING,
    V_MAX,
    V_MIN,
    Ends,
    Steps,
    beyond,
    closer,
    terminal_cycle,
)
from escapement.engines.energy.events import (
    EVENT,
    NONE,
    ROUGH,
    EventKind,
    is_extremum,
    most_events,
    note,
    turned,
)
from escapement.engines.energy.march import NO_TERMINAL, NOT_CONVERGED, OK, STALL
from escapement.engines.energy.panels import MAX_PANELS, NO_PANELS, new_store, tolerances
from escapement.engines.energy.passage import Record, Request
from escapement.jit import inner_jit
from escapement.metrics import MAX_ENGAGEMENTS, RISE_BAND, SETTLING_BAND

SEEN = 256  # events of a transient that are kept
PATIENCE = 40  # engagements after which the terminal cycle is looked for in any case


@inner_jit(allocates=True)
def workspace(edges):
    """Panel store and events, for `figures`."""
    return new_store(MAX_PANELS), np.empty(SEEN + 2 * most_events(edges), EVENT)


@inner_jit
def figures(case, w, rtol, out):
    """Figures of merit of one case into out (natural units); returns the status.

    The motion is followed from its start until it has nearly settled, its
    extrema kept; Newton's method finds the terminal cycle from there;
    only a motion that settles slowly is followed again. On a stall out[0:2]
    holds its angle and the engagement.
    """
    scene, cells, events = case.scene, case.cells, case.events
    for i in range(FIGURES):
        out[i] = np.nan
    last = cells.shape[0] - 1
    ends = Ends(cells[0, 1].entry.g, cells[last, 1].exit.g, dwell_gain(scene))
    even = scene.mu_plus == 0.0 and ends_alike(ends.entry, ends.exit, scene.rho)
    if even and scene.load == 0.0:
        return NO_TERMINAL
    loose, strict = tolerances(rtol)
    request = Request(np.int64(Record.EXTREMA), loose, strict)
    count, first, calm = NO_PANELS, NONE, NONE
    time, rising = 0.0, 0.0
    cycle_known, sought = False, False
    before = Steps(w, w)
    for k in range(MAX_ENGAGEMENTS):
        found = march_case(case, count, request, w, rising, first)
        count = found.panels
        if found.status != OK:
            return _stopped(found, k, out)
        if even:
            # every engagement adds the same energy: the load stops the motion, or nothing does
            return NO_TERMINAL if found.source + scene.rho * dwell_gain(scene) > 0.0 else STALL
        used, rising = _enter_dwell(scene, events, found)
        _complete(case, first, used, time)
        if cycle_known:
            calm = _judge(case, first, used, calm, out)
        following, free = free_turn(found.w, scene)
        time += found.time + free
        if not sought:
            step = closer(w, found, scene, ends, turned(events, first, used))
            first = used
            if _worth_seeking(scene, w, step, k, used, events):
                start = _first_guess(w, step, before, following)
                steps = Steps(w, step.w)
                cycle = terminal_cycle(case, count, ends, start, following, steps, rtol, used, out)
                sought, cycle_known, count = True, cycle.status == OK, cycle.panels
                if cycle.status in (NOT_CONVERGED, NO_TERMINAL):
                    return cycle.status
                first = NONE
                if cycle_known:
                    calm = _judge(case, first, used, calm, out)
                    # far too slow: the band shrinks to 2 % in log(0.02)/log(contraction) turns
                    if out[CONTRACTION] > 1.0 - 1.0 / MAX_ENGAGEMENTS:
                        return OK
            before = Steps(w, step.w)
        w = following
        # motions do not cross: once both its extrema are within the band, so are all to come
        if cycle_known and calm >= 2:
            return OK
    # beyond the limit a time is not given
    out[SETTLING] = np.nan
    return OK if cycle_known else NOT_CONVERGED


@inner_jit
def _enter_dwell(scene, events, found):
    """Note a minimum where a dwell begins, from which on the driver gains speed.

    Returns
    -------
    used, rising : how many events are noted, and the sign of the acceleration.
    """
    if scene.dwell == 0.0:
        return found.used, found.rising
    used = found.used
    if found.rising < 0.0:
        kind = np.int64(EventKind.MINIMUM)
        used = note(events, used, kind, scene.edges[-1], found.time, found.w)
    return used, 1.0


@inner_jit
def _first_guess(w, step, before, following):
    """Squared speed from which the terminal cycle is looked for."""
    if not step.w > 0.0:
        return following
    if step.sound and before.better != before.w:
        return beyond(w, step.w, before)
    return step.w


@inner_jit
def _stopped(found, k, out):
    """Leave the place of a stall; returns the status."""
    for i in range(FIGURES):
        out[i] = np.nan
    out[0], out[1] = found.angle, k
    return found.status


@inner_jit
def _worth_seeking(scene, w, step, k, used, events):
    """Whether the terminal cycle is looked for after engagement k.

    From an entry speed within twice the band on, which may be the first that is settled;
    and when patience or room for events runs out.
    """
    settled = step.sound and abs(step.w - w) <= 4.0 * SETTLING_BAND * step.w
    return settled or k == PATIENCE or used + most_events(scene.edges) > events.shape[0]


@inner_jit
def _complete(case, first, used, time):
    """Tell the extrema of an engagement when that began, and which of them lead."""
    events = case.events
    for i in range(first, used):
        if is_extremum(events[i]):
            events[i].since = time
            events[i].leading = _leads(case, first, used, i)


@inner_jit
def _leads(case, first, used, i):
    """Whether no other extremum of its kind in the engagement goes further."""
    event = case.events[i]
    for j in range(first, used):
        other = case.events[j]
        if j == i or other.kind != event.kind:
            continue
        if not abs(other.w / event.w - 1.0) > ROUGH:
            place(case.calls, case.scene, case.store, case.events, i)
            place(case.calls, case.scene, case.store, case.events, j)
        further = other.w > event.w
        if further == (event.kind == EventKind.MAXIMUM) and other.w != event.w:
            return False
    return True


@inner_jit
def _judge(case, first, used, calm, out):
    """Let extrema of the transient decide on rise and settling time.

    Only the greatest and the least speed of an engagement tend to the terminal
    ones, so only they can unsettle a motion. Returns how many in a row did not.
    """
    for i in range(first, used):
        if is_extremum(case.events[i]):
            calm = _judge_one(case, i, calm, out)
    return calm


@inner_jit
def _judge_one(case, i, calm, out):
    """The same of one extremum."""
    event = case.events[i]
    final = out[V_MAX] if event.kind == EventKind.MAXIMUM else out[V_MIN]
    error = abs(np.sqrt(event.w) / final - 1.0)
    unsure = 0.5 * ROUGH  # of a speed: that of its square is twice as much
    if not (abs(error - RISE_BAND) > unsure and abs(error - SETTLING_BAND) > unsure):
        place(case.calls, case.scene, case.store, case.events, i)
        error = abs(np.sqrt(event.w) / final - 1.0)
    if np.isnan(out[RISE]) and error <= RISE_BAND:
        place(case.calls, case.scene, case.store, case.events, i)
        out[RISE] = event.since + event.time
    if not event.leading:
        return calm
    if error > SETTLING_BAND:
        out[SETTLING] = np.nan
        return NONE
    if np.isnan(out[SETTLING]):
        place(case.calls, case.scene, case.store, case.events, i)
        out[SETTLING] = event.since + event.time
    return calm + 1
