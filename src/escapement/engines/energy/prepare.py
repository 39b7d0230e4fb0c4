"""What the kernels need of a scene beside its numbers, derived once for each escapement."""

from typing import TYPE_CHECKING, Any

from escapement.engines.energy.calls import addresses
from escapement.engines.energy.cells import tabulate_cells
from escapement.jit import jit
from escapement.model import Escapement, FloatArray
from escapement.scene import Path, Scene

if TYPE_CHECKING:
    from numpy import ndarray

_KEY = "energy.cells"


def prepared(escapement: Escapement) -> tuple[Any, tuple[Any, ...], "ndarray"]:
    """Addresses of the long kernels, scene, and cells of the mechanism: what kernels take first.

    The scene is a plain tuple, see `scene_of`.
    """
    kept = escapement.kept
    if _KEY not in kept:
        path, *rest = escapement.scene
        edges = escapement.scene.edges
        kept[_KEY] = (tuple(path), *rest), cells_of(path, edges)
    return addresses(), *kept[_KEY]


@jit(allocates=True, inlined=True)
def scene_of(plain):
    """Scene of a plain tuple.

    To find out the type of a named tuple takes Numba half a microsecond, a twentieth of a
    simulation: what Python calls takes plain ones.
    """
    path, edges, dwell, rho, mu_plus, mu_minus, load = plain
    return Scene(Path(path[0], path[1], path[2]), edges, dwell, rho, mu_plus, mu_minus, load)


def cells_of(path: Path, edges: FloatArray) -> "ndarray":
    """The first cells of a mechanism; a table has many intervals, so few of each."""
    return tabulate_cells(path, edges, 5 if edges.size < 8 else 2)
