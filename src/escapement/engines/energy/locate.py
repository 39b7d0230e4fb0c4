"""Where in a panel something happens, and what the motion is there.

Reversals and extrema are roots of values at the panel's points; what lies before and
behind them follows from weights that interpolate to the place, and that integrate.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics import contact, driving, free_gain
from escapement.engines.energy.gauss import (
    BARYCENTRIC,
    FROM_LEFT,
    POINTS,
    N,
    cumulate,
    dot,
    root_between,
    to_powers,
)
from escapement.engines.energy.panels import points_of, solution_of
from escapement.engines.energy.sampling import (
    EVERY_POINT,
    MERGED,
    NOTHING,
    contact_at,
    dips,
    driving_at,
    duration,
)
from escapement.jit import inner_jit
from escapement.mechanisms.slotted import transmission_at

NEAR = 1e-4  # of a panel: a last step of Newton's beyond this is not trusted


@inner_jit(reorders=True)
def weights_to(work, x):
    """Weights `at_x` that interpolate at x, and `from_left` for what vanishes at -1."""
    total = 0.0
    for i in range(points_of(work)):
        way = x - POINTS[i]
        weight = BARYCENTRIC[i] / (way if way != 0.0 else 1e-17)
        work.at_x[i] = weight
        total += weight
    scale = 1.0 / total
    for i in range(points_of(work)):
        weight = work.at_x[i] * scale
        work.at_x[i] = weight
        work.from_left[i] = weight * FROM_LEFT[i] * (1.0 + x)


@inner_jit
def locate(work, values, place, left, right, high):
    """Where values at the points change sign between point `place` and the one before.

    `left` is the value at -1, `right` that at x = `high`, which bounds the last point.

    Returns
    -------
    x, slope : the place, and the derivative of the values there.
    """
    to_powers(values, work.series)
    low, value_low = -1.0, left
    if place > 0:
        low, value_low = POINTS[place - 1], values[place - 1]
    value_high = right
    if place < N and POINTS[place] < high:
        high, value_high = POINTS[place], values[place]
    x = low - value_low * (high - low) / (value_high - value_low)
    if not low <= x <= high:
        x = 0.5 * (low + high)
    x, slope = root_between(work.series, x, low, high, value_low < 0.0)
    if place == 0:
        # so near the left end that the way from there should be accurate, not x
        for _ in range(2):
            weights_to(work, x)
            value = left
            for i in range(N):
                value += work.from_left[i] * (values[i] - left)
            x = max(-1.0, x - value / slope)
    return x, slope


class Instant(NamedTuple):
    """Driver angle, time since the left end of the panel, and w."""

    angle: float
    elapsed: float
    w: float


@inner_jit
def reversal_at(scene, work, panel, side, x, slope, w):
    """Instant of a reversal located at x; `w` is that of the left end.

    g may be rougher than what the panel was made for: it is evaluated, not interpolated.
    """
    count = points_of(work)
    if x <= -1.0:
        weights_to(work, -1.0)
        return Instant(panel.left, 0.0, w)
    weights_to(work, x)
    cumulate(work.slowness, work.series)
    angle = panel.left + panel.half * (1.0 + x)
    g, _u, dg = transmission_at(scene.path, angle)
    elapsed = dot(work.from_left, work.series, count)
    w = dot(work.at_x, work.energy, count) / (scene.rho + g * g)
    way = side * contact(g, dg, w, scene) / -slope
    way = panel.half * (way if abs(way) < NEAR else 0.0)
    # without a force the driver turns free
    return Instant(angle + way, elapsed + way / np.sqrt(w), w + free_gain(way, scene))


class Turned(NamedTuple):
    """What a panel leads to that holds a reversal.

    good : False where the panel is too coarse for this.
    energy, length : E at the right end; time from the left end there.
    exponent, source : of the affine map E_out = exp(-exponent) E_in + source up to there.
    """

    good: bool
    energy: float
    length: float
    exponent: float
    source: float


@inner_jit
def turn(scene, work, panel, side, reversal, strict, extrema, source):
    """Go on with the other side's solution from the reversal to the right end.

    Both solutions are continued over the whole panel; the weights to the reversal
    take of each the part that happens.

    Parameters
    ----------
    reversal : the first point behind it.
    strict : tail allowed for values inside the panel.
    extrema : whether extrema of the driver speed matter.
    source : of the map up to the left end, see `Turned`.
    """
    count = points_of(work)
    one, two = solution_of(panel, side), solution_of(panel, -side)
    e = dot(work.at_x, work.energy, count)
    alpha, beta = dot(work.at_x, one.alpha, count), dot(work.at_x, one.beta, count)
    other_alpha, other_beta = dot(work.at_x, two.alpha, count), dot(work.at_x, two.beta, count)
    b, other_b = dot(work.at_x, one.b, count), dot(work.at_x, two.b, count)
    # the energy at the left end from which the other side would come here
    fictive = (e - other_beta) / other_alpha
    bad = _run_behind(scene, work, panel, two, -side, fictive, reversal, extrema)
    # the time of the other side, and what the part before the reversal differs by
    cumulate(work.difference, work.series)
    length, roughness = duration(work)
    length += dot(work.from_left, work.series, count)
    e_right = two.alpha_end * fictive + two.beta_end
    w_right = e_right / (scene.rho + panel.exit.g**2)
    bad += not w_right > 0.0
    bad += _hides_more(scene, work, panel, side, w_right, reversal, extrema)
    source = (alpha * source + beta - other_beta) / other_alpha
    source = two.alpha_end * source + two.beta_end
    good = bad == 0 and roughness <= max(strict, two.noise)
    return Turned(good, e_right, length, b - other_b + two.b_end, source)


@inner_jit
def _run_behind(scene, work, panel, solution, side, energy, reversal, extrema):
    """Values of the side that carries the force behind a reversal; how many points are bad.

    Bad is a point without speed, and one behind the reversal where the force would change
    sides again or the driver lose speed, which a panel with a reversal must not hold.
    """
    bad = 0
    apart = panel.half > MERGED
    for i in range(points_of(work)):
        w = (solution.alpha[i] * energy + solution.beta[i]) * panel.inverse[i]
        slowness = panel.step[i] / np.sqrt(w)
        work.difference[i] = work.slowness[i] - slowness
        work.slowness[i] = slowness
        c = -side * contact(panel.g[i], panel.dg[i], w, scene)
        a = driving(panel.g[i], panel.u[i], panel.dg[i], w, side, scene)
        work.contact[i] = c
        work.rate[i] = a
        bad += not w > 0.0
        bad += apart and i >= reversal and c > 0.0
        bad += extrema and i >= reversal and a <= 0.0
    return bad


@inner_jit
def _hides_more(scene, work, panel, side, w, reversal, extrema):
    """How many signs there are of a further event between a reversal and the right end.

    `side` is that before the reversal, `w` that of the right end.
    """
    c = side * contact_at(panel.exit, w, scene)
    a = driving_at(panel.exit, -side, w, scene)
    rest, count = reversal + 1, points_of(work)
    more = 0
    more += extrema and a <= 0.0
    if panel.half > MERGED:
        nothing = NOTHING * (scene.rho + panel.entry.g**2)
        more += c > 0.0
        more += dips(work.contact, nothing, c, c, rest, EVERY_POINT, count)
        if extrema:
            more += dips(work.rate, NOTHING, a, a, rest, EVERY_POINT, count)
    return more
