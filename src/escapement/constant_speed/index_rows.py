"""Many indexing drives of one mechanism: what is computed of each, in one call."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from escapement.base.quantity import declared
from escapement.constant_speed.cycle_figures import CycleFigures, figures_of
from escapement.constant_speed.index_case import IndexCase
from escapement.constant_speed.index_loads import IndexLoads
from escapement.constant_speed.knock import NO_KNOCK, Knock, knock
from escapement.constant_speed.ringing import NO_RINGING, Ringing, ringing
from escapement.dynamics.law import scene_of
from escapement.dynamics.needs import CONSTANT, NUMBERS
from escapement.mechanisms.path import smooth_intervals, writeable
from escapement.mechanisms.protocol import FloatArray, Mechanism, dwell_angle
from escapement.mechanisms.slotted import slide_edges
from escapement.model.natural import natural
from escapement.model.scene import Scene, scene_tuple
from escapement.numerics.jit import inner_jit, jit

_GIVEN = len(NUMBERS)
EFFICIENCY, HALF_CLEARANCE, SWING, DAMPING = range(_GIVEN, _GIVEN + 4)
"""Columns of a row behind the numbers of its scene."""
_ENDS = np.cumsum([len(kind._fields) for kind in (CycleFigures, Knock, Ringing)])
_KNOCK, _RINGING, _WIDTH = _ENDS.tolist()


@inner_jit(inlined=True)
def _scene_with(shared, edges, row):
    """The scene `shared` with other edges, and with the numbers in a row."""
    return Scene(
        shared.path, edges, shared.dwell, shared.torque, shared.driver_angle, row[0], row[1],
        row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10], row[11], row[12],
        row[13], row[14], row[15], row[16], row[17],
    )  # fmt: skip


@jit(allocates=True)
def fill_rows(scene_tuple, half, numbers, table):
    """Fill a row of `table` with the figures, the impacts and the ringing of every drive.

    Parameters
    ----------
    scene_tuple : of any scene of the mechanism with thin pins, see `cycle_figures`.
    half : driver angle where the first half of the engagement ends.
    numbers : shape (n, k): numbers of each scene, and what the columns above name.
    table : shape (n, m): the fields of `CycleFigures`, `Knock` and `Ringing`.
    """
    shared = scene_of(scene_tuple)
    entry, exit_ = shared.edges[0], shared.edges[-1]
    for i in range(numbers.shape[0]):
        row, found = numbers[i], table[i]
        edges = shared.edges
        scene = _scene_with(shared, edges, row)
        if not scene.path.table:
            edges = slide_edges(scene.path, scene.pin, shared.edges)
            scene = _scene_with(shared, edges, row)
        figures, _reversals = figures_of(scene, edges, half, row[EFFICIENCY])
        _put(found, 0, figures)
        if row[HALF_CLEARANCE] > 0.0:
            blows = knock(scene.path.numbers, row[HALF_CLEARANCE], scene.load, entry, exit_)
            _put(found, _KNOCK, blows)
        if row[SWING] > 0.0:
            _put(found, _RINGING, ringing(scene.path, edges, row[SWING], row[DAMPING]))


@inner_jit
def _put(row, start, values):
    """Put the values of a tuple into a row."""
    for i in range(len(values)):
        row[start + i] = values[i]


class IndexRows(IndexLoads):
    """Many indexing drives of one mechanism: every figure is an array of shape (n,).

    Parameters
    ----------
    mechanism : Mechanism
        Common to all, with thin pins that fit their slots.
    numbers : Mapping
        What `IndexCase` declares, and the lengths of the mechanism, by name: numbers, or arrays
        of shape (n,), in SI.
    count : int
        How many drives they are, n.
    """

    def __init__(self, mechanism: Mechanism, numbers: Mapping[str, Any], count: int) -> None:
        every = {name: entry.default for name, entry in declared(IndexCase).items()}
        every |= {name: x for name, x in numbers.items() if x is not None}
        self.__dict__.update(every)
        self.mechanism, self.inertial = mechanism, every["follower_inertia"] * every["speed"] ** 2
        self.half = IndexCase.half.fget(self)  # type: ignore[attr-defined]
        self.lengths = {name: every[name] for name in mechanism.lengths}
        table = self._solved(every, count)
        self.cycle = CycleFigures(*table[:_KNOCK])
        self.knock = Knock(*table[_KNOCK:_RINGING])
        self.ringing = Ringing(*table[_RINGING:])

    def _solved(self, every: Mapping[str, Any], count: int) -> FloatArray:
        """Fields of all figures, shape (m, n)."""
        crank = np.where(np.asarray(every["crank_radius"]) > 0.0, every["crank_radius"], 1.0)
        # the efficiency of this case is that of the drive, and gears have none of their own
        others = {"torque": self.inertial, "driver_inertia": every["follower_inertia"]}
        scene = natural({**every, **others, "efficiency": 1.0}, self.mechanism.meshed)
        columns = [scene[name] for name in NUMBERS]
        columns += [every["efficiency"], 0.5 * every["clearance"] / crank]
        columns += [2.0 * math.pi * every["load_frequency"] / every["speed"], every["load_damping"]]
        rows = np.column_stack([np.broadcast_to(x, count) for x in columns]).astype(float)
        path = writeable(self.mechanism.path)
        edges = smooth_intervals(path, self.mechanism.breaks)
        torque, dwell = np.array(CONSTANT), dwell_angle(self.mechanism)
        shared = Scene(path, edges, dwell, torque, 0.0, *rows[0, :_GIVEN].tolist())
        table = np.tile([*np.full(_KNOCK, np.nan), *NO_KNOCK, *NO_RINGING], (count, 1))
        fill_rows(scene_tuple(shared), self.half, rows, table)
        return table.T
