"""The terminal cycle of a pattern of engagements, as the fixed point of its map of w.

The map over all engagements is like that over one: affine as long as the reversals stay at their
angles. Newton's method finds the fixed point as `cycle` does.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import Event, is_extremum
from escapement.dynamics.figures_of_merit import MAX_ENGAGEMENTS
from escapement.dynamics.law import is_drag_free
from escapement.engines.energy.cycle import NO_LOSS
from escapement.engines.energy.march import NO_TERMINAL, NOT_CONVERGED, OK
from escapement.engines.energy.panels import tolerances
from escapement.engines.energy.passage import Detail, Request
from escapement.engines.energy.pattern import engage, scene_in
from escapement.numerics.jit import inner_jit

# Number of steps of Newton's method that are taken from one speed of the motion.
MOST_STEPS = 25


class Round(NamedTuple):
    """One passage of the pattern from w_in, and the map w = exp(slope) w_in + source.

    Of a stall `angle` is the driver angle, and `place` the engagement. `rising` is the sign of
    theta_ddot at the end, with a `Detail` that tells it.
    """

    status: int
    w: float
    slope: float
    source: float
    place: int
    angle: float
    rising: float


@inner_jit
def rising_after(case, place, found):
    """Sign of theta_ddot before an engagement, from the march over the one at `place` before it."""
    return -1.0 if case.shares[place] < 1.0 else found.rising


@inner_jit
def _pass(case, w, request):
    """Pass all engagements of the pattern, and note what `Finals` holds if extrema are told."""
    slope, source, rising = 0.0, 0.0, 0.0
    for place in range(case.meetings.size):
        found = engage(case, place, w, rising, request)
        if found.status != OK:
            return Round(found.status, w, slope, source, place, found.angle, 0.0)
        w = found.w * case.shares[place] ** 2
        change = case.slopes[place] - found.exponent
        slope, source = slope + change, np.exp(change) * source + case.gains[place] * found.source
        rising = rising_after(case, place, found)
        if request.detail >= Detail.EXTREMA:
            _note_finals(case, place, found)
    return Round(OK, w, slope, source, 0, 0.0, rising)


@inner_jit
def _note_finals(case, place, found):
    """Note what `Finals` holds of an engagement just marched."""
    top, low = outermost(case, found, case.shares[place])
    finals = case.finals
    finals.low[place] = np.nan if low < 0 else speed_at(case, found, low)
    finals.top[place] = np.nan if top < 0 else speed_at(case, found, top)
    finals.time[place], finals.before[place] = found.time, found.w
    finals.after[place] = found.w * case.shares[place] ** 2


@inner_jit
def extrema_of(found, share):
    """Number of events of an engagement, a fall by a blow at its end included as the last."""
    return found.used + 1 if share < 1.0 and found.rising > 0.0 else found.used


@inner_jit
def is_top(case, found, i):
    """Whether event i of an engagement is a maximum; the speed is one before a blow."""
    return i == found.used or case.events[i].kind == Event.MAXIMUM


@inner_jit
def is_turn(case, found, i):
    """Whether event i of an engagement is an extremum."""
    return i == found.used or is_extremum(case.events[i].kind)


@inner_jit
def speed_at(case, found, i):
    """Driver speed at event i of an engagement."""
    return np.sqrt(found.w if i == found.used else case.events[i].w)


@inner_jit
def outermost(case, found, share):
    """Events that are the greatest maximum and the least minimum of an engagement, -1 if none."""
    top, low = -1, -1
    for i in range(extrema_of(found, share)):
        if not is_turn(case, found, i):
            continue
        speed = speed_at(case, found, i)
        if is_top(case, found, i):
            top = i if top < 0 or speed > speed_at(case, found, top) else top
        else:
            low = i if low < 0 or speed < speed_at(case, found, low) else low
    return top, low


@inner_jit
def find_cycle(case, w, rtol):
    """The w with which the pattern begins in the terminal cycle, from a motion that starts with w.

    The motion itself is followed, and after 1, 2, 4, .. rounds Newton's method is tried from
    there, so that a motion that stalls on the way to its terminal cycle is detected.

    Returns
    -------
    status, w, slope, angle, engagement
        `slope` is log(dw_out/dw_in) over the pattern, and `case.finals` has its engagements. Of a
        stall the place comes last.
    """
    loose, strict = tolerances(rtol)
    scene = scene_in(case.shared, case.meetings[0])
    # as for one engagement: the map alone misses a pair of reversals where there is a load or drag
    alone = scene.load == 0.0 and is_drag_free(scene)
    request = Request(np.int64(Detail.MAP if alone else Detail.TIME), loose, strict)
    size, next_try = case.meetings.size, 1
    for k in range(1, MAX_ENGAGEMENTS):
        found = _pass(case, w, request)
        if found.status != OK:
            return found.status, 0.0, 0.0, found.angle, (k - 1) * size + found.place
        if k == next_try:
            next_try *= 2
            better, slope, status = _seek(case, w, found, rtol, request)
            if status != NOT_CONVERGED:
                return status, better, slope, 0.0, 0
        w = found.w
    return NOT_CONVERGED, 0.0, 0.0, 0.0, 0


@inner_jit
def _seek(case, w, found, rtol, request):
    """Newton's method for the fixed point, from w, which the pattern maps to `found.w`.

    Returns the fixed point, the log of the slope there, and the status.
    """
    far, near = request.detail, False
    for _ in range(MOST_STEPS):
        gap = -np.expm1(found.slope)
        if gap <= NO_LOSS:
            # as for one engagement: without a reversal the map has no fixed point
            better = 4.0 * found.w
            if better > 1e30 or not found.w > w:
                return w, 0.0, NO_TERMINAL if found.w > w else NOT_CONVERGED
            near = False
        else:
            better = found.source / gap
            change = abs(better - w)
            if near and change <= 0.2 * rtol * w:
                _begin_again(case, w, found.rising, request)
                return better, found.slope, OK
            # the map may have missed a pair of reversals
            far = np.int64(Detail.TIME) if near else far
            # the error is squared by every step, so the next change will be below the tolerance
            near = change <= np.sqrt(0.02 * rtol) * w
        if not better > 0.0:
            break
        w = better
        detail = np.int64(Detail.EXTREMA) if near else far
        found = _pass(case, w, Request(detail, request.loose, request.strict))
        if found.status != OK:
            break
    return w, 0.0, NOT_CONVERGED


@inner_jit
def _begin_again(case, w, rising, request):
    """March over the first engagement again, now that theta_ddot before it is known."""
    detail = np.int64(Detail.EXTREMA)
    found = engage(case, 0, w, rising, Request(detail, request.loose, request.strict))
    _note_finals(case, 0, found)
