"""What is computed of many indexing drives of one mechanism, compiled."""

import numpy as np

from escapement.constant_speed.cycle_figures import CycleFigures, figures_of, join_steps
from escapement.constant_speed.knock import Knock, hardest_knock
from escapement.constant_speed.ringing import ringing
from escapement.constant_speed.wall_changes import united
from escapement.dynamics.law import scene_of, scene_with
from escapement.dynamics.load import cell_of_round, has_load_curve, in_torque_units
from escapement.dynamics.needs import NUMBERS
from escapement.mechanisms.path import EDGES, PIECES
from escapement.mechanisms.slotted import slide_edges
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit, jit

GIVEN = len(NUMBERS)
EFFICIENCY, HALF_CLEARANCE, SWING, DAMPING = range(GIVEN, GIVEN + 4)
"""Columns of a row behind the numbers of its scene."""
KNOCK = len(CycleFigures._fields)
RINGING = KNOCK + len(Knock._fields)
"""First columns of what is found of impacts and of ringing."""


@jit(allocates=True)
def fill_rows(packed, half, numbers, units, over, table):
    """Fill a row of `table` with the figures, the impacts and the ringing of every drive.

    Parameters
    ----------
    packed : of any scene of the mechanism with thin pins, see `cycle_figures`; a load that
        changes is that of a round, in N m, see `dynamics.load`.
    half : driver angle where the first half of the engagement ends.
    numbers : shape (n, k): numbers of each scene, and what the columns above name.
    units : unit of torque of each scene [N m].
    over : the load over the follower angle, in N m; idle without one.
    table : shape (n, m): the fields of `CycleFigures`, `Knock` and `Ringing`.
    """
    shared = scene_of(packed)
    entry, exit_ = shared.edges[0], shared.edges[-1]
    count = int(-shared.load_curve[PIECES]) if has_load_curve(shared) else 1
    steps = np.empty((count, KNOCK))
    for i in range(numbers.shape[0]):
        row, found = numbers[i], table[i]
        edges = shared.edges
        scene = scene_with(shared, edges, row)
        if not scene.path.table:
            edges = slide_edges(scene.path, scene.pin, shared.edges)
            scene = scene_with(shared, edges, row)
        for k in range(count):
            step, cuts = scene, edges
            if has_load_curve(shared):
                knots, load = cell_of_round(shared.load_curve, k)
                step = altered(scene, "load_curve", _in_units(load, units[i]))
                cuts = united(edges, knots)
            figures, _reversals = figures_of(step, cuts, half, row[EFFICIENCY])
            _put(steps[k], 0, figures)
        _put(found, 0, join_steps(steps, exit_ - entry + shared.dwell))
        if row[HALF_CLEARANCE] > 0.0:
            step = scene
            if has_load_curve(shared):
                step = altered(scene, "load_curve", in_torque_units(over, units[i]))
            _put(found, KNOCK, hardest_knock(step, row[HALF_CLEARANCE], count))
        if row[SWING] > 0.0:
            _put(found, RINGING, ringing(scene.path, edges, row[SWING], row[DAMPING]))


@inner_jit(allocates=True)
def _in_units(load, unit):
    """A load over the driver angle in another unit of torque."""
    found = load.copy()
    for i in range(EDGES + int(load[PIECES]) + 1, load.size):
        found[i] /= unit
    return found


@inner_jit
def _put(row, start, values):
    """Put values into a row."""
    for i in range(len(values)):
        row[start + i] = values[i]
