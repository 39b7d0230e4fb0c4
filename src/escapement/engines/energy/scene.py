"""A scene as the kernels take it, kept for the next call."""

from typing import Any

import numpy as np

from escapement.engines.energy.calls import addresses
from escapement.engines.energy.cells import tabulate_cells
from escapement.mechanisms.table import smooth_intervals
from escapement.model import FloatArray

# by path and breaks: the path as given, and what kernels take: cells, path, edges
_known: dict[tuple[int, bytes], tuple[FloatArray, tuple[FloatArray, ...]]] = {}
_MOST_KNOWN = 64
_last: tuple[Any, tuple[Any, ...]] = None, ()  # scene and numbers of the last call


def numbers_of(scene: tuple[Any, ...]) -> tuple[Any, ...]:
    """What kernels take of a scene: addresses, cells, path, edges, and what follows.

    `scene` begins with path and breaks; the edges are those of its smooth intervals.
    Mechanisms keep their path, so those last used are known by that array. An
    escapement keeps its scene.
    """
    global _last
    before, numbers = _last
    if scene is before:
        return numbers
    path, breaks, *rest = scene
    key = id(path), breaks.tobytes()
    known = _known.get(key)
    if known is None or known[0] is not path:
        plain = np.array(path)  # calls by address take no read-only array, and none with gaps
        edges = smooth_intervals(plain, breaks)
        if len(_known) >= _MOST_KNOWN:
            _known.clear()
        cells = tabulate_cells(plain, edges, _levels(edges))
        known = _known[key] = path, (cells, plain, edges)
    numbers = addresses(), *known[1], *rest
    _last = scene, numbers
    return numbers


def _levels(edges: FloatArray) -> int:
    """How often an interval's cells are halved, the whole one included."""
    return 6 if edges.size < 8 else 2
