"""Many indexing drives of one mechanism: what is computed of each, in one call."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from escapement.base.quantity import declared
from escapement.constant_speed.cycle_figures import CycleFigures
from escapement.constant_speed.index_case import IndexCase
from escapement.constant_speed.index_loads import IndexLoads
from escapement.constant_speed.knock import NO_KNOCK, Knock
from escapement.constant_speed.ringing import NO_RINGING, Ringing
from escapement.constant_speed.row_kernel import GIVEN, KNOCK, RINGING, fill_rows
from escapement.dynamics.needs import CONSTANT, NO_CURVE, NUMBERS
from escapement.mechanisms.path import smooth_intervals, writeable
from escapement.mechanisms.protocol import FloatArray, Mechanism, dwell_angle
from escapement.model.load_cells import in_a_round, load_cells, over_follower
from escapement.model.load_curve import steps_of
from escapement.model.materials import first_given
from escapement.model.scene import Scene, packed


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
        self.cycle = CycleFigures(*table[:KNOCK])
        self.knock = Knock(*table[KNOCK:RINGING])
        self.ringing = Ringing(*table[RINGING:])

    def _solved(self, every: Mapping[str, Any], count: int) -> FloatArray:
        """Fields of all figures, shape (m, n)."""
        crank, scene = first_given(every["crank_radius"], 1.0), self.natural_numbers()
        columns = [scene[name] for name in NUMBERS]
        columns += [every["efficiency"], 0.5 * every["clearance"] / crank]
        columns += [2.0 * math.pi * every["load_frequency"] / every["speed"], every["load_damping"]]
        rows = np.column_stack([np.broadcast_to(x, count) for x in columns]).astype(float)
        path = writeable(self.mechanism.path)
        edges = smooth_intervals(path, self.mechanism.breaks)
        torque, dwell = np.array(CONSTANT), dwell_angle(self.mechanism)
        curve = over = np.array(NO_CURVE)
        units = np.broadcast_to(self.inertial, count).astype(float)
        if (load := every["load_curve"]) is not None:
            cells = load_cells(load, self.mechanism)
            curve = in_a_round([(cell.edges, cell.numbers) for cell in cells])
            step = float(self.mechanism.follower_step)
            over = over_follower(load, steps_of(load, abs(step)), step)
        given = curve, np.array(NO_CURVE), *rows[0, :GIVEN].tolist()
        shared = Scene(path, edges, dwell, torque, 0.0, *given)
        table = np.tile([*np.full(KNOCK, np.nan), *NO_KNOCK, *NO_RINGING], (count, 1))
        fill_rows(packed(shared), self.half, rows, units, over, table)
        return table.T
