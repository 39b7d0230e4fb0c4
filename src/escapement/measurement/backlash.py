"""Backlash: the free play of a shaft, which shows where it turns both ways.

A shaft with a free play w is pushed at either end of it and stays in between: it lags by w/2
behind what drives it, in either sense, and crosses over after each reversal.
"""

import math
from itertools import accumulate

import numpy as np

from escapement.mechanisms.protocol import FloatArray

_ENGAGED = 10  # the width is fitted if so many samples are at either end of the backlash
_ROOM = (
    0.1  # the first estimate is at most this share of the travel, so that the backlash is crossed
)
_WIDE = 4.0  # a backlash is narrower than this many standard deviations of errors that it causes


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


def first_widths(
    driver: FloatArray, follower: FloatArray, slope: FloatArray, errors: FloatArray
) -> tuple[dict[str, float], int]:
    """For each shaft that turns both ways, a first estimate of its backlash, rather too wide [rad].

    Also returned is the first sample at which the side of each backlash is known.
    """
    found, start = {}, 0
    through = math.sqrt(float(np.mean(slope**2)))
    for name, angle, rate in (("input", driver, through), ("output", follower, 1.0)):
        width = _ROOM * float(np.ptp(angle))
        width = min(_WIDE * float(errors.std()) / rate, width) if rate > 0.0 else width
        first = first_engaged(lag(angle, width)) if width > 0.0 else None
        if first is not None:
            found[name], start = width, max(start, first)
    return found, start
