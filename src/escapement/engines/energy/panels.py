"""Panels: an engagement cut into pieces on which the energy equation is solved.

Values live at 16 Gauss points, x in [-1, 1] from the left end of a panel to its right end.
Integrals over a whole panel converge twice as fast as interpolation inside it; a panel
records the size of its last Legendre coefficients, its tails, and is halved when what is
asked of it needs better.

The panels of an engagement form a chain from left to right. What is evaluated on one panel
at a time lies in a record of its own, the workspace.
"""

from typing import NamedTuple

import numpy as np

from escapement.engines.energy.gauss import POINTS, N, tail_of
from escapement.engines.energy.records import (
    END,
    NUMBER,
    ROW,
    TRUTH,
    WHOLE,
    copy_end,
    copy_row,
    put_end,
    record,
)
from escapement.jit import inner_jit
from escapement.mechanisms.slotted import transmission_on

SOLUTION = record(
    {
        # E(x) = alpha E_left + beta with alpha = exp(-b), b the integral of B; at the points
        **dict.fromkeys(("alpha", "beta", "b"), ROW),
        # the same three at the right end
        **dict.fromkeys(("alpha_end", "beta_end", "b_end"), NUMBER),
        # size of the last coefficients, UNSOLVED before they are known, and their rounding
        **dict.fromkeys(("tail", "noise"), NUMBER),
    }
)
"""Solution of the energy equation on a panel for one side of the slot."""

PANEL = record(
    {
        **dict.fromkeys(("left", "half"), NUMBER),  # driver angle of the left end, half the width
        "next": WHOLE,  # panel to its right, LAST if there is none
        "kink": TRUTH,  # whether the left end is a break of the mechanism
        **dict.fromkeys(("interval", "cell"), WHOLE),  # where the mechanism's cells have it
        **dict.fromkeys(("g", "u", "dg"), ROW),  # g, |u| and g' at the points
        "inverse": ROW,  # 1/(rho + g^2) at the points
        "sharp": NUMBER,  # size of the last coefficients of `inverse`, relative
        "step": ROW,  # driver angle by x at the points
        **dict.fromkeys(("entry", "exit"), END),  # g, |u| and g' at the left and the right end
        **dict.fromkeys(("plus", "minus"), SOLUTION),  # for the sides s = +1 and -1
    }
)
"""A panel: its geometry, and its solution for either side of the slot."""

WORKSPACE = record(
    {
        "points": WHOLE,  # N, see `points_of`
        # E, w, X by s, J theta_ddot and dt/dx at the points of the panel at hand
        **dict.fromkeys(("energy", "w", "contact", "rate", "slowness"), ROW),
        "difference": ROW,  # of the slowness on the two sides of a reversal
        "series": ROW,  # a power series, points of a panel to be laid out, or times
        **dict.fromkeys(("at_x", "from_left"), ROW),  # weights of `locate.weights_to`
        **dict.fromkeys(("decay", "gain"), ROW),  # B and A by x while a panel is being solved
        "start": PANEL,  # the panel a motion starts in, over the square root of the angle
    }
)
"""What is evaluated on one panel at a time."""


class Store(NamedTuple):
    """Memory of a march: records of `PANEL`, of which panel 0 is the first, and one workspace."""

    panels: np.ndarray
    workspace: np.ndarray


UNSOLVED = -1.0
FIRST, LAST = np.int64(0), np.int64(-1)  # int64: for a plain constant numba compiles users anew
MAX_PANELS = np.int64(2048)
NO_PANELS = np.int64(0)  # have been laid out yet
COARSE = 0.1  # of the tail allowed: what is solved for is rougher than its coefficients
SMALLEST = 1e-13  # half width [rad] below which no panel is halved


@inner_jit(allocates=True)
def new_store(most):
    """An empty store for `most` panels; memory that is never touched costs nothing."""
    workspace = np.empty(1, WORKSPACE)
    workspace[0].points = N
    return Store(np.empty(most, PANEL), workspace)


@inner_jit
def points_of(work):
    """N, unknown to the compiler, which makes vector code of loops of such a length."""
    return work.points & N


@inner_jit
def solution_of(panel, side):
    """Solution of a panel for a side of the slot."""
    return panel.plus if side > 0.0 else panel.minus


@inner_jit
def at_gauss_points(work):
    """Have `survey` fill an ordinary panel."""
    for i in range(N):
        work.series[i] = POINTS[i]


@inner_jit
def survey(work, panel, path, rho, left, right):
    """Fill the geometry of a panel at the points in `work.series`, from -1 to 1."""
    half = 0.5 * (right - left)
    panel.left = left
    panel.half = half
    transmission_on(path, left, half, work.series, points_of(work), panel.g, panel.u, panel.dg)
    put_end(panel.entry, path, left)
    put_end(panel.exit, path, right)
    complete(panel, rho, points_of(work))


@inner_jit
def recall(work, panel, path, cells, rho, left, right):
    """Fill the geometry of a panel from the mechanism's cells where they have it."""
    if panel.cell >= cells.shape[1]:
        at_gauss_points(work)
        survey(work, panel, path, rho, left, right)
        return
    cell = cells[panel.interval, panel.cell]
    panel.left = left
    panel.half = 0.5 * (right - left)
    count = points_of(work)
    copy_row(panel.g, cell.g, count)
    copy_row(panel.u, cell.u, count)
    copy_row(panel.dg, cell.dg, count)
    copy_end(panel.entry, cell.entry)
    copy_end(panel.exit, cell.exit)
    complete(panel, rho, points_of(work))


@inner_jit
def complete(panel, rho, count):
    """Fill what follows from the transmission and the half width; it is not solved yet."""
    half = panel.half
    for i in range(count & N):
        panel.inverse[i] = 1.0 / (rho + panel.g[i] * panel.g[i])
        panel.step[i] = half
    largest = max(panel.inverse[0], panel.inverse[N - 1])
    panel.sharp = tail_of(panel.inverse, count) / largest
    panel.plus.tail = UNSOLVED
    panel.minus.tail = UNSOLVED


@inner_jit
def halve(scene, cells, store, place, count):
    """Split the panel at `place` in two; returns the new number of panels.

    The left half keeps the place, the right half gets place `count` and follows it
    in the chain.
    """
    work = store.workspace[0]
    panel, new = store.panels[place], store.panels[count]
    left = panel.left
    middle = left + panel.half
    right = left + 2.0 * panel.half
    # a break of the mechanism keeps its exact angle
    if panel.next != LAST:
        right = store.panels[panel.next].left
    new.interval = panel.interval
    new.cell = 2 * panel.cell + 1
    panel.cell = 2 * panel.cell
    recall(work, panel, scene.path, cells, scene.rho, left, middle)
    recall(work, new, scene.path, cells, scene.rho, middle, right)
    new.next = panel.next
    panel.next = count
    new.kink = False
    return count + 1


@inner_jit
def lay_out(scene, cells, store, loose):
    """First panels of an engagement, fine enough for its geometry; returns their number."""
    edges = scene.edges
    intervals = edges.size - 1
    for k in range(intervals):
        panel = store.panels[k]
        panel.next = k + 1 if k + 1 < intervals else LAST
        # a corner of a table is none of the friction in a slot
        panel.kink = k > 0 and not scene.path.table
        panel.interval = k
        panel.cell = 1
        recall(store.workspace[0], panel, scene.path, cells, scene.rho, edges[k], edges[k + 1])
    count = intervals
    place = FIRST
    while place != LAST:
        while store.panels[place].sharp > COARSE * loose and count < MAX_PANELS // 8:
            count = halve(scene, cells, store, place, count)
        place = store.panels[place].next
    return count


@inner_jit
def tolerances(rtol):
    """Tails allowed in panels for a relative error: whole panel, and inside.

    Measured on random scenes the error is at most a hundredth of the square of
    the first and a twentieth of the second. Beyond 1e-8 that no longer holds of every
    scene, and next to nothing would be saved.
    """
    rtol = min(rtol, 1e-8)
    return 3.0 * np.sqrt(rtol), max(15.0 * rtol, 1e-14)
