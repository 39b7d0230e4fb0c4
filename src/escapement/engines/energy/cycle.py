"""The cycle a motion ends in, as the fixed point of an engagement.

An engagement maps the squared handoff speed affinely once its reversals are
known, and to first order they do not move the result. Newton's method on the
fixed point is therefore the affine map's own fixed point, found again for the
reversals found: it converges quadratically, and its contraction is exact.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics import free_turn
from escapement.engines.energy.calls import march_case, place
from escapement.engines.energy.events import ROUGH, is_extremum, turned
from escapement.engines.energy.march import NO_TERMINAL, NOT_CONVERGED, OK, STALL
from escapement.engines.energy.panels import NO_PANELS, tolerances
from escapement.engines.energy.passage import Record, Request
from escapement.jit import inner_jit
from escapement.metrics import BOUNDLESS, MAX_ENGAGEMENTS

FIGURES = 7
V_MAX, V_MIN, PERIOD, RISE, SETTLING, W_HANDOFF, CONTRACTION = range(FIGURES)
NO_LOSS = 1e-12  # share of E below which what friction takes is not told from rounding
PATIENCE = 20  # engagements that are followed after Newton's method overshot into a stop


class Ends(NamedTuple):
    """g at entry and exit of an engagement, and what a dwell adds to w."""

    entry: float
    exit: float
    dwell: float


class Step(NamedTuple):
    """A step of Newton's method: w next tried, contraction of the map, whether to trust both."""

    w: float
    shrink: float
    sound: bool


class Steps(NamedTuple):
    """Two steps of Newton's method: from `w` to `better`; equal ones count for nothing."""

    w: float
    better: float


class Cycle(NamedTuple):
    """Status of the search for a terminal cycle, and how many panels there are."""

    status: int
    panels: int


@inner_jit
def closer(w, found, scene, ends, reversed_):
    """Fixed point of the affine map by which a march went from w to `found`.

    With E = (rho + g^2) w the gap 1 - shrink keeps its relative accuracy when next to
    nothing is lost. The step is not sound where the map has no fixed point to be trusted.
    """
    leave = scene.rho + ends.exit * ends.exit
    unequal = (ends.exit - ends.entry) * (ends.exit + ends.entry) / leave
    shrink = np.exp(-found.exponent) * (1.0 - unequal)
    gap = -np.expm1(-found.exponent) + np.exp(-found.exponent) * unequal
    following = found.w + ends.dwell
    if gap <= 0.0 or (gap <= NO_LOSS and not reversed_):
        # too slow for a pin reversal, friction only borrows: go where it takes
        return Step(4.0 * following if following > w else following, shrink, False)
    return Step((found.source / leave + ends.dwell) / gap, shrink, True)


@inner_jit
def beyond(w, better, before):
    """Fixed point from two steps of Newton's, whose errors go like the squares of what they had.

    The better of the two where they are too close for that.
    """
    was, now = before.w - better, w - better
    if now * now > 0.25 * was * was or abs(before.better - better) > abs(was):
        return better
    further = better - (before.better - better) * now * now / (was * was - now * now)
    return further if further > 0.0 else better


@inner_jit
def terminal_cycle(case, count, ends, w, last_good, before, rtol, first, out):
    """Terminal cycle by Newton's method from w; fills the columns of `out` but the times.

    Parameters
    ----------
    case : Case
    count : panels in use.
    ends : Ends
    last_good : w to go on from when Newton's method overshoots into a stop.
    before : `Steps` that led to w.
    first : events may be noted from row `first` on.

    Returns
    -------
    Cycle
    """
    scene, events = case.scene, case.events
    loose, strict = tolerances(rtol)
    plain, patience = 0, PATIENCE
    # a load often turns the pin twice inside a panel, which the map alone is blind for
    glance = np.int64(Record.MAP if scene.load == 0.0 else Record.TIME)
    near = False
    for _ in range(MAX_ENGAGEMENTS):
        record = np.int64(Record.EXTREMA) if near else glance
        request = Request(record, loose, strict)
        found = march_case(case, count, request, w, 0.0, first)
        count = found.panels
        if found.status == STALL and plain == 0:
            # follow the motion itself for a while, without the panels of that stop
            count = NO_PANELS
            w, plain, near, glance = last_good, patience, False, np.int64(Record.TIME)
            patience *= 2
            continue
        if found.status != OK:
            return Cycle(found.status, count)
        step = closer(w, found, scene, ends, turned(events, first, found.used))
        better = step.w
        last_good = found.w + ends.dwell
        change = abs(better - w)
        # small changes of a motion that is only followed prove nothing
        if near and step.sound and change <= 0.2 * rtol * w:
            _read(case, first, found, w, step, out)
            return Cycle(OK, count)
        if near or not step.sound:
            # should the map alone have been blind for something after all
            glance = np.int64(Record.TIME)
        if not step.sound and scene.path.table and w < last_good < (1.0 + BOUNDLESS) * w:
            return Cycle(NO_TERMINAL, count)
        # the next change is about the square of this one
        near = step.sound and change <= np.sqrt(0.02 * rtol) * w
        if plain > 0 or not better > 0.0:
            better = last_good
            near = False
            plain = max(plain - 1, 0)
        elif step.sound and before.better != before.w:
            following = beyond(w, better, before)
            before, w = Steps(w, better), following
            continue
        before = Steps(w, better)
        w = better
    return Cycle(NOT_CONVERGED, count)


@inner_jit
def _read(case, first, found, w, step, out):
    """Extremes of the speed, period, handoff and contraction of the cycle just marched."""
    fast, slow = max(w, found.w), min(w, found.w)
    for i in range(first, found.used):
        event = case.events[i]
        if not is_extremum(event):
            continue
        # only what may be the greatest or the least has to be exact
        if not slow * (1.0 + ROUGH) < event.w < fast * (1.0 - ROUGH):
            place(case.calls, case.scene, case.store, case.events, i)
        fast, slow = max(fast, event.w), min(slow, event.w)
    out[V_MAX], out[V_MIN] = np.sqrt(fast), np.sqrt(slow)
    out[PERIOD] = found.time + free_turn(found.w, case.scene)[1]
    out[W_HANDOFF], out[CONTRACTION] = step.w, step.shrink
