"""The greatest accelerations, contact moment, force and force times sliding speed of a piece.

They are searched for on the panels on which `pieces.states_in` solves the piece: first at the
ends and Gauss points, and then between the neighbours of each point that may be next to the
greatest value.
"""

import numpy as np

from escapement.dynamics.law import grip, wall_state
from escapement.dynamics.load import load_at
from escapement.dynamics.power_flow import weight
from escapement.dynamics.state_table import losses_at, signs_near
from escapement.engines.energy.locate import weights_to
from escapement.engines.energy.panels import points_of
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.gauss import POINTS, N, dot
from escapement.numerics.jit import inner_jit
from escapement.numerics.roots import golden_point, golden_step, golden_trial

# Golden section ends at this width of x: the error of a peak is in proportion to its square.
CLOSE = 1e-6
# A point may be next to the greatest value where its own is at least this share of it.
NEAR = 0.8


@inner_jit
def _magnitudes(scene, theta, w, side, slide_sign, ratio_sign):
    """|theta_ddot|, |phi_ddot|, |N h|, |N| and |N v| at a driver angle; the side is 0 in a dwell.

    `slide_sign` and `ratio_sign` are the signs of the sliding speed and of g; see
    `dynamics.law.grip`.
    """
    now = wall_state(theta, w, side, scene, slide_sign, ratio_sign)
    moment = weight(scene) * now.moment / now.inertia
    signs = slide_sign, ratio_sign
    path = now.g, now.u, now.radius, now.k, now.pull
    lost = losses_at(*path, w, side, scene, *signs, load_at(theta, side, scene))
    follower_rate = now.g * now.rate + now.dg * w
    force, slide = abs(lost.force), 0.0
    if now.radius > 0.0:
        slide = abs(grip(now.g, now.u, now.radius, side, scene, *signs)[0])
    rubbing = force * slide * np.sqrt(max(w, 0.0))
    return abs(now.rate), abs(follower_rate), abs(moment), force, rubbing


@inner_jit
def _magnitudes_at(scene, work, panel, side, x, slide_sign, ratio_sign):
    """The magnitudes at x in [-1, 1] on a panel, whose E is interpolated."""
    weights_to(work, x)
    theta = panel.left + panel.half * (1.0 + x)
    g = pose_at(scene.path, theta)[0] if side != 0.0 else 0.0
    w = dot(work.at_x, work.energy, points_of(work)) / (scene.rho + g * g)
    return _magnitudes(scene, theta, w, side, slide_sign, ratio_sign)


@inner_jit
def raise_peaks(scene, work, panel, side, ends, values, peaks):
    """Raise `peaks` to the greatest magnitudes on a panel that was sampled.

    ends : w at the left and the right end.
    peaks : one that is infinite is not wanted.
    values : memory for the magnitudes at both ends and the points, a column for each.
    """
    # a panel holds no zero of the sliding speed or of g but at its ends
    slide_sign, ratio_sign = signs_near(panel.left + panel.half, 1.0, side, scene)
    for i in range(N + 2):
        x = -1.0 if i == 0 else 1.0 if i > N else POINTS[i - 1]
        w = ends[0] if i == 0 else ends[1] if i > N else work.w[i - 1]
        found = _magnitudes(
            scene, panel.left + panel.half * (1.0 + x), w, side, slide_sign, ratio_sign
        )
        for j in range(peaks.size):
            values[i, j] = found[j]
            peaks[j] = max(peaks[j], found[j])
    for j in range(peaks.size):
        for i in range(N + 2):
            here, before, behind = (
                values[i, j],
                values[max(i - 1, 0), j],
                values[min(i + 1, N + 1), j],
            )
            if here >= max(before, behind) and here > NEAR * peaks[j]:
                low = POINTS[i - 2] if i > 1 else -1.0
                high = POINTS[i] if i < N else 1.0
                top = _summit(scene, work, panel, side, low, high, j, slide_sign, ratio_sign)
                peaks[j] = max(peaks[j], top)


@inner_jit
def _summit(scene, work, panel, side, low, high, j, slide_sign, ratio_sign):
    """Greatest magnitude j between two points of a panel, by golden section."""
    inputs, signs = (scene, work, panel, side), (slide_sign, ratio_sign)
    best = golden_point(low, high)
    greatest = _magnitudes_at(*inputs, best, *signs)[j]
    while high - low > CLOSE:
        trial = golden_trial(low, high, best)
        value = _magnitudes_at(*inputs, trial, *signs)[j]
        low, high, best, greatest = golden_step(low, high, best, greatest, trial, value)
    return greatest
