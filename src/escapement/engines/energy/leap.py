"""Many engagements of a slow transient at once, where one hardly changes the speed.

With few losses it takes up to a million engagements until the terminal cycle is near. The map of
a round, w + h(w), is the flow of dw/dk = v(w) over one round. Up to the fourth order in h/w, with
the gap gamma = -h',

    v = h [-log(1 - gamma)/gamma + (1 + 2 gamma) h h''/12]

so that k = int dw/v rounds pass. By Euler and Maclaurin their times T add up to
int T dk - [T]/2 + [dT/dk]/12; in the last term T goes with 1/sqrt(w). Both integrals run over
16 Gauss points, a round each. The coordinate is log q, where q is the distance from the
terminal w over the smaller of both. A motion that has no terminal cycle and stalls tends to
w = 0, with q = w.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.train_losses import is_lossy
from escapement.engines.energy.locate import invert, weights_to
from escapement.engines.energy.located_events import NO_EVENTS
from escapement.engines.energy.march import OK
from escapement.engines.energy.pairs import Start, lay_out_again, pass_round
from escapement.engines.energy.panels import points_of
from escapement.numerics.gauss import POINTS, N, cumulate, dot, integral, tail_of
from escapement.numerics.jit import inner_jit

# Rounds that change w by more than this share, or contract it by more, are marched. A march with
# trains that lose power takes so much longer that a greater share pays; times then have errors of
# up to 3e-9.
GENTLE, GENTLE_TRAINS = 3e-3, 7e-3
# A leap over fewer engagements is not worth while.
WORTH = 64
# A leap goes this share of the distance to its goal, and the rest is marched.
SHARE = 0.9
# The greatest change of log q in a leap.
WIDEST = 1.0
# So often a leap that fails is tried over a quarter of its length.
SHORTER = 6
# The share that the series of a leap may miss.
ROUGHEST = 1e-9
GAIN, GAP, SLOPE, TIME, GOALS = range(5)
"""Rows of a leap: h, gamma, the derivative of w by the coordinate x, T, and goals of `figures`."""
ROWS = 5


class Leap(NamedTuple):
    """Number of engagements passed, 0 where it is no use; w behind them, and their time."""

    number: int
    w: float
    time: float


@inner_jit
def distance(w, final):
    """log q of w."""
    return np.log(abs(final - w) / min(w, final)) if final > 0.0 else np.log(w)


@inner_jit
def is_gentle(scene, w, step):
    """Whether a round hardly changes w; `step` is that of Newton's method from w."""
    gap, most = 1.0 - step.contraction, GENTLE_TRAINS if is_lossy(scene) else GENTLE
    return step.sound and gap < most and abs(step.w - w) * gap < most * w


@inner_jit
def is_worth_it(w, gap, final, goal):
    """Whether many engagements pass up to the goal, where one contracts w by `gap`."""
    apart = distance(w, final) - distance(goal, final)
    return SHARE * apart > WORTH * gap * max(1.0, final / w)


@inner_jit
def half_way(w, final, goal):
    """Half of the change of log q in a leap from w towards `goal`."""
    return -0.5 * min(SHARE * (distance(w, final) - distance(goal, final)), WIDEST)


@inner_jit
def point_of(i, w, final, half):
    """w at the Gauss point i of a leap from w, and its derivative by x."""
    z = distance(w, final) + half + half * POINTS[i]
    below = w < final
    here = _at(z, below, final)
    if final == 0.0:
        return here, half * here
    return here, half * np.exp(z) * (-here * here / final if below else final)


@inner_jit
def leap(case, request, w, final, goal, most, rows):
    """Leap from w towards `goal`, which lies before the terminal w, `final`.

    At most `most` rounds are passed; `rows` is memory of shape (ROWS, N).
    """
    lay_out_again(case)
    none, half = Leap(0, w, 0.0), half_way(w, final, goal)
    for _ in range(SHORTER):
        sound = _fill(case, request, w, final, half, rows)
        if sound:
            found = pass_over(case.store.workspace[0], w, final, half, most, rows)
            if found.number > 0:
                return found
        # where the powers in trains turn round, h has a kink: leap up to it
        half *= 0.25
        if not abs(half) > WORTH * rows[GAP, 0]:
            break
    return none


@inner_jit
def _fill(case, request, w, final, half, rows):
    """Fill the rows of a leap from w; returns whether all rounds are sound."""
    for i in range(N):
        here, rows[SLOPE, i] = point_of(i, w, final, half)
        found = pass_round(case, Start(here, 0.0, NO_EVENTS), request)
        gap = -np.expm1(found.slope)
        if found.status != OK or not gap > 0.0:
            return False
        rows[GAIN, i], rows[GAP, i], rows[TIME, i] = found.source - gap * here, gap, found.time
    return True


@inner_jit
def fall(case, request, w, step, most, rows):
    """Leap of a motion without a terminal cycle, which loses speed until it stalls.

    `step` is that of Newton's method from w, and `most` and `rows` are those of `leap`.
    """
    if step.w > 0.0 or not is_gentle(case.scene, w, step):
        return Leap(0, w, 0.0)
    return leap(case, request, w, 0.0, w * np.exp(-WIDEST / SHARE), most, rows)


@inner_jit
def pass_over(work, w, final, half, most, rows):
    """The leap from w whose rows are filled."""
    none, below, start = Leap(0, w, 0.0), w < final, distance(w, final)
    count = points_of(work)
    for i in range(N):
        gap, gain = rows[GAP, i], rows[GAIN, i]
        # h'' = -dgamma/dw, by the neighbours
        one, two = max(i - 1, 0), min(i + 1, N - 1)
        apart = (POINTS[two] - POINTS[one]) * rows[SLOPE, i]
        curvature = -(rows[GAP, two] - rows[GAP, one]) / apart
        bent = (1.0 + 2.0 * gap) * gain * curvature / 12.0
        flow = gain * (-np.log1p(-gap) / gap + bent)
        work.slowness[i] = rows[SLOPE, i] / flow
        work.energy[i] = rows[TIME, i] * work.slowness[i]
    whole = integral(work.slowness, count)
    if not tail_of(work.slowness, count) <= ROUGHEST * whole or not whole >= WORTH:
        return none
    passed = min(int(whole), most)
    cumulate(work.slowness, work.scratch)
    x = invert(work, float(passed), whole)
    cumulate(work.energy, work.scratch)
    time = dot(work.from_left, work.scratch, count)
    # the ends of the sum: w, h and T there
    here = _at(start + half * (1.0 + x), below, final)
    time += _correction(work, rows, here, count)
    weights_to(work, -1.0)
    return Leap(passed, here, time - _correction(work, rows, w, count))


@inner_jit
def _at(z, below, final):
    """w at log q = z."""
    if final == 0.0:
        return np.exp(z)
    return final / (1.0 + np.exp(z)) if below else final * (1.0 + np.exp(z))


@inner_jit
def _correction(work, rows, w, count):
    """-T/2 + (dT/dk)/12 at w, whose weights are in the workspace."""
    time, gain = dot(work.at_x, rows[TIME], count), dot(work.at_x, rows[GAIN], count)
    return -0.5 * time - time * gain / (24.0 * w)
