"""The greatest accelerations, contact moment and contact force of a piece of a motion.

They are searched for on the panels on which `pieces.states_in` solves the piece: first at the
ends and Gauss points, and then between the neighbours of each point that may be next to the
greatest value.
"""

from escapement.dynamics.law import (
    contact,
    dragged_slope,
    friction_ratio,
    losses_per_angle,
    net_torque,
    reduced_inertia,
    root_of,
)
from escapement.dynamics.state_table import signs_near
from escapement.dynamics.torque import torque_at
from escapement.dynamics.train_losses import weight
from escapement.engines.energy.locate import weights_to
from escapement.engines.energy.panels import points_of
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.gauss import POINTS, N, dot
from escapement.numerics.jit import inner_jit

PEAKS = ("acceleration_max", "follower_acceleration_max", "contact_moment_max", "contact_force_max")
"""Names of the peaks, in their order."""
GOLDEN = 0.6180339887498949
# Golden section ends at this width of x: the error of a peak is in proportion to its square.
CLOSE = 1e-6
# A point may be next to the greatest value where its own is at least this share of it.
NEAR = 0.8


@inner_jit
def _magnitudes(scene, theta, w, side, slide_sign, ratio_sign):
    """|theta_ddot|, |phi_ddot|, |N h| and |N| at a driver angle; the side is 0 in a dwell.

    `slide_sign` and `ratio_sign` are the signs of the sliding speed and of g; see
    `dynamics.law.grip`.
    """
    g = u = dg = radius = 0.0
    if side != 0.0:
        g, u, dg, radius = pose_at(scene.path, theta)
    c, k = (
        friction_ratio(g, u, radius, side, scene, slide_sign, ratio_sign),
        dragged_slope(g, dg, scene, ratio_sign),
    )
    root, inertia = root_of(w, scene), reduced_inertia(g, c, scene)
    pull = torque_at(theta, scene)[0] - scene.bearing
    rate = net_torque(g, c, k, pull, w, root, scene) / inertia
    moment = contact(g, k, pull, w, root, scene) / inertia if side != 0.0 else 0.0
    force = losses_per_angle(g, u, radius, k, pull, w, side, scene, slide_sign, ratio_sign)[0]
    unit = weight(scene)
    return abs(rate), abs(g * rate + dg * w), unit * abs(moment), unit * abs(force)


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
    values : memory for the magnitudes at both ends and the points, shape (N + 2, 4).
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
    x, y = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_x = _magnitudes_at(scene, work, panel, side, x, slide_sign, ratio_sign)[j]
    at_y = _magnitudes_at(scene, work, panel, side, y, slide_sign, ratio_sign)[j]
    while high - low > CLOSE:
        if at_x > at_y:
            high, y, at_y = y, x, at_x
            x = high - GOLDEN * (high - low)
            at_x = _magnitudes_at(scene, work, panel, side, x, slide_sign, ratio_sign)[j]
        else:
            low, x, at_x = x, y, at_y
            y = low + GOLDEN * (high - low)
            at_y = _magnitudes_at(scene, work, panel, side, y, slide_sign, ratio_sign)[j]
    return max(at_x, at_y)
