"""Backlash: the free play of a shaft, which shows where it turns both ways.

A shaft with a free play w is pushed at either end of it and stays in between: it lags by w/2
behind what drives it, in either sense, and crosses over after each reversal.
"""

import math
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from escapement.mechanisms.protocol import FloatArray

_ENGAGED = 10  # the width is fitted if so many samples are at either end of the backlash
_ROOM = (
    0.1  # the first estimate is at most this share of the travel, so that the backlash is crossed
)
_WIDE = 4.0  # a backlash is narrower than this many standard deviations of errors that it causes


class Backlash(NamedTuple):
    """Free play of a shaft, fitted together with all errors that are significant.

    shaft : "input" or "output".
    width : width of the backlash, as an angle of that shaft [rad]. If it is negative, the output
        leads, as it does if the input's encoder is loose.
    standard_error : standard error of the width [rad].
    p_value : probability that independent normal errors cause this width or more (F test).
    """

    shaft: str
    width: float
    standard_error: float
    p_value: float


def with_backlash(angle: FloatArray, width: float) -> FloatArray:
    """Angle of a shaft that is driven through a free play, beginning in its middle [rad]."""
    half_width = 0.5 * width
    followed = accumulate(
        angle.tolist(), lambda at, end: min(max(at, end - half_width), end + half_width)
    )
    return np.array([*followed])


def lag(angle: FloatArray, width: float) -> FloatArray:
    """By how much a shaft leads, as a share of its free play, -1/2 to 1/2, shape (n,) [-]."""
    return np.asarray((with_backlash(angle, width) - angle) / width)


def first_engaged(share: FloatArray) -> int | None:
    """First sample at which a shaft is at an end of its backlash; before it the side is unknown.

    None if there are too few samples at both ends to fit the width.
    """
    ends = share > 0.499, share < -0.499
    if min(map(np.count_nonzero, ends)) < _ENGAGED:
        return None
    return int(min(map(np.argmax, ends)))


def first_width(angle: FloatArray, errors: FloatArray, slope: float) -> float:
    """A first estimate of the width from the size of the errors, rather too wide [rad]."""
    room = _ROOM * float(np.ptp(angle))
    return min(_WIDE * float(errors.std()) / slope, room) if slope > 0.0 else room


def first_widths(
    driver: FloatArray, follower: FloatArray, slope: FloatArray, errors: FloatArray
) -> tuple[dict[str, float], int]:
    """For each shaft that turns both ways, a first estimate of its backlash [rad].

    Also returned is the first sample at which the side of each backlash is known.
    """
    found, start = {}, 0
    through = math.sqrt(float(np.mean(slope**2)))
    for name, angle, rate in (("input", driver, through), ("output", follower, 1.0)):
        width = first_width(angle, errors, rate)
        first = first_engaged(lag(angle, width)) if width > 0.0 else None
        if first is not None:
            found[name], start = width, max(start, first)
    return found, start


def next_width(found: tuple[float, float, float], last: float) -> float:
    """The width for the next fit from amplitude, standard error and p-value of this one."""
    width = max(abs(found[0]), 3.0 * found[1])
    # a width that could not be fitted stays as it was
    return width if math.isfinite(width) and width > 0.0 else last
