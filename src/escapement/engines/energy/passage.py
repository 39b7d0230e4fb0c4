"""What a march is asked for, where it stands, and what it finds: its records.

The steps of `march` hand these on; all of them are named tuples of plain numbers.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from escapement.engines.energy.locate import Turned

NOWHERE = np.int64(-1)
"""Stands for a point where there is none."""


class Record(IntEnum):
    """What a march is asked for, each with all before it.

    MAP: the map from w at entry to w at exit, blind for a pair of reversals inside a panel.
    TIME: also the time. EXTREMA: also the extrema of the driver speed, and how many reversals
    there are. EVERYTHING: also where and when they are.
    """

    MAP = 0
    TIME = 1
    EXTREMA = 2
    EVERYTHING = 3


class Request(NamedTuple):
    """What a march is asked for.

    record : a `Record`.
    loose, strict : tail allowed in a panel for whole-panel integrals, and for values
        inside it, as `panels.tolerances` gives them.
    """

    record: int
    loose: float
    strict: float


class State(NamedTuple):
    """Where a march stands: at the left end of a panel.

    place : of the panel in the store.
    w, energy : theta_dot^2, and E = (rho + g^2) w.
    side : of the slot, s. rising : sign of the acceleration before, 0 where there is none.
    time : since the entry.
    exponent, source : of the map E = exp(-exponent) E_entry + source to here.
    used : how many events are noted. kink_noted : whether that of the left end is among them.
    """

    place: int
    w: float
    energy: float
    side: float
    rising: float
    time: float
    exponent: float
    source: float
    used: int
    kink_noted: bool


class Passage(NamedTuple):
    """What one panel does to the motion.

    split : whether it must be halved first.
    stalled : whether the motion ends inside it, at driver angle `angle` [rad].
    energy, w, contact : E, w and X by s at the right end.
    time : from the entry to the right end, or to the stall.
    reversal : first point behind a pin reversal, `NOWHERE` without one.
    slower : points where the driver gains no speed.
    left_contact : X by s at the left end.
    """

    split: bool
    stalled: bool
    angle: float
    energy: float
    w: float
    contact: float
    time: float
    reversal: int
    slower: int
    left_contact: float


class Extremum(NamedTuple):
    """An extremum of the driver speed that a panel holds.

    split : whether the panel must be halved first.
    point : the point behind it, `NOWHERE` without one.
    first, final : J theta_ddot at the left end, and at the right end or reversal.
    time, energy, side : of the left end.
    coarse : whether the panel is too coarse to be interpolated.
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
    """What a march finds.

    status : of `Status`.
    w : at the exit. angle : driver angle of a stall [rad].
    time : from entry to exit, or stall.
    exponent, source : w_out (rho + g_out^2) = exp(-exponent) w_in (rho + g_in^2) + source for
        the sides switched at the same angles.
    side, rising : at the exit.
    panels, used : how many panels and events there are.
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
    """What was noted of a reversal and an extremum inside a panel.

    split : whether the panel must be halved first. used : how many events are noted.
    turned : the motion behind the reversal, where there is one.
    """

    split: bool
    used: int
    turned: Turned
