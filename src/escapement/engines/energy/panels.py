"""Panels: an engagement cut into parts on which the energy equation is solved.

A panel holds values at 16 Gauss points, x in [-1, 1] from its left end to its right end.
The tail of a function on a panel is the size of its last two Legendre coefficients, which
estimates the error of interpolating it. Integrals over the whole panel converge twice as fast
as interpolation inside it, so they tolerate a larger tail. A panel is halved when its tail is too
large for the requested results.

The panels of an engagement form a chain from left to right. The workspace is one record for
the values that are needed on a single panel at a time.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.law import dragged_slope, is_ideal
from escapement.dynamics.load import has_load_curve, load_at
from escapement.dynamics.torque import (
    angle_turned,
    depends_on_speed,
    is_alike,
    next_knot,
    torque_at,
)
from escapement.dynamics.train_losses import is_lossy
from escapement.mechanisms.slotted import is_meshed, pose_at, transmission_on
from escapement.numerics.gauss import POINTS, N, tail_of
from escapement.numerics.jit import inner_jit
from escapement.numerics.known import where_known
from escapement.numerics.records import record_dtype

NUMBER, WHOLE, FLAG = np.float64, np.int64, np.bool_
ROW = (NUMBER, (N,))
"""Type of a row: the values at the Gauss points."""


END = record_dtype({**dict.fromkeys(("g", "u", "dg", "radius", "pull", "load", "turned"), NUMBER)})
"""g, u, g', R, the pull of the drive at rest, the load that changes, and the angle turned since the
start, at one driver angle."""

SOLUTION = record_dtype(
    {
        # at the points: E(x) = alpha E_left + beta with alpha = exp(-b) and b = int B
        **dict.fromkeys(("alpha", "beta", "b"), ROW),
        "friction_ratio": ROW,  # c = p - g at the points
        # beta = solved + (pull - solved_pull) share, with the pull at the left end; see `shift`
        **dict.fromkeys(("solved", "share"), ROW),
        **dict.fromkeys(("solved_end", "share_end", "solved_pull", "pull"), NUMBER),
        # the same three at the right end
        **dict.fromkeys(("alpha_end", "beta_end", "b_end"), NUMBER),
        # relative tail of the solution, UNSOLVED before there is one, and its rounding error
        **dict.fromkeys(("tail", "noise"), NUMBER),
    }
)
"""Solution of the energy equation on a panel for one side of the slot."""

PANEL = record_dtype(
    {
        **dict.fromkeys(("left", "half"), NUMBER),  # driver angle of the left end, half the width
        "next": WHOLE,  # index of the panel to its right, CHAIN_END if there is none
        "kink": FLAG,  # whether |u| has a kink at the left end, as at dead centre
        "locked": FLAG,  # whether it lies in the dwell, where g, |u| and g' are zero
        **dict.fromkeys(("interval", "cell"), WHOLE),  # indices of its geometry in the cells
        **dict.fromkeys(("g", "u", "dg", "radius"), ROW),  # g, u, k and R at the points
        "inverse_inertia": ROW,  # 1/(rho + g^2) at the points
        "geometry_tail": NUMBER,  # relative tail of 1/(rho + g^2)
        "dtheta_dx": ROW,  # theta' = dtheta/dx at the points
        "pull": ROW,  # torque of the drive at rest less that of the bearing at the points
        "turned": ROW,  # driver angle turned there, if the torque depends on the speed
        "load": ROW,  # part of the load that changes with the follower's angle, if there is one
        # slope of that by the angle, and the angle turned before the cell for which it holds
        **dict.fromkeys(("slope", "driver_angle"), NUMBER),
        "flow": NUMBER,  # the flow of the scene for which it is filled, see `dynamics.train_losses`
        **dict.fromkeys(("entry", "exit"), END),  # the same at the left and the right end
        **dict.fromkeys(("plus", "minus"), SOLUTION),  # for the sides s = +1 and -1
    }
)
"""A panel: its geometry, and its solution for either side of the slot."""

WORKSPACE = record_dtype(
    {
        "points": WHOLE,  # N, see `points_of`
        # E, w, s X, J theta_ddot and dt/dx = theta'/sqrt(w) at the points
        **dict.fromkeys(("energy", "w", "contact", "net_torque", "slowness"), ROW),
        "slowness_change": ROW,  # dt/dx before a reversal less that behind it
        "scratch": ROW,  # passed from one step to the next: points, or integrals
        **dict.fromkeys(("at_x", "from_left"), ROW),  # weights of `locate.weights_to`
        **dict.fromkeys(("decay", "gain"), ROW),  # B and A by x while a panel is being solved
        "series": (NUMBER, (4, N)),  # of `rundown_series`
        "root": ROW,  # the speeds about which viscous drag is linear meanwhile
        "spare": PANEL,  # a panel outside the chain, for a start and for refined events
    }
)
"""Values that are needed on one panel at a time."""


class Store(NamedTuple):
    """Memory of a march: records of `PANEL`, whose chain begins at index 0, and one workspace."""

    panels: np.ndarray
    workspace: np.ndarray


UNSOLVED = -1.0
# The flow of a panel that must be filled again.
NO_FLOW = -2.0
FIRST_PANEL, CHAIN_END = 0, -1
NO_PANELS = 0
MAX_PANELS = 2048
# The sliding speed at an end is evaluated this share of the distance to the nearest point inside.
INWARDS = 1e-10
# The tail of 1/(rho + g^2) must be below this share of the tail allowed, because with much
# friction A, B and E are rougher than the geometry from which they are made.
GEOMETRY_SHARE = 0.1
# A panel of a smaller half width [rad] is not halved.
SMALLEST = 1e-13


@inner_jit(allocates=True, inlined=True)
def new_store(most):
    """An empty store for `most` panels; memory that is never touched costs nothing."""
    workspace = np.empty(1, WORKSPACE)
    workspace[0].points = N
    workspace[0].spare.locked = False
    return Store(np.empty(most, PANEL), workspace)


@inner_jit
def points_of(work):
    """N as a number that the compiler does not know, so that loops over it become vector code."""
    return work.points & N


@inner_jit
def solution_of(panel, side):
    """Solution of a panel for the side s of the slot."""
    return panel.plus if side > 0.0 else panel.minus


@inner_jit
def fill_end(end, path, theta, locked):
    """Fill an `END` with g, u, g' and R at a driver angle; all are zero in a dwell (`locked`)."""
    end.g = end.u = end.dg = end.radius = 0.0
    if not locked:
        end.g, end.u, end.dg, end.radius = pose_at(path, theta)


@inner_jit
def copy_end(end, other):
    """Copy the `END` named `other`."""
    end.g, end.u, end.dg, end.radius = other.g, other.u, other.dg, other.radius


@inner_jit
def copy_row(row, other, count):
    """Copy the row named `other`; `count` is what `panels.points_of` gives."""
    # assigning to a slice would take longer to compile, because of its error messages
    for i in range(count & N):
        row[i] = other[i]


@inner_jit
def evaluate_geometry(work, panel, scene, left, right):
    """Evaluate g, u, k and R of a panel at the Gauss points, and at its ends."""
    # `evaluate_at` needs the points in a row of the workspace
    for i in range(N):
        work.scratch[i] = POINTS[i]
    panel.left = left
    panel.half = 0.5 * (right - left)
    evaluate_at(work.scratch, points_of(work), panel, scene.path)
    fill_end(panel.entry, scene.path, left, panel.locked)
    fill_end(panel.exit, scene.path, right, panel.locked)
    finish_ends(panel, scene)
    fill_inertia(panel, scene, points_of(work))
    finish_geometry(panel, scene, points_of(work))


@inner_jit
def evaluate_at(points, count, panel, path):
    """Evaluate g, u, g' and R at points of a panel, which are x in [-1, 1]."""
    g, u, dg, radius = panel.g, panel.u, panel.dg, panel.radius
    if not panel.locked:
        transmission_on(path, panel.left, panel.half, points, count, g, u, dg, radius)
        return
    for i in range(count & N):
        g[i] = u[i] = dg[i] = radius[i] = 0.0


@inner_jit
def fill_geometry(work, panel, scene, cells, left, right):
    """Fill the geometry of a panel from the mechanism's cells, or evaluate it."""
    # the cells hold only the first halvings of an interval, and nothing of a dwell
    if panel.locked or panel.cell >= cells.shape[1]:
        evaluate_geometry(work, panel, scene, left, right)
        return
    cell = cells[panel.interval, panel.cell]
    panel.left = left
    panel.half = 0.5 * (right - left)
    count, half = points_of(work), panel.half
    # one loop, since the compiler makes no vector code of a loop that does little for each point
    for i in range(count & N):
        g = cell.g[i]
        panel.g[i], panel.u[i], panel.dg[i] = g, cell.u[i], cell.dg[i]
        panel.inverse_inertia[i] = 1.0 / (scene.rho + g * g)
        panel.dtheta_dx[i] = half
    if not is_ideal(scene):
        copy_row(panel.radius, cell.radius, count)
    copy_end(panel.entry, cell.entry)
    copy_end(panel.exit, cell.exit)
    finish_ends(panel, scene)
    finish_geometry(panel, scene, count)


@inner_jit(merged=True)
def fill_pull(panel, scene, count):
    """Fill the pull of the drive on a panel, which is linear there.

    The solutions are for another slope of the torque where that has changed.
    """
    pull, slope = torque_at(panel.left + panel.half, scene)
    pull -= scene.bearing
    rise = slope * panel.half
    if may_change(scene):
        for i in range(count & N):
            panel.pull[i] = pull + rise * POINTS[i]
    panel.entry.pull, panel.exit.pull = pull - rise, pull + rise
    if slope != panel.slope:
        panel.plus.tail = panel.minus.tail = UNSOLVED
    panel.slope, panel.driver_angle = slope, scene.driver_angle
    if depends_on_speed(scene):
        fill_turned(panel, scene)
    if has_load_curve(scene):
        fill_load(panel, scene)


@inner_jit
def fill_turned(panel, scene):
    """Fill the driver angles turned at the ends and at the points of a panel."""
    panel.entry.turned = angle_turned(panel.left, scene)
    panel.exit.turned = angle_turned(panel.left + 2.0 * panel.half, scene)
    for i in range(N):
        panel.turned[i] = panel.entry.turned + panel.half * (1.0 + POINTS[i])


@where_known("pace", lambda panel, scene: panel.slope == 0.0)
def is_level(panel, scene):
    """Whether the torque on a panel depends on the speed alone, if on anything."""
    return panel.slope == 0.0 and is_alike(scene)


@where_known("motor", lambda scene: False)
def may_change(scene):
    """Whether the torque of the drive may change; only then a panel has a row of its pull."""
    return True


@where_known("motor", lambda pull, row, i, scene: pull)
def pull_at(pull, row, i, scene):
    """The pull at point i of a panel, from `pull` at its left end, and from the row."""
    return row[i]


@inner_jit
def fill_load(panel, scene):
    """Fill the load that changes with the follower's angle; a dwell has none."""
    panel.entry.load = panel.exit.load = 0.0
    for i in range(N):
        panel.load[i] = 0.0
    if panel.locked:
        return
    left, half = panel.left, panel.half
    panel.entry.load = load_at(left, 1.0, scene)
    panel.exit.load = load_at(left + 2.0 * half, 1.0, scene)
    for i in range(N):
        panel.load[i] = load_at(left + half * (1.0 + POINTS[i]), 1.0, scene)


@inner_jit
def turn_to(store, scene):
    """Fill the pull of the drive on all panels for the cell after `scene.driver_angle`."""
    index = FIRST_PANEL
    while index != CHAIN_END:
        fill_pull(store.panels[index], scene, points_of(store.workspace[0]))
        # trains pass on another share of the torque in each flow
        store.panels[index].flow = NO_FLOW if is_lossy(scene) else scene.flow
        index = store.panels[index].next


@inner_jit(merged=True)
def finish_ends(panel, scene):
    """Turn g' at the ends into k, and give the sliding speed there the sign it has inside."""
    for end in (panel.entry, panel.exit):
        end.dg = dragged_slope(end.g, end.dg, scene)
    if not (panel.locked or is_ideal(scene)):
        # with friction in journals theta_ddot jumps where the sliding reverses, so rounding must
        # not decide on which side of that angle an end lies
        panel.entry.u += INWARDS * (panel.u[0] - panel.entry.u)
        panel.exit.u += INWARDS * (panel.u[N - 1] - panel.exit.u)


@inner_jit(merged=True)
def fill_inertia(panel, scene, count):
    """Fill 1/(rho + g^2) and theta' of a panel with the same theta' at all points."""
    half = panel.half
    for i in range(count & N):
        panel.inverse_inertia[i] = 1.0 / (scene.rho + panel.g[i] * panel.g[i])
        panel.dtheta_dx[i] = half


@inner_jit(merged=True)
def finish_geometry(panel, scene, count):
    """Fill what follows from `fill_inertia`, and mark both sides as unsolved."""
    if scene.follower_drag > 0.0:
        for i in range(N):
            panel.dg[i] = dragged_slope(panel.g[i], panel.dg[i], scene)
    # 1/(rho + g^2) is greatest at the first or the last point unless |g| has a minimum between;
    # then the tail is overestimated, and the panel becomes finer than it need be
    largest = max(panel.inverse_inertia[0], panel.inverse_inertia[N - 1])
    panel.geometry_tail = tail_of(panel.inverse_inertia, count) / largest
    fill_pull(panel, scene, count)
    panel.flow = scene.flow
    panel.plus.tail = UNSOLVED
    panel.minus.tail = UNSOLVED


@inner_jit
def halve(scene, cells, store, index, count, cut):
    """Split the panel at `index` in two at a driver angle, 0 for its middle; returns the new number
    of panels.

    The left half keeps its index. The right half gets the index `count` and follows the left
    one in the chain.
    """
    work = store.workspace[0]
    panel, new = store.panels[index], store.panels[count]
    left = panel.left
    middle = left + panel.half if cut == 0.0 else cut
    right = left + 2.0 * panel.half
    # the sum may round, but an edge of the scene must keep its exact angle
    if panel.next != CHAIN_END:
        right = store.panels[panel.next].left
    # the halves of cell k are the cells 2k and 2k + 1
    new.interval, new.locked = panel.interval, panel.locked
    new.cell = 2 * panel.cell + 1
    panel.cell = 2 * panel.cell
    if cut != 0.0:
        panel.cell = new.cell = max(panel.cell, cells.shape[1])
    fill_geometry(work, panel, scene, cells, left, middle)
    fill_geometry(work, new, scene, cells, middle, right)
    new.next = panel.next
    panel.next = count
    new.kink = False
    return count + 1


@inner_jit
def fill_again(store, panel, scene, cells):
    """Fill the geometry of a panel for another scene of the same mechanism."""
    right = panel.left + 2.0 * panel.half
    # the sum may round, but an edge of the scene must keep its exact angle
    if panel.next != CHAIN_END:
        right = store.panels[panel.next].left
    fill_geometry(store.workspace[0], panel, scene, cells, panel.left, right)


@inner_jit
def lay_out(scene, cells, store, loose):
    """Lay out the chain of an engagement and of the dwell that follows it, fine enough for its
    geometry; returns its length.
    """
    edges, moving = scene.edges, scene.edges.size - 1
    count, end = NO_PANELS, edges[-1] + scene.dwell
    for k in range(moving + 1 if scene.dwell > 0.0 else moving):
        left, right = edges[k], edges[k + 1] if k < moving else end
        # an interval has a panel of its own between any two knots of the torque
        while left < right:
            panel, knot = store.panels[count], next_knot(left, right, scene)
            panel.locked = k == moving
            # at a break of a slotted path |u| has a kink; at the corner of a mesh it has none
            panel.kink = left > edges[0] and (
                left > edges[k] or panel.locked or not is_meshed(scene.path)
            )
            panel.interval = k
            panel.cell = 1 if left == edges[k] and knot == right else cells.shape[1]
            fill_geometry(store.workspace[0], panel, scene, cells, left, knot)
            count += 1
            panel.next = count
            left = knot
    store.panels[count - 1].next = CHAIN_END
    # an eighth of the memory at most is used here, and the march needs the rest
    index, limit = FIRST_PANEL, GEOMETRY_SHARE * loose
    while index != CHAIN_END:
        while store.panels[index].geometry_tail > limit and count < MAX_PANELS // 8:
            count = halve(scene, cells, store, index, count, 0.0)
        index = store.panels[index].next
    return count


@inner_jit
def tolerances(rtol):
    """Tails `loose` and `strict` that a panel may have for a relative error of `rtol`.

    The first is for integrals over whole panels, the second for values inside. Measured on
    random scenes, the error is at most a hundredth of the square of `loose` and a twentieth
    of `strict`. For an rtol above 1e-8 some scenes break that rule, and little time is saved.
    """
    rtol = min(rtol, 1e-8)
    return 3.0 * np.sqrt(rtol), max(15.0 * rtol, 1e-14)
