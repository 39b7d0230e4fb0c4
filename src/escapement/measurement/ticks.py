"""Beats from durations or time stamps, without ticks that were missed, doubled or out of place.

A tick that was not heard makes one interval of two beats, an echo two intervals of one beat, and a
tick out of place two intervals that only together are two beats. In all three cases intervals that
differ much from the others add up to a whole number of beats, which keeps the numbers of pins and
slots of all later beats right.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.mechanisms.protocol import FloatArray

_REMEDY = "give the times of the engagements in s, NaN for a missing one"
_SHORT, _LONG = 0.7, 1.4  # errors of parts keep beats between these shares of the median
_NEAR = 0.25  # a sum this near to a whole number of beats is that number
_MOST = 20  # beats in a gap; the number of more cannot be counted surely
_IRREGULAR = 0.25  # with a larger share of such intervals the median is no beat
_INCREASING = 8  # so many durations do not increase throughout
_OUT, _ROUNDS = 6.0, 4  # standard deviations that no noise has, and rounds that show it


class Ticks(NamedTuple):
    """Beats in turn [s], NaN where one is missing, and what was found amiss, in words."""

    beats: FloatArray
    faults: tuple[str, ...]


def ticks_of(given: ArrayLike, times: bool, pattern: int) -> Ticks:
    """Beats from durations, or from time stamps, with the faults that are certain mended.

    Parameters
    ----------
    given : array_like, shape (N,)
        Durations, or time stamps [s]; NaN or masked where one is missing.
    times : bool
        Whether they are time stamps.
    pattern : int
        Number of beats after which pins and slots meet again.
    """
    values = _row(given)
    beats = _differences(values) if times else values
    wrong = np.flatnonzero(~np.isnan(beats) & ~((beats > 0.0) & np.isfinite(beats)))
    if wrong.size:
        index = int(wrong[0])
        raise validate.fail(f"beat {index}", "finite and greater than 0", beats[index], _REMEDY)
    known = beats[np.isfinite(beats)]
    if not times and known.size >= _INCREASING and (np.diff(known) > 0.0).all():
        raise InvalidValue(
            f"beats must be durations, got {known.size} values that increase throughout, as time "
            "stamps do; give times=True if they are"
        )
    if not known.size:
        return Ticks(beats, ())
    mended, faults = _counted(beats, float(np.median(known)))
    faults += [*_displaced(mended, pattern)]
    return Ticks(mended, tuple(faults))


def _row(given: ArrayLike) -> FloatArray:
    try:
        values = np.ma.asanyarray(given).astype(float, copy=False)
    except (TypeError, ValueError):
        values = np.empty((0, 0))
    if values.ndim != 1:
        raise validate.fail("beats", "a row of real numbers", given, _REMEDY)
    return np.asarray(np.ma.filled(values, np.nan))


def _differences(stamps: FloatArray) -> FloatArray:
    known = np.flatnonzero(~np.isnan(stamps))
    back = np.flatnonzero(~(np.diff(stamps[known]) > 0.0))
    if back.size:
        index = int(known[back[0] + 1])
        rule = f"later than the one before it, {float(stamps[known[back[0]]])!r} s"
        raise validate.fail(f"time {index}", rule, stamps[index], "sort the times, without doubles")
    return np.diff(stamps)


def _counted(beats: FloatArray, typical: float) -> tuple[FloatArray, list[str]]:
    """Beats with the right number of them in place of intervals that are too short or too long."""
    off = (beats < _SHORT * typical) | (beats > _LONG * typical)
    if off.sum() > max(_IRREGULAR * beats.size, 1.0):
        raise InvalidValue(
            f"beats must be alike, got {off.sum()} of {beats.size} that differ by more than a "
            f"third from their median of {typical:.3g} s; check how ticks are detected"
        )
    unit = float(beats[~off & np.isfinite(beats)].mean())
    found: list[float] = []
    faults, index = [], 0
    while index < beats.size:
        if not off[index]:
            found.append(float(beats[index]))
            index += 1
            continue
        stop = index + 1
        while stop < beats.size and off[stop]:
            stop += 1
        before, after, count = _window(beats, found, index, stop, unit)
        del found[len(found) - before :]
        total = float(np.sum(beats[index - before : stop + after]))
        found += [total] if count == 1 else [np.nan] * count
        faults.append(_fault(beats / unit, index, stop, after, count))
        index = stop + after
    return np.array(found), faults


def _window(
    beats: FloatArray, found: list[float], index: int, stop: int, unit: float
) -> tuple[int, int, int]:
    """How many neighbours before and after intervals make a whole number of beats, and which."""
    alone = float(beats[index:stop].sum())
    left = found[-1] if found else np.nan
    right = float(beats[stop]) if stop < beats.size else np.nan
    whole = {}
    for window, more in {(0, 0): 0.0, (0, 1): right, (1, 0): left, (1, 1): left + right}.items():
        number = (alone + more) / unit
        count = round(number) if np.isfinite(number) else 0
        if 1 <= count <= _MOST and abs(number - count) < _NEAR:
            whole[window] = count
    both = (0, 1) in whole and (1, 0) in whole
    for window in ((0, 0), (1, 1)) if both else ((0, 0), (0, 1), (1, 0), (1, 1)):
        if window in whole:
            return *window, whole[window]
    if stop == beats.size and alone < _SHORT * unit:
        # a tick after the last beat changes no number of a pin or slot
        return 0, 0, 0
    raise InvalidValue(
        f"beat {index} must be a whole number of beats, alone or with its neighbours, got "
        f"{beats[index] / unit:.2f} times the mean of the others; take the recording from the "
        "beat after it on, or put NaN for as many beats as there were"
    )


def _fault(shares: FloatArray, index: int, stop: int, after: int, count: int) -> str:
    """What was found at intervals, and what was done, in words."""
    rows = range(index, stop + (after if count else 0))
    name = f"beat {index} is" if len(rows) == 1 else f"beats {index} to {rows[-1]} are"
    sizes = " and ".join(f"{shares[k]:.2f}" for k in rows)
    if count == 0:
        return f"{name} {sizes} of the others: a tick after the last beat, which is left out"
    if count == 1:
        return f"{name} {sizes} of the others: an echo, whose parts are joined"
    if len(rows) == 1 and shares[index] > 1.0:
        missed = "a tick was" if count == 2 else f"{count - 1} ticks were"
        return (
            f"{name} {sizes} times the others: {missed} not heard, and {count} beats are left out"
        )
    return (
        f"{name} {sizes} of the others: ticks are missing, out of place or too many, and "
        f"{count} beats are left out"
    )


def _displaced(beats: FloatArray, pattern: int) -> Iterator[str]:
    """Leave out beats that are far from those of the same pin and slot in other rounds."""
    padded = np.full(-(-beats.size // pattern) * pattern, np.nan)
    padded[: beats.size] = beats
    table = padded.reshape(-1, pattern)
    if np.isfinite(table).sum(axis=0).min() < _ROUNDS:
        return
    apart = (table - np.nanmedian(table, axis=0)).ravel()[: beats.size]
    known = np.sort(np.abs(apart[np.isfinite(apart)]))
    # of normal noise one in ten is beyond 1.645 standard deviations
    scatter = known[int(0.9 * (known.size - 1))] / 1.645
    steps = np.diff(np.unique(beats[np.isfinite(beats)]))
    # a coarse clock may show a difference of two steps of its own
    least = 2.0 * float(steps.min()) if steps.size else 0.0
    with np.errstate(invalid="ignore"):
        out = np.flatnonzero(np.abs(apart) > _OUT * scatter + least)
    if out.size > 0.1 * beats.size:
        return
    for index in out.tolist():
        yield (
            f"engagement {index} takes {beats[index] / (beats[index] - apart[index]):.3f} times as "
            "long as with the same pin and slot in other rounds: a tick is out of place, and the "
            "beat is left out"
        )
        beats[index] = np.nan
