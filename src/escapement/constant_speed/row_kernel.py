"""What is computed of many indexing drives of one mechanism, compiled."""

from escapement.constant_speed.cycle_figures import CycleFigures, figures_of
from escapement.constant_speed.knock import Knock, knock
from escapement.constant_speed.ringing import ringing
from escapement.dynamics.law import scene_of, scene_with
from escapement.dynamics.needs import NUMBERS
from escapement.mechanisms.slotted import slide_edges
from escapement.numerics.jit import inner_jit, jit

GIVEN = len(NUMBERS)
EFFICIENCY, HALF_CLEARANCE, SWING, DAMPING = range(GIVEN, GIVEN + 4)
"""Columns of a row behind the numbers of its scene."""
KNOCK = len(CycleFigures._fields)
RINGING = KNOCK + len(Knock._fields)
"""First columns of what is found of impacts and of ringing."""


@jit(allocates=True)
def fill_rows(packed, half, numbers, table):
    """Fill a row of `table` with the figures, the impacts and the ringing of every drive.

    Parameters
    ----------
    packed : of any scene of the mechanism with thin pins, see `cycle_figures`.
    half : driver angle where the first half of the engagement ends.
    numbers : shape (n, k): numbers of each scene, and what the columns above name.
    table : shape (n, m): the fields of `CycleFigures`, `Knock` and `Ringing`.
    """
    shared = scene_of(packed)
    entry, exit_ = shared.edges[0], shared.edges[-1]
    for i in range(numbers.shape[0]):
        row, found = numbers[i], table[i]
        edges = shared.edges
        scene = scene_with(shared, edges, row)
        if not scene.path.table:
            edges = slide_edges(scene.path, scene.pin, shared.edges)
            scene = scene_with(shared, edges, row)
        figures, _reversals = figures_of(scene, edges, half, row[EFFICIENCY])
        _put(found, 0, figures)
        if row[HALF_CLEARANCE] > 0.0:
            blows = knock(scene.path.numbers, row[HALF_CLEARANCE], scene.load, entry, exit_)
            _put(found, KNOCK, blows)
        if row[SWING] > 0.0:
            _put(found, RINGING, ringing(scene.path, edges, row[SWING], row[DAMPING]))


@inner_jit
def _put(row, start, values):
    """Put the values of a tuple into a row."""
    for i in range(len(values)):
        row[start + i] = values[i]
