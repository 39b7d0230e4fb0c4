"""A start from rest: what happens where there is next to no speed."""

import numpy as np

from escapement.dynamics import reduced_inertia
from escapement.engines.energy.gauss import POINTS, N
from escapement.engines.energy.panels import complete, points_of, solution_of
from escapement.engines.energy.records import copy_end
from escapement.engines.energy.sampling import driving_at
from escapement.engines.energy.solve import solve_side
from escapement.jit import inner_jit
from escapement.mechanisms.slotted import transmission_on


@inner_jit
def braking(scene, panel, side, w):
    """Slope of w by driver angle at the left end, 2 theta_ddot."""
    end = panel.entry
    return 2.0 * driving_at(end, side, w, scene) / reduced_inertia(end.g, end.u, side, scene)


@inner_jit
def lay_out_start(scene, work, panel, way):
    """Fill the start's panel: `panel`, over the square root of the angle.

    From rest w grows like the angle, and 1/sqrt(w) is singular; over
    y = sqrt(way + (theta - left)/length), with the speed zero at y = 0, neither is.
    `way` is how far before the left end that lies, in lengths of the panel.
    """
    start = work.start
    left, half = panel.left, panel.half
    first, last = np.sqrt(way), np.sqrt(1.0 + way)
    for i in range(N):
        y = 0.5 * ((last + first) + (last - first) * POINTS[i])
        work.series[i] = 2.0 * (y * y - way) - 1.0
        work.difference[i] = 2.0 * half * (last - first) * y
    count = points_of(work)
    transmission_on(scene.path, left, half, work.series, count, start.g, start.u, start.dg)
    copy_end(start.entry, panel.entry)
    copy_end(start.exit, panel.exit)
    start.left, start.half = left, half
    complete(start, scene.rho, count)
    for i in range(N):
        start.step[i] = work.difference[i]


@inner_jit
def begin(scene, work, panel, side, w, strict):
    """Solve the start's panel in place of `panel`; whether that is the one to be passed."""
    slope = braking(scene, panel, side, w)
    if not slope > 0.0:
        return False
    if panel.sharp > strict:
        # over the square root of the angle it would be rougher still
        solution_of(panel, side).tail = 1.0
        return False
    lay_out_start(scene, work, panel, w / (2.0 * slope * panel.half))
    solution_of(work.start, side).tail = work.start.sharp
    if work.start.sharp <= strict:
        solve_side(scene, work, work.start, side)
    return True
