"""Backlash: the free play of a shaft, which shows where it turns both ways.

A shaft with a free play w is pushed at either end of it and stays in between: it lags by w/2
behind what drives it, in either sense, and crosses over after each reversal.
"""

import math
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from escapement.mechanism import FloatArray

_ENGAGED = 10  # so many samples at either end of the play tell its width
_ROOM = 0.1  # a start is a smaller share of the travel, or nothing would ever cross the play
_WIDE = 4.0  # of normal errors and half a play, so many deviations are more than the play


class Backlash(NamedTuple):
    """Free play of a shaft, fitted beside all errors that are significant.

    shaft : "input" or "output".
    width : of the play, as an angle of that shaft [rad]. Below zero the output leads, as it does
        where the input's encoder itself has play.
    standard_error : of the width [rad].
    p_value : probability that independent normal errors show as much (F test).
    """

    shaft: str
    width: float
    standard_error: float
    p_value: float


def with_play(angle: FloatArray, width: float) -> FloatArray:
    """Angle of a shaft behind a free play, whose middle it begins in [rad]."""
    play = 0.5 * width
    followed = accumulate(angle.tolist(), lambda at, end: min(max(at, end - play), end + play))
    return np.array([*followed])


def lag(angle: FloatArray, width: float) -> FloatArray:
    """What a shaft leads by over the free play, from -1/2 to 1/2, shape (n,) [-]."""
    return np.asarray((with_play(angle, width) - angle) / width)


def first_engaged(share: FloatArray) -> int | None:
    """Where a shaft has first come to an end of its play: where it is before, nothing tells.

    None where samples at both ends are too few to tell the width.
    """
    ends = share > 0.499, share < -0.499
    if min(map(np.count_nonzero, ends)) < _ENGAGED:
        return None
    return int(min(map(np.argmax, ends)))


def first_width(angle: FloatArray, errors: FloatArray, slope: float) -> float:
    """A width to begin with, which errors allow: rather too wide than too narrow [rad]."""
    room = _ROOM * float(np.ptp(angle))
    return min(_WIDE * float(errors.std()) / slope, room) if slope > 0.0 else room


def next_width(found: tuple[float, float, float], last: float) -> float:
    """The width for the next fit from amplitude, standard error and p-value of this one."""
    width = max(abs(found[0]), 3.0 * found[1])
    # one that is not told keeps its last width
    return width if math.isfinite(width) and width > 0.0 else last
