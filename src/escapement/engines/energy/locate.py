"""The x of a reversal or an extremum in a panel, and the motion there and after a reversal.

Reversals are roots of X, extrema are roots of J theta_ddot; both are known at the panel's
points. Two sets of weights at such an x interpolate a row of values there, and give its
integral from the left end to there.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.law import (
    contact,
    dragged_slope,
    free_gain,
    is_viscous,
    net_torque,
    root_of,
)
from escapement.dynamics.load import load_at
from escapement.dynamics.torque import at_speed, drive_torque
from escapement.engines.energy import sampling
from escapement.engines.energy.panels import points_of, pull_at, solution_of
from escapement.engines.energy.sampling import CLOSE_PAIR, NEGLIGIBLE, Points
from escapement.engines.energy.solve import (
    MOST_STEPS,
    fill_friction_ratio,
    refresh_roots,
    solve_again,
    solve_linear,
    solve_side,
)
from escapement.mechanisms.slotted import transmission_at
from escapement.numerics.gauss import (
    POINTS,
    N,
    cumulate,
    dot,
    root_between,
    to_powers,
)
from escapement.numerics.gauss import invert as invert
from escapement.numerics.gauss import weights_to as weights_to
from escapement.numerics.jit import inner_jit

# A last step of Newton's method for a reversal that is longer than this, in x, is due to
# rounding and left out.
LARGEST_CORRECTION = 1e-4
# A panel is split this share of the distance to a change before it, which is known to that
# accuracy.
NEAR_CHANGE = 1e-4


@inner_jit
def locate(work, values, point, left, right, high):
    """Root of a function between `point` and the point before it.

    `values` are those at the points, `left` is that at x = -1, and `right` is that at
    x = `high`, the upper bound of the root where that comes before `point`.

    Returns
    -------
    x, slope : the root, and the derivative there.
    """
    to_powers(values, work.scratch)
    low, value_low = -1.0, left
    if point > 0:
        low, value_low = POINTS[point - 1], values[point - 1]
    value_high = right
    if point < N and POINTS[point] < high:
        high, value_high = POINTS[point], values[point]
    # the first guess is the root of the chord
    x = low - value_low * (high - low) / (value_high - value_low)
    if not low <= x <= high:
        x = 0.5 * (low + high)
    x, slope = root_between(work.scratch, x, low, high, value_low < 0.0)
    if point == 0:
        # so close to the left end, 1 + x has to be accurate and not only x: interpolate the
        # difference from the value at the left end, which vanishes there
        for _ in range(2):
            weights_to(work, x)
            value = left
            for i in range(N):
                value += work.from_left[i] * (values[i] - left)
            x = max(-1.0, x - value / slope)
    return x, slope


@inner_jit
def cut_at_turn(scene, work, panel, side, w_left, w_right):
    """Where to split the panel in which `sampling.turns_back` found a change of direction."""
    left_q, left_z = sampling.flow_at_end(scene, panel.entry, side, w_left)
    right_q, right_z = sampling.flow_at_end(scene, panel.exit, side, w_right)
    one = _first_change(work, work.decay, left_q, right_q)
    two = _first_change(work, work.gain, left_z, right_z)
    return cut_near(panel, min(one, two))


@inner_jit
def _first_change(work, values, left, right):
    """The x at which values that are positive at first change their sign; infinite without one."""
    point = N if right < 0.0 else N + 1
    for i in range(N - 1, -1, -1):
        point = i if values[i] < 0.0 else point
    if point > N:
        return np.inf
    return locate(work, values, point, max(left, 0.0), right, 1.0)[0]


@inner_jit
def cut_near(panel, x):
    """Driver angle at which to split a panel so that a change at x gets a narrow panel of its own.

    The part to its left ends a little before it. Where the change is next to the left end, this
    part is the narrow panel. The result is 0, for the middle, where x is not in the panel.
    """
    if not -1.0 <= x <= 1.0:
        return 0.0
    distance, width = panel.half * (1.0 + x), sampling.NARROW_TURN
    if distance <= width:
        return panel.left + distance + 0.5 * width
    return panel.left + distance - max(0.5 * width, NEAR_CHANGE * distance)


class Instant(NamedTuple):
    """Driver angle, time since the left end of the panel, and w."""

    angle: float
    elapsed: float
    w: float


@inner_jit
def reversal_at(scene, work, panel, side, x, slope, w):
    """Instant of a reversal at x, whose weights are in the workspace; `w` is at the left end.

    g and g' are evaluated at x and not interpolated, because the panel was tested for E and
    1/(rho + g^2) alone.
    """
    count = points_of(work)
    if x <= -1.0:
        return Instant(panel.left, 0.0, w)
    cumulate(work.slowness, work.scratch)
    angle = panel.left + panel.half * (1.0 + x)
    g, _u, dg = transmission_at(scene.path, angle)
    elapsed = dot(work.from_left, work.scratch, count)
    w = dot(work.at_x, work.energy, count) / (scene.rho + g * g)
    # one step of Newton's method on s X, as a part of the panel and then as an angle
    k, pull = dragged_slope(g, dg, scene), drive_torque(angle, w, scene) - scene.bearing
    load = load_at(angle, side, scene)
    distance = side * contact(g, k, pull, w, root_of(w, scene), scene, load) / -slope
    distance = panel.half * (distance if abs(distance) < LARGEST_CORRECTION else 0.0)
    # X = 0 means that there is no contact force: the driver turns free. It stays in the panel.
    distance = min(distance, panel.left + 2.0 * panel.half - angle)
    return Instant(
        angle + distance, elapsed + distance / np.sqrt(w), w + free_gain(distance, pull, w, scene)
    )


@inner_jit
def solve_behind(scene, work, panel, side):
    """Solve a panel for the side -s that carries the force after a reversal.

    With viscous drag the solution is that through the E of the reversal, whose weights are in
    the workspace.
    """
    other, count = solution_of(panel, -side), points_of(work)
    if not is_viscous(scene):
        solve_side(scene, work, panel, -side, 0.0)
        return
    fill_friction_ratio(scene, work, panel, other, -side)
    e = dot(work.at_x, work.energy, count)
    for i in range(N):
        work.root[i] = np.sqrt(work.w[i])
    for _ in range(MOST_STEPS):
        solve_linear(scene, work, panel, other, -side)
        fictive = (e - dot(work.at_x, other.beta, count)) / dot(work.at_x, other.alpha, count)
        if refresh_roots(scene, work, panel, other, fictive) < 1e-14:
            solve_again(scene, work, panel, other, -side)
            return
    other.tail = 1.0


class AfterReversal(NamedTuple):
    """The motion at the right end of a panel that holds a reversal.

    good : whether the panel is fine enough for it; otherwise it must be halved.
    energy, length : E at the right end; time from the left end there.
    exponent : int B over this panel, of each side the part that is passed.
    source : of the affine map E = exp(-..) E_entry + source from the entry to the right end.
    """

    good: bool
    energy: float
    length: float
    exponent: float
    source: float


@inner_jit
def pass_reversal(scene, work, panel, side, reversal, strict, trend, source):
    """Go from the reversal to the right end with the solution of the other side.

    The solutions of both sides are smooth over the whole panel. The motion follows that of s up
    to the reversal and that of -s after it; the weights in the workspace, which are those of the
    reversal, give both there.

    Parameters
    ----------
    side : s before the reversal.
    reversal : the first point after it.
    strict : tail allowed for values inside the panel.
    trend : sign of theta_ddot at the reversal where extrema matter, otherwise 0.
    source : of the map up to the left end, see `AfterReversal`.
    """
    count = points_of(work)
    one, two = solution_of(panel, side), solution_of(panel, -side)
    e = dot(work.at_x, work.energy, count)
    alpha, beta = dot(work.at_x, one.alpha, count), dot(work.at_x, one.beta, count)
    other_alpha, other_beta = dot(work.at_x, two.alpha, count), dot(work.at_x, two.beta, count)
    b, other_b = dot(work.at_x, one.b, count), dot(work.at_x, two.b, count)
    # solve e = other_alpha E_left + other_beta: from this energy at the left end, the other
    # side's solution has the energy e at the reversal
    fictive = (e - other_beta) / other_alpha
    bad = _run_behind(scene, work, panel, two, -side, fictive, reversal, trend)
    # the time is that of the other side over the whole panel, and up to the reversal the
    # integral of the difference in dt/dx
    cumulate(work.slowness_change, work.scratch)
    length, roughness = sampling.duration(work)
    length += dot(work.from_left, work.scratch, count)
    e_right = two.alpha_end * fictive + two.beta_end
    w_right = e_right / (scene.rho + panel.exit.g**2)
    bad += not w_right > 0.0
    bad += _hides_more(scene, work, panel, side, w_right, reversal, trend)
    # compose the affine maps: to the reversal, back to the left end on the other side, and on
    # to the right end; the reversal's own shift changes the result to second order only
    source = (alpha * source + beta - other_beta) / other_alpha
    source = two.alpha_end * source + two.beta_end
    good = bad == 0 and roughness <= max(strict, two.noise)
    return AfterReversal(good, e_right, length, b - other_b + two.b_end, source)


@inner_jit
def _run_behind(scene, work, panel, solution, side, energy, reversal, trend):
    """Fill the workspace with the motion after a reversal; returns the number of bad points.

    A point is bad where there is no speed. After the reversal it is also bad where the force
    is back on the first side or, if extrema matter, where theta_ddot has another sign than at
    the reversal: a panel with a reversal must hold neither of these.
    """
    bad = 0
    apart, viscous = panel.half > CLOSE_PAIR, is_viscous(scene)
    left_pull = panel.entry.pull
    for i in range(points_of(work)):
        w = (solution.alpha[i] * energy + solution.beta[i]) * panel.inverse_inertia[i]
        slowness = panel.dtheta_dx[i] / np.sqrt(w)
        work.slowness_change[i] = work.slowness[i] - slowness
        work.slowness[i] = slowness
        root = np.sqrt(w) if viscous else 0.0
        g, k, pull = panel.g[i], panel.dg[i], pull_at(left_pull, panel.pull, i, scene)
        pull = at_speed(pull, panel.turned[i], w, scene)
        c = -side * contact(g, k, pull, w, root, scene, panel.load[i])
        a = net_torque(g, solution.friction_ratio[i], k, pull, w, root, scene, panel.load[i])
        work.contact[i] = c
        work.net_torque[i] = a
        bad += not w > 0.0
        bad += apart and i >= reversal and c > 0.0
        bad += trend != 0.0 and i >= reversal and a * trend <= 0.0
    return bad


@inner_jit
def _hides_more(scene, work, panel, side, w, reversal, trend):
    """Number of signs of a further event between a reversal and the right end.

    `side` is that before the reversal, and `w` is that at the right end.
    """
    # the row of s X is that of the other side
    c = -sampling.beside(
        scene, panel, -side * sampling.contact_at(panel.exit, w, scene), work.contact, N - 1
    )
    a = sampling.net_torque_at(panel.exit, -side, w, scene)
    a = sampling.beside(scene, panel, a, work.net_torque, N - 1)
    # the search begins one point later, because X passes through zero at the reversal itself
    rest = Points(reversal + 1, N)
    more = 0
    more += trend != 0.0 and a * trend < 0.0
    if panel.half > CLOSE_PAIR:
        negligible = NEGLIGIBLE * (scene.rho + panel.entry.g**2)
        more += c > 0.0
        more += sampling.may_vanish(work, work.contact, negligible, c, c, rest)
        if trend != 0.0:
            more += sampling.may_vanish(work, work.net_torque, NEGLIGIBLE, a, a, rest)
    return more
