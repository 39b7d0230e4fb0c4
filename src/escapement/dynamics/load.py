"""A load that changes with the follower's angle, in units of the driving torque.

It is a torque against the follower's forward sense, whichever way it turns. `Scene.load_curve`
holds it in one of four ways:

- a single number: there is no such load.
- over the driver angle of a cell, by the series of `mechanisms.table`. The knots of the load are
  among the edges of the scene. So it is where the pin fits its slot, and the follower angle follows
  from the driver angle.
- over the driver angle in each cell of a round, from which `cell_of_round` takes one. First comes
  minus the number of cells, then where each cell begins, and for each cell the number of edges,
  the edges, and the load over the driver angle.
- over the follower angle, with clearance and between elastic walls. The first number, which is
  that of the pieces of a table, is 0. Then come the steps of the follower after which the load
  repeats, the angle of one step, and either moment and angle of a weight, or two zeros and the
  knots: their angles, ascending, the last one behind the first by the period, and the loads there.
"""

import numpy as np

from escapement.dynamics.power_flow import weight
from escapement.dynamics.torque import KNOT_GAP, cell_of
from escapement.mechanisms.path import PIECES
from escapement.mechanisms.slotted import angle_in_slot
from escapement.mechanisms.table import ratio_at
from escapement.numerics.jit import inner_jit
from escapement.numerics.known import where_known

STEPS, STEP, MOMENT, ANGLE, KNOTS = range(PIECES + 1, PIECES + 6)
"""Indices of a load over the follower angle; `KNOTS` is that of its first knot."""


@where_known("motor", lambda scene: False)
def has_load_curve(scene):
    """Whether a load changes with the follower's angle."""
    return len(scene.load_curve) > 1


@where_known("motor", lambda theta, side, scene: 0.0)
def load_at(theta, side, scene):
    """The part of the load that changes, at a driver angle; the side is 0 in a dwell."""
    if side == 0.0 or len(scene.load_curve) < 2:
        return 0.0
    return _engaged_load(theta, scene)


@inner_jit
def _engaged_load(theta, scene):
    """The load of `load_at` where there is one; on its own, so that `load_at` is inlined."""
    if scene.load_curve[PIECES] == 0.0:
        phi = angle_in_slot(scene.path, theta)
        return load_over(phi, 0.0, scene.driver_angle, scene)[0] / weight(scene)
    return ratio_at(scene.load_curve, theta)[0] / weight(scene)


@where_known("motor", lambda load, scene: scene.load)
def whole_load(load, scene):
    """The constant load and, if there is one, the part that changes."""
    return scene.load + load if len(scene.load_curve) > 1 else scene.load


@inner_jit(allocates=True, inlined=True)
def cell_of_round(loads, index):
    """The edges of a cell, and the load in it, from the loads in a round of cells."""
    first, last = int(loads[1 + index]), int(loads[2 + index])
    behind = first + 1 + int(loads[first])
    return loads[first + 1 : behind], loads[behind:last]


@inner_jit
def repeats_each_step(scene):
    """Whether the load is the same in each cell."""
    return len(scene.load_curve) < 2 or scene.load_curve[STEPS] == 1.0


@inner_jit
def is_weight(scene):
    """Whether a load over the follower angle is that of a weight."""
    return scene.load_curve[MOMENT] > 0.0


@inner_jit
def _turned(driver_angle, scene):
    """By how much the follower has turned before the cell after a driver angle, less the turns
    after which the load repeats."""
    steps = np.rint(driver_angle / cell_of(scene)) % scene.load_curve[STEPS]
    return steps * scene.load_curve[STEP]


@inner_jit
def _lap_and_knot(phi, curve):
    """Angle of the last repetition before a follower angle, and the index of the last knot."""
    count = (len(curve) - KNOTS) // 2
    first = curve[KNOTS]
    period = curve[KNOTS + count - 1] - first
    lap = np.floor((phi - first) / period) * period
    low, high = KNOTS, KNOTS + count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if curve[middle] <= phi - lap:
            low = middle
        else:
            high = middle
    return lap, low


@inner_jit
def load_over(phi, sense, driver_angle, scene):
    """A load over the follower angle, and its slope by the angle.

    Parameters
    ----------
    phi : follower angle of the cell [rad].
    sense : sense of the follower, which decides on the slope at a knot.
    driver_angle : driver angle turned before the cell [rad].
    """
    curve = scene.load_curve
    phi += _turned(driver_angle, scene)
    if curve[MOMENT] > 0.0:
        angle = phi + curve[ANGLE]
        return curve[MOMENT] * np.sin(angle), curve[MOMENT] * np.cos(angle)
    lap, k = _lap_and_knot(phi + sense * KNOT_GAP, curve)
    count = (len(curve) - KNOTS) // 2
    load = curve[k + count]
    slope = (curve[k + count + 1] - load) / (curve[k + 1] - curve[k])
    return load + slope * (phi - lap - curve[k]), slope


@inner_jit
def load_knot(phi, sense, driver_angle, scene):
    """The next follower angle in a sense at which a load over it is not smooth, infinite if there
    is none. Arguments are as of `load_over`."""
    curve = scene.load_curve
    if sense == 0.0 or curve[MOMENT] > 0.0:
        return sense * np.inf
    turned = _turned(driver_angle, scene)
    lap, k = _lap_and_knot(phi + turned + sense * KNOT_GAP, curve)
    return lap + curve[k + 1 if sense > 0.0 else k] - turned


@inner_jit(allocates=True)
def in_torque_units(curve, unit):
    """A load over the follower angle in another unit of torque."""
    found = curve.copy()
    found[MOMENT] /= unit
    for i in range(KNOTS + (len(curve) - KNOTS) // 2, len(curve)):
        found[i] /= unit
    return found
