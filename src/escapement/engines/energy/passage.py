"""The named tuples that the steps of a march hand on: its request, its state, its results."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from escapement.engines.energy.locate import AfterReversal

NOWHERE = np.int64(-1)
"""The index that stands for no point."""


class Detail(IntEnum):
    """The results that a march computes; each member includes those before it.

    MAP: the map from w at entry to w at exit. It misses a pair of reversals inside one panel.
    TIME: the time as well, and such pairs; reversals are counted and not located. EXTREMA: the
    extrema of the driver speed as well. EVERYTHING: the angles and times of the reversals too.
    """

    MAP = 0
    TIME = 1
    EXTREMA = 2
    EVERYTHING = 3


class Request(NamedTuple):
    """The requested results of a march, and their accuracy.

    detail : a `Detail`.
    loose, strict : tails allowed in a panel for integrals over the whole panel, and for
        values inside it, as `panels.tolerances` gives them.
    """

    detail: int
    loose: float
    strict: float


class MarchState(NamedTuple):
    """The motion at the left end of the panel that a march has reached.

    panel : index of the panel in the store.
    w, energy : theta_dot^2, and E = (rho + g^2) w.
    side : s, the side of the slot that carries the force.
    rising : sign of theta_ddot just before, 0 at the start of the motion; it is kept only from
        Detail.EXTREMA on.
    time : since the entry.
    exponent, source : of the affine map E = exp(-exponent) E_entry + source to here.
    used : number of events noted.
    left_noted : whether the events of this left end are among them, as they are when the
        panel is halved and entered again.
    """

    panel: int
    w: float
    energy: float
    side: float
    rising: float
    time: float
    exponent: float
    source: float
    used: int
    left_noted: bool


class Passage(NamedTuple):
    """The motion over one panel.

    split : whether the panel must be halved first, so that nothing else here counts but `angle`.
    stalled : whether the motion ends inside it.
    angle : driver angle of a stall, or at which to split, 0 for the middle of the panel [rad].
    energy, w, contact : E, w and s X at the right end; where there is a reversal, as if s had
        not changed.
    time : from the entry to the right end, or to the stall; with Detail.MAP to the left end.
    reversal : first point after a pin reversal, `NOWHERE` without one.
    slowing : number of points at which theta_ddot <= 0.
    left_contact : s X at the left end.
    """

    split: bool
    stalled: bool
    angle: float
    energy: float
    w: float
    contact: float
    time: float
    reversal: int
    slowing: int
    left_contact: float


class SpeedExtremum(NamedTuple):
    """The extremum of the driver speed in a panel, if there is one.

    split : whether the panel must be halved first.
    point : the first point after the extremum, `NOWHERE` without one.
    first, final : J theta_ddot at the left end, and at the right end or reversal.
    time, energy, side : time since the entry and E at the left end, and s.
    coarse : whether the panel is too coarse for interpolation inside it.
    """

    split: bool
    point: int
    first: float
    final: float
    time: float
    energy: float
    side: float
    coarse: bool


class Engagement(NamedTuple):
    """The result of a march over one engagement and the dwell after it.

    status : a value of `Status`.
    w : theta_dot^2 at the end of the cell.
    angle : driver angle of a stall [rad].
    time : from the entry to the end of the cell, or to the stall.
    exponent, source : of the affine map
        w_out (rho + g_out^2) = exp(-exponent) w_in (rho + g_in^2) + source,
        which holds as long as the reversals stay at their angles.
    side, rising : s at the exit, and the sign of theta_ddot at the end.
    panels, used : number of panels in use, and of events noted.
    """

    status: int
    w: float
    angle: float
    time: float
    exponent: float
    source: float
    side: float
    rising: float
    panels: int
    used: int


class Inside(NamedTuple):
    """The result of noting a reversal and an extremum inside a panel.

    split : whether the panel must be halved first.
    used : number of events noted.
    after_reversal : the motion after the reversal, where there is one.
    """

    split: bool
    used: int
    after_reversal: AfterReversal
