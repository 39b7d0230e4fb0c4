"""The path of a mechanism: flat numbers for kernels, and the angles between which it is smooth."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

from escapement.base.lazy import FloatArray, np


class PinNumbers(NamedTuple):
    """The numbers of a pin path: of a pin that moves along C = P exp(i a theta) + Q exp(i b theta).

    With h = (a - b) theta/2 and L = L0 + L1 sin^2 h, `slotted.pose_at` computes
    g = (G0 + G1 sin^2 h)/L, u = U1 sin h cos h/L and R^2 = L from them.

    half_rate : h/theta.
    l0, l1, g0, g1, u1 : the coefficients above.
    rate_sum : a + b, in the sense in which the follower turns.
    exit : driver angle of the exit [rad] if g is zero there, otherwise 0.
    g2 : G0 if `exit` is 0, otherwise 0.
    pin_rate : b in the follower's sense, by which the pin's body turns per driver radian.
    offset : distance of the slot's line from the follower's axis.
    """

    half_rate: float
    l0: float
    l1: float
    g0: float
    g1: float
    u1: float
    rate_sum: float
    exit: float
    g2: float
    pin_rate: float
    offset: float


HALF_RATE, L0, L1, G0, G1, U1, RATE_SUM, EXIT, G2, PIN_RATE, OFFSET = range(len(PinNumbers._fields))
"""Indices of `PinNumbers` in the array `Path.numbers`."""
PIECES, TERMS, EDGES = range(3)
"""Indices of a table's numbers: how many pieces and terms of a series there are; the first edge.

The number of terms is negative where a second table follows, of the pin's distance R in a slot."""


class Path(NamedTuple):
    """Flat numbers from which kernels evaluate the transmission of a mechanism.

    table : whether `numbers` tabulate g over the driver angle, and R where a pin slides, as
        `mechanisms.table` makes them; otherwise they describe the path of a pin in a slot.
    numbers : shape (n,): `PinNumbers`, or a table's numbers in the order of `mechanisms.table`.
    """

    table: bool
    numbers: FloatArray

    @property
    def meshed(self) -> bool:
        """Whether it is that of gears, in which no pin slides in a slot."""
        return bool(self.table and self.numbers[TERMS] > 0.0)

    @property
    def corners(self) -> FloatArray:
        """Driver angles [rad], shape (k,), at which the transmission of a table is not smooth.

        `numbers` holds them after the pieces of the table. Where a pin slides in a slot there are
        none, because they are among the breaks of its mechanism.
        """
        if not self.meshed:
            return np.empty(0)
        pieces, terms = int(self.numbers[PIECES]), int(self.numbers[TERMS])
        return self.numbers[EDGES + pieces + 1 + pieces * terms :]


class Pair(NamedTuple):
    """A pin in a slot: the data in which the engagements of a mechanism differ.

    path, edges, dwell : as in `Scene`.
    delay : driver angle by which its angle 0 lies behind the nominal dead centre [rad].
    follower_angle : function from driver angles to the follower angle [rad], minus its steps from
        pin to pin.
    kind : how it begins: "overlap", "pick-up" or "strike", see `mechanisms.pattern`.
    jump : by how much the follower jumps ahead there [rad].
    radius : distance of the pin from the follower's axis there, in the path's unit of length.
    """

    path: Path
    edges: FloatArray
    dwell: float
    delay: float
    follower_angle: Callable[[FloatArray], FloatArray]
    kind: str
    jump: float
    radius: float


def one_pitch(pitch: float) -> Pair:
    """What stands for the engagement of two bodies that touch anywhere, which have no path."""
    path = Path(False, np.zeros(len(PinNumbers._fields)))
    return Pair(
        path=path, edges=np.array([0.0, pitch]), dwell=0.0, delay=0.0,
        follower_angle=np.zeros_like, kind="overlap", jump=0.0, radius=math.nan,
    )  # fmt: skip


def smooth_intervals(path: Path, breaks: Sequence[float]) -> FloatArray:
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
