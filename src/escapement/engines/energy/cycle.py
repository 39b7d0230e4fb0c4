"""The terminal cycle, as the fixed point of the map from w before a round to w behind it.

A round is the engagement of a perfect wheel, or those of all pairs of pins and slots. The map is
affine as long as the reversals stay at their angles, and to first order their shifts do not
change the result. A step of Newton's method is therefore the fixed point of the affine map that
was found with the last reversals. The steps converge quadratically, and the contraction
dw_out/dw_in is that of the affine map, without an error.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import Event, is_extremum
from escapement.dynamics.figures_of_merit import BOUNDLESS, MAX_ENGAGEMENTS
from escapement.dynamics.law import is_drag_free
from escapement.dynamics.load import has_load_curve
from escapement.dynamics.torque import is_constant
from escapement.dynamics.train_losses import is_lossy
from escapement.engines.energy.leap import fall
from escapement.engines.energy.located_events import ROUGH_ERROR, has_reversal
from escapement.engines.energy.march import NO_TERMINAL, NOT_CONVERGED, OK, STALL
from escapement.engines.energy.pairs import (
    Start,
    lay_out_again,
    make_exact_in_round,
    pass_round,
    start_inertia,
)
from escapement.engines.energy.passage import Detail, request_of
from escapement.numerics.jit import inner_jit

COLUMNS = (
    *("velocity_max", "velocity_min", "period", "handoff_velocity", "contraction"),
    *("rise_time", "settling_time", "rise_time_63", "rise_time_98", "beat_error", "blow_max"),
)
"""Figures of merit that the kernels compute, in the order of their columns."""
FIGURES = len(COLUMNS)
(
    V_MAX, V_MIN, PERIOD, HANDOFF, CONTRACTION, RISE, SETTLING, RISE_63, RISE_98, BEAT_ERROR,
    BLOW_MAX,
) = range(FIGURES)  # fmt: skip
# A share of E lost by friction is rounding if it is below this.
NO_LOSS = 1e-12
# Number of rounds that are followed without Newton's method after it overshot into a stop.
FOLLOWED = 20
# A speed beyond the square root of this would grow without bound.
FASTEST = 1e30


class Step(NamedTuple):
    """A step of Newton's method: the w it leads to, dw_out/dw_in, and whether both are sound."""

    w: float
    contraction: float
    sound: bool


class Attempt(NamedTuple):
    """The last step of Newton's method, from `w` to `better`; equal numbers mean there is none."""

    w: float
    better: float


@inner_jit
def newton_step(w, found, has_reversed):
    """Fixed point of the affine map by which a round went from w to `found`.

    The gap, 1 - dw_out/dw_in, is computed from the exponent of the map without a difference,
    so that it is accurate even where friction takes very little. The step is not sound where
    the map has no fixed point, or where rounding alone makes one.
    """
    contraction, gap = np.exp(found.slope), -np.expm1(found.slope)
    if gap <= 0.0 or (gap <= NO_LOSS and not has_reversed):
        # Without a reversal s stays +1, and int B over the engagement is zero, since g' changes
        # sign at dead centre: the map then has no fixed point. Where the motion gains speed,
        # one twice as fast is tried, which may have a reversal.
        return Step(4.0 * found.w if found.w > w else found.w, contraction, False)
    # solve w = w - gap w + source
    return Step(found.source / gap, contraction, True)


@inner_jit
def extrapolate(w, better, before):
    """Fixed point extrapolated from two steps of Newton's method.

    The error after a step is proportional to the square of the error before it. If the second
    step was not much shorter than the first, `better` is returned unchanged.
    """
    # the errors before the two steps, measured from the best w that is known
    was, now = before.w - better, w - better
    if now * now > 0.25 * was * was or abs(before.better - better) > abs(was):
        return better
    # the line through both results over the squared errors, read at zero
    further = better - (before.better - better) * now * now / (was * was - now * now)
    return further if further > 0.0 else better


@inner_jit
def terminal_cycle(case, start, last_good, before, rtol, rows, out):
    """Terminal cycle by Newton's method; fills `out` except for the times of the transient.

    Parameters
    ----------
    case : MarchInputs
    start : `Start` with the w from which to search, and what is thought to be the sign of
        theta_ddot before a round of the cycle.
    last_good : w from which to go on when Newton's method overshoots into a stop.
    before : the `Attempt` that led to w.
    rows : memory of a leap.

    Returns
    -------
    int
        Status of the search.
    """
    scene, w, first, rising = case.scene, start.w, start.first, start.rising
    to_follow, longer = 0, FOLLOWED
    # with a load or drag two reversals may lie in one panel, and a march for the map misses them
    alone = scene.load == 0.0 and is_drag_free(scene) and not is_lossy(scene)
    alone = alone and not has_load_curve(scene) and is_constant(scene)
    far_detail = Detail.MAP if alone else Detail.TIME
    near = False
    for _ in range(MAX_ENGAGEMENTS):
        request = request_of(Detail.EXTREMA if near else far_detail, rtol)
        found = pass_round(case, Start(w, rising, first), request)
        if found.status == STALL and to_follow == 0:
            # follow the motion itself for a while, and drop the many panels that the stop made;
            # should Newton's method overshoot again, follow it for twice as long
            lay_out_again(case)
            w, to_follow, near, far_detail = last_good, longer, False, Detail.TIME
            longer *= 2
            continue
        if found.status != OK:
            return found.status
        step = newton_step(w, found, has_reversal(case.events, first, found.used))
        better = step.w
        last_good = found.w
        change = abs(better - w)
        # only a step of Newton's method proves convergence: a motion that is followed changes
        # little in every engagement when the contraction is nearly 1
        if near and step.sound and change <= 0.2 * rtol * w:
            if found.rising != rising:
                # a round of the cycle begins as it ends, which decides on an extremum at its start
                found = pass_round(case, Start(w, found.rising, first), request)
            _read(case, first, found, w, step, out)
            return OK
        if near or not step.sound:
            # the map may be wrong because of a pair of reversals that it missed
            far_detail = Detail.TIME
        boundless = scene.path.table and w < last_good < (1.0 + BOUNDLESS) * w
        if not step.sound and (boundless or better > FASTEST):
            return NO_TERMINAL
        # the error is squared by every step, so the next change will be below the tolerance
        near = step.sound and change <= np.sqrt(0.02 * rtol) * w
        if to_follow > 0 or not better > 0.0:
            passed = fall(case, request, last_good, step, MAX_ENGAGEMENTS, rows)
            if passed.number > 0:
                lay_out_again(case)
            better = last_good = passed.w
            near = False
            to_follow = max(to_follow - 1, 0)
        elif step.sound and before.better != before.w:
            following = extrapolate(w, better, before)
            before, w = Attempt(w, better), following
            continue
        before = Attempt(w, better)
        w = better
    return NOT_CONVERGED


@inner_jit
def _read(case, first, found, w, step, out):
    """Read the figures of the cycle just passed from w, and what each pair has of it."""
    data, size = case.data, case.data.size
    for index in range(size):
        data[index].top, data[index].low = np.nan, np.nan
        data[index].final = np.sqrt(data[index].after if index < size - 1 else step.w)
    for i in range(first, found.used):
        _read_extremum(case, i)
    fast, slow, shortest, longest, blow = np.sqrt(w), np.sqrt(w), np.inf, 0.0, 0.0
    for index in range(size):
        one, following = data[index], (index + 1) % size
        # a comparison with NaN, where there is none, is false
        fast = max(fast, np.sqrt(one.before), one.top if one.top > fast else fast)
        slow = min(slow, np.sqrt(one.after), one.low if one.low < slow else slow)
        shortest, longest = min(shortest, one.time), max(longest, one.time)
        if one.share < 1.0:
            left = start_inertia(case, following) * one.after
            blow = max(blow, 0.5 * (case.scene.rho * one.before - left))
    out[V_MAX], out[V_MIN] = fast, slow
    out[PERIOD] = found.time / size
    out[HANDOFF], out[CONTRACTION] = np.sqrt(step.w), step.contraction
    out[BEAT_ERROR], out[BLOW_MAX] = longest - shortest, blow


@inner_jit
def _read_extremum(case, i):
    """Note event i of the cycle where it is the outermost of its kind and pair so far."""
    event = case.events[i]
    if not is_extremum(event.kind):
        return
    one, highest = case.data[event.index], event.kind == Event.MAXIMUM
    known = one.top if highest else one.low
    # only an extremum that may be the greatest or the least has to be exact
    ratio = np.sqrt(event.w) / known
    if not (ratio < 1.0 - ROUGH_ERROR if highest else ratio > 1.0 + ROUGH_ERROR):
        make_exact_in_round(case, i)
    speed = np.sqrt(event.w)
    if highest:
        one.top = known if speed < known else speed
    else:
        one.low = known if speed > known else speed
