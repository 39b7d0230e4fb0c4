"""The path of a mechanism: flat numbers for kernels, and the angles between which it is smooth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from escapement.base.lazy import Lazy

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
else:
    np = Lazy("numpy")


class Path(NamedTuple):
    """Flat numbers from which kernels evaluate the transmission of a mechanism.

    table : whether `numbers` tabulate g over the driver angle, as `mechanisms.table` makes
        them; otherwise they describe the path of a pin in a slot, see `mechanisms.slotted`.
    numbers : shape (n,), in the order that `mechanisms.table` or `mechanisms.slotted` defines.
    """

    table: bool
    numbers: NDArray[np.float64]

    @property
    def corners(self) -> NDArray[np.float64]:
        """Driver angles [rad], shape (k,), at which the transmission of a table is not smooth.

        `numbers` holds them after the pieces of the table. A pin path has none, because they are
        among the breaks of its mechanism.
        """
        if not self.table:
            return self.numbers[:0]
        pieces, order = self.numbers[:2].astype(int)
        return self.numbers[3 + pieces * (1 + order) :]


class Meeting(NamedTuple):
    """A pin in a slot: the data in which the engagements of a mechanism differ.

    path, edges, dwell : as in `Scene`.
    late : driver angle by which its angle 0 lies behind the nominal dead centre [rad].
    turned : function from driver angles to the follower angle [rad], minus its steps from pin to
        pin.
    kind : how it begins: "overlap", "pick-up" or "strike", see `mechanisms.pattern`.
    jump : by how much the follower jumps ahead there [rad].
    radius : distance of the pin from the follower's axis there, in the path's unit of length.
    """

    path: Path
    edges: NDArray[np.float64]
    dwell: float
    late: float
    turned: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    kind: str
    jump: float
    radius: float


def smooth_intervals(path: Path, breaks: Sequence[float]) -> NDArray[np.float64]:
    """Driver angles between which the motion is smooth except for reversals [rad], ascending.

    They are the breaks of the mechanism and the corners of a table, since no quadrature for
    smooth functions is accurate across one. An edge is left out if its distance from the edge
    before it, or from the last one, is below 1e-9 of the whole range: it may be due to rounding.
    """
    edges = sorted({*breaks, *path.corners.tolist()})
    gap = 1e-9 * (edges[-1] - edges[0])
    chosen = edges[:1]
    chosen += [b for a, b in pairwise(edges[:-1]) if b - a > gap and edges[-1] - b > gap]
    return np.array([*chosen, edges[-1]], dtype=float)


def writeable(path: Path) -> Path:
    """A copy of a path; kernels are compiled for contiguous arrays that may be written to."""
    # read-only arrays and non-contiguous ones have other types, for which nothing is compiled
    return Path(path.table, np.array(path.numbers, dtype=float))
