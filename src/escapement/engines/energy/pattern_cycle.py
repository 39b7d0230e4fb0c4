"""The terminal cycle of a pattern of engagements, as the fixed point of its map of w.

The map over all engagements is like that over one: affine as long as the reversals stay at their
angles. Newton's method finds the fixed point as `cycle` does.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import Event, is_extremum
from escapement.dynamics.figures_of_merit import MAX_ENGAGEMENTS
from escapement.dynamics.law import is_drag_free, is_felt
from escapement.engines.energy.cycle import NO_LOSS
from escapement.engines.energy.march import NO_TERMINAL, NOT_CONVERGED, OK
from escapement.engines.energy.passage import Detail, request_of, with_detail
from escapement.engines.energy.pattern_march import engage, scene_in
from escapement.numerics.jit import inner_jit

# Number of steps of Newton's method that are taken from one speed of the motion.
MOST_STEPS = 25


class Round(NamedTuple):
    """One passage of the pattern from w_in in a time, and the map w = exp(slope) w_in + source.

    Of a stall `angle` is the driver angle, and `pair_index` the engagement. `rising` is the sign of
    theta_ddot at the end, with a `Detail` that tells it.
    """

    status: int
    w: float
    slope: float
    source: float
    pair_index: int
    angle: float
    rising: float
    time: float


@inner_jit(inlined=True)
def completed(w, slope, source, rising, time):
    """The round that ends with w."""
    return Round(
        status=OK,
        w=w,
        slope=slope,
        source=source,
        pair_index=0,
        angle=0.0,
        rising=rising,
        time=time,
    )


@inner_jit(inlined=True)
def stopped(found, index, time):
    """The round that a march ends in the engagement at a place."""
    return Round(
        status=found.status, w=0.0, slope=0.0, source=0.0, pair_index=index, angle=found.angle,
        rising=0.0, time=time,
    )  # fmt: skip


@inner_jit
def rising_after(case, index, found):
    """Sign of theta_ddot before an engagement, from the march over the one at `index` before it."""
    return -1.0 if is_felt(case.shares[index]) else found.rising


@inner_jit
def pass_round(case, w, request):
    """Pass all engagements of the pattern, and note what `Finals` holds if extrema are noted."""
    slope, source, rising, time = 0.0, 0.0, 0.0, 0.0
    for index in range(case.pairs.size):
        found = engage(case, index, w, rising, request)
        if found.status != OK:
            return stopped(found, index, time)
        w = found.w * case.shares[index] ** 2
        change = case.slopes[index] - found.exponent
        slope, source = slope + change, np.exp(change) * source + case.gains[index] * found.source
        rising, time = rising_after(case, index, found), time + found.time
        if request.detail >= Detail.EXTREMA:
            _note_finals(case, index, found)
    return completed(w, slope, source, rising, time)


@inner_jit
def _note_finals(case, index, found):
    """Note what `Finals` holds of an engagement just marched."""
    top, low = outermost(case, found, case.shares[index])
    finals = case.finals
    finals.low[index] = np.nan if low < 0 else speed_at(case, found, low)
    finals.top[index] = np.nan if top < 0 else speed_at(case, found, top)
    finals.time[index], finals.before[index] = found.time, found.w
    finals.after[index] = found.w * case.shares[index] ** 2


@inner_jit
def extrema_of(found, share):
    """Number of events of an engagement, a fall by an impact at its end included as the last."""
    return found.used + 1 if is_felt(share) and found.rising > 0.0 else found.used


@inner_jit
def is_top(case, found, i):
    """Whether event i of an engagement is a maximum; the speed is one before an impact."""
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
        stall the index comes last.
    """
    scene = scene_in(case.shared, case.pairs[0])
    # as for one engagement: the map alone misses a pair of reversals where there is a load or drag
    alone = scene.load == 0.0 and is_drag_free(scene)
    request = request_of(Detail.MAP if alone else Detail.TIME, rtol)
    size, next_try = case.pairs.size, 1
    for k in range(1, MAX_ENGAGEMENTS):
        found = pass_round(case, w, request)
        if found.status != OK:
            return found.status, 0.0, 0.0, found.angle, (k - 1) * size + found.pair_index
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
            far = Detail.TIME if near else far
            # the error is squared by every step, so the next change will be below the tolerance
            near = change <= np.sqrt(0.02 * rtol) * w
        if not better > 0.0:
            break
        w = better
        found = pass_round(case, w, with_detail(request, Detail.EXTREMA if near else far))
        if found.status != OK:
            break
    return w, 0.0, NOT_CONVERGED


@inner_jit
def _begin_again(case, w, rising, request):
    """March over the first engagement again, now that theta_ddot before it is known."""
    found = engage(case, 0, w, rising, with_detail(request, Detail.EXTREMA))
    _note_finals(case, 0, found)
