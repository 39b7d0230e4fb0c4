"""A start from rest, or from nearly no speed: the panel over the square root of the angle."""

import numpy as np

from escapement.dynamics import reduced_inertia
from escapement.engines.energy.gauss import POINTS, N
from escapement.engines.energy.panels import finish_geometry, points_of, solution_of
from escapement.engines.energy.records import copy_end
from escapement.engines.energy.sampling import net_torque_at
from escapement.engines.energy.solve import solve_side
from escapement.jit import inner_jit
from escapement.mechanisms.slotted import transmission_on


@inner_jit
def slope_of_w(scene, panel, side, w):
    """dw/dtheta = 2 theta_ddot at the left end of a panel."""
    end = panel.entry
    return 2.0 * net_torque_at(end, side, w, scene) / reduced_inertia(end.g, end.u, side, scene)


@inner_jit
def lay_out_start(scene, work, panel, offset):
    """Lay out `panel` a second time, over the square root of the angle, in the spare panel.

    From rest w grows in proportion to the angle, so dt/dtheta = 1/sqrt(w) is singular. With
    y = sqrt(offset + (theta - left)/length) the speed is in proportion to y, and dt/dy is
    smooth. The angle at which the speed was zero, y = 0, lies `offset` times the length of
    the panel before its left end.
    """
    start = work.spare
    left, half = panel.left, panel.half
    first, last = np.sqrt(offset), np.sqrt(1.0 + offset)
    for i in range(N):
        y = 0.5 * ((last + first) + (last - first) * POINTS[i])
        # the points in x of the ordinary panel that are Gauss points in y
        work.scratch[i] = 2.0 * (y * y - offset) - 1.0
        # dtheta/dx at these points; the row is free until there is a reversal
        work.slowness_change[i] = 2.0 * half * (last - first) * y
    count = points_of(work)
    transmission_on(scene.path, left, half, work.scratch, count, start.g, start.u, start.dg)
    copy_end(start.entry, panel.entry)
    copy_end(start.exit, panel.exit)
    start.left, start.half = left, half
    # theta' is not constant: it is set behind the call that sets it to the half width
    finish_geometry(start, scene.rho, count)
    for i in range(N):
        start.dtheta_dx[i] = work.slowness_change[i]


@inner_jit
def solve_start(scene, work, panel, side, w, strict):
    """Solve the spare panel in place of `panel`; returns whether it takes that place."""
    slope = slope_of_w(scene, panel, side, w)
    if not slope > 0.0:
        return False
    if panel.geometry_tail > strict:
        # over the square root of the angle g would be rougher still; a tail of 1 has the
        # panel halved
        solution_of(panel, side).tail = 1.0
        return False
    # w = 0 at the distance w/(dw/dtheta) before the left end
    lay_out_start(scene, work, panel, w / (2.0 * slope * panel.half))
    solution_of(work.spare, side).tail = work.spare.geometry_tail
    if work.spare.geometry_tail <= strict:
        solve_side(scene, work, work.spare, side)
    return True
