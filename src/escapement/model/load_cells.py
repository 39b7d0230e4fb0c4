"""A load over the follower angle as engines see it: over the driver angle of each cell."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.base.lazy import Lazy
from escapement.mechanisms.path import EDGES, PIECES, Pair
from escapement.mechanisms.protocol import Mechanism
from escapement.model.load_curve import Load, Unbalance, steps_of
from escapement.numerics.chebyshev import fit

optimize = Lazy("scipy.optimize")

FloatArray = NDArray[np.float64]
_ORDER, _DECAYED = 17, 4e-15
_SCAN = 64
"""Parts of an interval in which a knot is searched for; the follower turns one way in each."""
_GAP = 1e-9
"""A knot so close to an edge [rad] is on it."""


class LoadCell(NamedTuple):
    """The driver angles between which load and mechanism are smooth, and the load there.

    edges : as in `Scene`. numbers : as `Scene.load_curve` has them, in N m.
    """

    edges: FloatArray
    numbers: FloatArray

    def in_units(self, torque: float) -> FloatArray:
        """`Scene.load_curve` in units of this torque [N m]."""
        found = self.numbers.copy()
        found[EDGES + int(found[PIECES]) + 1 :] /= torque
        return found


def load_cell(load: Load, pair: Pair, turned: float) -> LoadCell:
    """A load in a cell before which the follower has turned by `turned` [rad]."""

    def angle(theta: FloatArray) -> FloatArray:
        return np.asarray(pair.follower_angle(theta)) + turned

    edges = _with_knots(load, pair.edges, angle)
    if isinstance(load, Unbalance):
        starts, rows = fit(lambda theta: load(angle(theta)), edges, _ORDER, _DECAYED, noise=0.0)
    else:
        # between knots a line over the follower angle; the rounding of a steep one is no kink
        starts, rows = fit(pair.follower_angle, edges, _ORDER, _DECAYED, noise=0.0)
        phi = angle(0.5 * (starts[:-1] + starts[1:]))
        slope = load.slope(phi)
        rows = slope[:, None] * rows
        rows[:, 0] += load(phi) - slope * (phi - turned)
    return LoadCell(edges, np.concatenate([np.array(rows.shape, float), starts, rows.reshape(-1)]))


def load_cells(load: Load, mechanism: Mechanism) -> list[LoadCell]:
    """The load in each engagement, up to where load and pairs of pin and slot repeat."""
    step, pairs = float(mechanism.follower_step), mechanism.pairs
    count = math.lcm(len(pairs), steps_of(load, abs(step)))
    return [load_cell(load, pairs[k % len(pairs)], k * step) for k in range(count)]


def in_a_round(cells: Sequence[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """Edges and loads of several cells in one array, as `dynamics.load` reads it."""
    parts = [np.concatenate([[edges.size], edges, load]) for edges, load in cells]
    begins = len(parts) + 2.0 + np.cumsum([0.0, *(part.size for part in parts)])
    return np.concatenate([[-float(len(parts))], begins, *parts])


def over_follower(load: Load, steps: int, step: float) -> FloatArray:
    """A load over the follower angle, as `dynamics.load` reads it.

    It repeats after so many steps, of the angle `step` [rad] each.
    """
    if isinstance(load, Unbalance):
        return np.array([0.0, steps, step, load.moment, load.angle])
    return np.array([0.0, steps, step, 0.0, 0.0, *load.angle, *load.torque])


def _with_knots(
    load: Load, edges: FloatArray, angle: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """The edges, and the driver angles at which the load is not smooth between them."""
    found = [*edges.tolist()]
    grid = np.concatenate([np.linspace(a, b, _SCAN, endpoint=False) for a, b in pairwise(edges)])
    grid = np.append(grid, edges[-1])
    phi = angle(grid)
    for knot in load.knots_between(float(phi.min()), float(phi.max())):
        for i in np.flatnonzero((phi[:-1] - knot) * (phi[1:] - knot) < 0.0):
            ends = float(grid[i]), float(grid[i + 1])
            theta = optimize.brentq(
                lambda x, knot=knot: float(angle(np.array(x))) - knot, *ends, xtol=1e-15
            )
            if np.abs(np.array(found) - theta).min() > _GAP:
                found.append(theta)
    return np.array(sorted(found))
