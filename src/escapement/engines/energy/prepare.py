"""What the kernels need of a scene beside its numbers, derived once for each escapement."""

from typing import Any

import numpy as np

from escapement.engines.energy.calls import addresses
from escapement.engines.energy.cells import CELL, tabulate_cells
from escapement.engines.energy.gauss import N
from escapement.engines.energy.panels import WORKSPACE
from escapement.jit import inner_jit
from escapement.model import Escapement, FloatArray
from escapement.scene import Path, Scene

_KEY = "energy.cells"


def prepared(escapement: Escapement) -> tuple[Any, tuple[Any, ...], FloatArray]:
    """Addresses of the long kernels, scene, and cells of the mechanism: what kernels take first.

    The scene is a plain tuple, see `scene_of`.
    """
    kept = escapement.kept
    if _KEY not in kept:
        path, *rest = escapement.scene
        edges = escapement.scene.edges
        kept[_KEY] = addresses(), (tuple(path), *rest), cells_of(path, edges)
    return kept[_KEY]


@inner_jit(allocates=True, inlined=True)
def scene_of(plain):
    """Scene of a plain tuple.

    To find out the type of a named tuple takes Numba half a microsecond, a twentieth of a
    simulation: what Python calls takes plain ones.
    """
    path, edges, dwell, rho, mu_plus, mu_minus, load = plain
    return Scene(Path(path[0], path[1], path[2]), edges, dwell, rho, mu_plus, mu_minus, load)


def cells_of(path: Path, edges: FloatArray) -> FloatArray:
    """The first cells of a mechanism; a table has many intervals, so few of each."""
    most = 2**5 if edges.size < 8 else 2**2
    cells = np.empty((edges.size - 1, most), CELL)
    work = np.zeros(1, WORKSPACE)
    work["points"] = N
    tabulate_cells(path, edges, work, np.empty((most, 2)), cells)
    return cells
