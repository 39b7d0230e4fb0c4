"""The terminal cycle, as the fixed point of the map from w at one handoff to w at the next.

The map is affine as long as the reversals stay at their angles, and to first order their
shifts do not change the result. A step of Newton's method is therefore the fixed point of the
affine map that was found with the last reversals. The steps converge quadratically, and the
contraction dw_out/dw_in is that of the affine map, without an error.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import is_extremum
from escapement.dynamics.figures_of_merit import BOUNDLESS, MAX_ENGAGEMENTS
from escapement.dynamics.law import is_drag_free
from escapement.dynamics.train_losses import is_lossy
from escapement.engines.energy.calls import march_case, refine
from escapement.engines.energy.located_events import ROUGH_ERROR, has_reversal
from escapement.engines.energy.march import NO_TERMINAL, NOT_CONVERGED, OK, STALL
from escapement.engines.energy.panels import NO_PANELS
from escapement.engines.energy.passage import Detail, request_of
from escapement.mechanisms.slotted import transmission_at
from escapement.numerics.jit import inner_jit

COLUMNS = (
    *("velocity_max", "velocity_min", "period", "handoff_velocity", "contraction"),
    *("rise_time", "settling_time", "rise_time_63", "rise_time_98"),
)
"""Figures of merit that the kernels compute, in the order of their columns."""
FIGURES = len(COLUMNS)
V_MAX, V_MIN, PERIOD, HANDOFF, CONTRACTION, RISE, SETTLING, RISE_63, RISE_98 = range(FIGURES)
# A share of E lost by friction is rounding if it is below this.
NO_LOSS = 1e-12
# Number of engagements that are followed without Newton's method after it overshot into a stop.
FOLLOWED = 20


class Ends(NamedTuple):
    """g at the entry and the exit of an engagement."""

    entry: float
    exit: float


@inner_jit
def ends_of(scene):
    """`Ends` of a scene."""
    entry, exit_ = scene.edges[0], scene.edges[-1]
    return Ends(transmission_at(scene.path, entry)[0], transmission_at(scene.path, exit_)[0])


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
def map_of(found, scene, ends):
    """Slope of the affine map of w, 1 minus this, and the offset, from what a march has `found`."""
    # in a published cell g differs between entry and exit: w_out (rho + g_out^2) =
    # exp(-exponent) w_in (rho + g_in^2) + source has the slope exp(-exponent) (1 - unequal)
    leave = scene.rho + ends.exit * ends.exit
    unequal = (ends.exit - ends.entry) * (ends.exit + ends.entry) / leave
    gap = -np.expm1(-found.exponent) + np.exp(-found.exponent) * unequal
    return np.exp(-found.exponent) * (1.0 - unequal), gap, found.source / leave


@inner_jit
def newton_step(w, found, scene, ends, has_reversed):
    """Fixed point of the affine map by which a march went from w to `found`.

    The gap, 1 - dw_out/dw_in, is computed from the exponent of the map of E without a
    difference, so that it is accurate even where friction takes very little. The step is not
    sound where the map has no fixed point, or where rounding alone makes one.
    """
    contraction, gap, offset = map_of(found, scene, ends)
    if gap <= 0.0 or (gap <= NO_LOSS and not has_reversed):
        # Without a reversal s stays +1, and int B over the engagement is zero, since g' changes
        # sign at dead centre: the map then has no fixed point. Where the motion gains speed,
        # one twice as fast is tried, which may have a reversal.
        return Step(4.0 * found.w if found.w > w else found.w, contraction, False)
    # solve w = w - gap w + offset
    return Step(offset / gap, contraction, True)


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
def terminal_cycle(case, count, ends, w, last_good, before, rtol, first, out):
    """Terminal cycle by Newton's method from w; fills `out` except for the times of the transient.

    Parameters
    ----------
    case : MarchInputs
    count : number of panels in use.
    ends : Ends
    last_good : w from which to go on when Newton's method overshoots into a stop.
    before : the `Attempt` that led to w.
    first : row from which on events may be noted.

    Returns
    -------
    status, panels : of the search, and number of panels in use.
    """
    scene, events = case.scene, case.events
    to_follow, longer = 0, FOLLOWED
    # with a load or drag two reversals may lie in one panel, and a march for the map misses them
    alone = scene.load == 0.0 and is_drag_free(scene) and not is_lossy(scene)
    far_detail = Detail.MAP if alone else Detail.TIME
    near = False
    for _ in range(MAX_ENGAGEMENTS):
        request = request_of(Detail.EXTREMA if near else far_detail, rtol)
        found = march_case(case, count, request, w, 0.0, first)
        count = found.panels
        if found.status == STALL and to_follow == 0:
            # follow the motion itself for a while, and drop the many panels that the stop made;
            # should Newton's method overshoot again, follow it for twice as long
            count = NO_PANELS
            w, to_follow, near, far_detail = last_good, longer, False, Detail.TIME
            longer *= 2
            continue
        if found.status != OK:
            return found.status, count
        step = newton_step(w, found, scene, ends, has_reversal(events, first, found.used))
        better = step.w
        last_good = found.w
        change = abs(better - w)
        # only a step of Newton's method proves convergence: a motion that is followed changes
        # little in every engagement when the contraction is nearly 1
        if near and step.sound and change <= 0.2 * rtol * w:
            _read(case, first, found, w, step, out)
            return OK, count
        if near or not step.sound:
            # the map may be wrong because of a pair of reversals that it missed
            far_detail = Detail.TIME
        if not step.sound and scene.path.table and w < last_good < (1.0 + BOUNDLESS) * w:
            return NO_TERMINAL, count
        # the error is squared by every step, so the next change will be below the tolerance
        near = step.sound and change <= np.sqrt(0.02 * rtol) * w
        if to_follow > 0 or not better > 0.0:
            better = last_good
            near = False
            to_follow = max(to_follow - 1, 0)
        elif step.sound and before.better != before.w:
            following = extrapolate(w, better, before)
            before, w = Attempt(w, better), following
            continue
        before = Attempt(w, better)
        w = better
    return NOT_CONVERGED, count


@inner_jit
def _read(case, first, found, w, step, out):
    """Read extreme speeds, period, handoff and contraction from the cycle just marched."""
    fast, slow = max(w, found.w), min(w, found.w)
    for i in range(first, found.used):
        event = case.events[i]
        if not is_extremum(event.kind):
            continue
        # only an extremum that may be the greatest or the least has to be exact
        if not slow * (1.0 + ROUGH_ERROR) < event.w < fast * (1.0 - ROUGH_ERROR):
            refine(case.addresses, case.scene, case.store, case.events, i)
        fast, slow = max(fast, event.w), min(slow, event.w)
    out[V_MAX], out[V_MIN] = np.sqrt(fast), np.sqrt(slow)
    out[PERIOD] = found.time
    out[HANDOFF], out[CONTRACTION] = np.sqrt(step.w), step.contraction
