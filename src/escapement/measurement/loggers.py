"""What loggers do to readings: coarse clocks, units that are not said, counters of few bits.

A register that is full starts again, and the angle seems to jump.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import spoken, validate
from escapement.base.errors import InvalidValue
from escapement.mechanisms.protocol import FloatArray

_REMEDY = "give the time of each sample in s"
_BITS = (8, 16, 24, 32)
_NEAR = 0.25  # neighbours must be nearer than this share of the register once it is undone
_DOUBTFUL = 10.0  # a ratio of times beyond this means a torque that is wrong a hundred times
_CLOSE = 4.0  # a ratio within this factor of that of a unit may come from the unit
_READ_AS_S = {"ns": 1e9, "us": 1e6, "ms": 1e3, "minutes": 1.0 / 60.0, "hours": 1.0 / 3600.0}
"""Units of time, and by how much times in them are too long if they are read as seconds."""


def checked_times(values: ArrayLike, lines: np.ndarray, where: str) -> tuple[FloatArray, str]:
    """Times that increase [s], and a remark if some of them were equal.

    Parameters
    ----------
    values : array_like, shape (n,)
        Times as they were given [s].
    lines : ndarray of int, shape (n,)
        Line of each sample, for messages.
    where : str
        What a line is called, for messages.

    Raises
    ------
    InvalidValue
        If there is not one finite time for each sample, or they do not increase.
    """
    times = row_of("time", values, _REMEDY)
    if times.shape != lines.shape:
        raise validate.fail("time", f"a row of {lines.size} times", values, _REMEDY)
    unknown = np.flatnonzero(~np.isfinite(times))
    if unknown.size:
        raise InvalidValue(
            f"time must be known for every sample, got none in {where} {lines[unknown[0]]}; "
            "delete this row, or fill the time in"
        )
    steps = np.diff(times)
    backward = np.flatnonzero(steps < 0.0)
    if backward.size or not np.ptp(times) > 0.0:
        at = backward[0] if backward.size else 0
        raise InvalidValue(
            f"time must increase, got {times[at + 1]:g} s after {times[at]:g} s in "
            f"{where} {lines[at + 1]}; sort the samples, or check the column of times"
        )
    equal = int(np.count_nonzero(steps == 0.0))
    if not equal:
        return times, ""
    tick = float(steps[steps > 0.0].min())
    return spread(times, tick), (
        f"{equal} times equal the one before, as those of a clock with steps of {tick:g} s do; "
        "samples within a step are taken as evenly spaced"
    )


def check_increasing(name: str, times: FloatArray) -> None:
    """Raise InvalidValue unless each of the known times is later than the one before it."""
    known = np.flatnonzero(np.isfinite(times))
    back = np.flatnonzero(np.diff(times[known]) <= 0.0)
    if back.size:
        before, index = known[back[0] : back[0] + 2]
        rule = f"later than the one before it, {times[before]:g} s"
        remedy = "sort the times, without doubles"
        raise validate.fail(f"{name} {index}", rule, float(times[index]), remedy)


def row_of(name: str, values: ArrayLike, remedy: str) -> FloatArray:
    """A row of real numbers, NaN for those that are masked, or InvalidValue."""
    try:
        given = np.ma.asanyarray(values).astype(float, copy=False)
    except (TypeError, ValueError):
        given = np.empty((0, 0))
    if given.ndim != 1:
        raise validate.fail(name, "a row of real numbers", values, remedy)
    return np.asarray(np.ma.filled(given, np.nan))


def spread(times: FloatArray, tick: float) -> FloatArray:
    """Times of a clock that shows only whole steps, spread evenly over each step [s].

    The first and the last step may be seen in part: their samples are as far apart as those of the
    step beside them.
    """
    starts = np.flatnonzero(np.diff(times, prepend=-np.inf) > 0.0)
    counts = np.diff(np.append(starts, times.size))
    gaps = tick / counts
    if counts.size > 1:
        gaps[[0, -1]] = np.minimum(gaps[[0, -1]], gaps[[1, -2]])
    position = np.arange(times.size) - np.repeat(starts, counts) + 0.5
    # the first step is seen from somewhere in it to its end
    position[: counts[0]] += tick / gaps[0] - counts[0]
    return np.asarray(times + np.repeat(gaps, counts) * position - 0.5 * tick)


def check_unit(name: str, ratio: float, text: str, torque: float | None = None) -> None:
    """Raise InvalidValue where measured times are far from those of a design.

    Parameters
    ----------
    name : str
        Argument that holds the measured times.
    ratio : float
        Measured time divided by the time of the design, above 0 [-].
    text : str
        Both times in words.
    torque : float, optional
        The design's torque [N m]; the message says with which torque the times would be right.
    """
    if 1.0 / _DOUBTFUL <= ratio <= _DOUBTFUL:
        return
    unit = min(_READ_AS_S, key=lambda one: abs(math.log(ratio / _READ_AS_S[one])))
    guess = ""
    if abs(math.log(ratio / _READ_AS_S[unit])) < math.log(_CLOSE):
        guess = f", which may be {unit} taken as s"
    right = "correct the numbers of the escapement"
    if torque is not None:
        needed = spoken.as_spoken(torque / ratio**2, "torque", 2)
        right = f"give the escapement a torque of about {needed}"
    raise InvalidValue(
        f"{name} must be of the order of the design's, got {text}; check the unit of the "
        f"times{guess}, or, if it is right, {right}"
    )


def unrolled(angle: FloatArray, count: float, turn: float) -> tuple[FloatArray, int, int]:
    """Angles that go on counting where their register started again.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        Angles, NaN where they are missing [rad].
    count : float
        Angle of one count [rad].
    turn : float
        A register of just one turn starts again each turn, which is no roll-over [rad].

    Returns
    -------
    angle : ndarray, shape (n,)
        The same array if nothing rolled over [rad].
    bits : int
        Bits of the register, 0 if nothing rolled over.
    first : int
        First sample behind a roll-over.
    """
    present = np.flatnonzero(np.isfinite(angle))
    counts = angle[present] / count
    if counts.size < 2:
        return angle, 0, 0
    for bits in _BITS:
        size = 2.0**bits
        whole = np.unwrap(counts, period=size)
        over = np.flatnonzero(np.abs(whole - counts) > 0.5)
        alike = np.ptp(counts) < size and np.abs(np.diff(whole)).max() < _NEAR * size
        if alike and over.size and abs(size * count - turn) > 1e-9 * turn:
            found = angle.copy()
            found[present] = count * whole
            return found, bits, int(present[over[0]])
    return angle, 0, 0
