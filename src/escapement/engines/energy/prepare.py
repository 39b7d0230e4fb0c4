"""The first three arguments of the kernels, derived once for each escapement."""

from typing import Any

import numpy as np

from escapement.engines.energy.calls import kernel_addresses
from escapement.engines.energy.cells import CELL, tabulate_cells
from escapement.engines.energy.gauss import N
from escapement.engines.energy.panels import WORKSPACE
from escapement.model import Escapement, FloatArray
from escapement.scene import Path, scene_tuple

_KEY = "energy.cells"


def prepared(escapement: Escapement) -> tuple[Any, tuple[Any, ...], FloatArray]:
    """Addresses of the long kernels, scene as plain tuples, and cells of the mechanism.

    They are kept on the escapement, so that its next call does not tabulate the cells again.
    """
    kept = escapement.kept
    if _KEY not in kept:
        scene = escapement.scene
        kept[_KEY] = kernel_addresses(), scene_tuple(scene), cells_of(scene.path, scene.edges)
    result: tuple[Any, tuple[Any, ...], FloatArray] = kept[_KEY]
    return result


def cells_of(path: Path, edges: FloatArray) -> FloatArray:
    """The first cells of every interval between the edges of a mechanism."""
    # a table has many intervals, which are short and need few halvings
    most = 2**5 if edges.size < 8 else 2**2
    cells = np.empty((edges.size - 1, most), CELL)
    work = np.zeros(1, WORKSPACE)
    work["points"] = N
    tabulate_cells(path, edges, work, np.empty((most, 2)), cells)
    return cells
