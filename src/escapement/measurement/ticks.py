"""Beats from durations or time stamps, without ticks that were missed, doubled or out of place.

Ticks are followed one by one. One that comes a whole number of beats after the last is taken, and
one that comes at another time is passed over; so the numbers of pins and slots of all later beats
stay right. A beat whose own duration is not known with certainty is left out.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.measurement.loggers import row_of
from escapement.mechanisms.protocol import FloatArray

_REMEDY = "give the times of the engagements in s, NaN for a missing one"
_SHORT, _LONG = 0.7, 1.4  # errors of parts keep beats between these shares of the median
_NEAR = 0.25  # a time this near to a whole number of beats is that number
_MOST = 20  # beats in a gap; the number of more cannot be counted surely
_IRREGULAR = 0.25  # with a larger share of such intervals the median is no beat
_INCREASING = 8  # so many durations do not increase throughout
_OUT, _ROUNDS = 6.0, 4  # standard deviations that no noise has, and rounds that show it


def ticks_of(given: ArrayLike, times: bool, pattern: int) -> tuple[FloatArray, tuple[str, ...]]:
    """Beats in turn [s], NaN where one is missing, and what was found amiss, in words.

    Parameters
    ----------
    given : array_like, shape (N,)
        Durations, or time stamps [s]; NaN or masked where one is missing.
    times : bool
        Whether they are time stamps.
    pattern : int
        Number of beats after which pins and slots meet again.
    """
    values = row_of("beats", given, _REMEDY)
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
        return beats, ()
    mended, faults = _counted(beats, float(np.median(known)))
    faults += [*_displaced(mended, pattern)]
    return mended, tuple(faults)


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
    shares = beats / beats[~off & np.isfinite(beats)].mean()
    taken, counts, doubtful = [0], list[int](), set[int]()
    for tick in range(1, beats.size + 1):
        # if it does not fit the last tick, that one may be an echo, and the one before it right
        for back, start in enumerate(taken[-1:-3:-1]):
            count = _whole(shares[start:tick], bool(off[start]))
            # of two ticks that are close to each other either may be the echo
            if count and (back == 0 or shares[tick - 1] >= _NEAR):
                left = len(taken) - back
                taken, counts = [*taken[:left], tick], [*counts[: left - 1], count]
                # a tick that is passed over close to one that is taken may be the right one
                passed = tick - start > 1
                doubtful |= {start} if passed and shares[start] < _NEAR else set()
                doubtful |= {tick} if passed and shares[tick - 1] < _NEAR else set()
                break
    found: list[float] = []
    faults = []
    for start, tick, count in zip(taken[:-1], taken[1:], counts, strict=True):
        known = count == 1 and not {start, tick} & doubtful
        found += [float(beats[start:tick].sum())] if known else [np.nan] * count
        if tick - start > 1 or off[start]:
            faults.append(_fault(shares[start:tick], start, count, known))
    if (start := taken[-1]) < beats.size:
        # a tick after the last beat changes no number of a pin or slot
        if not shares[start:].sum() < _SHORT:
            raise InvalidValue(
                f"beat {start} must be a whole number of beats, alone or with its neighbours, got "
                f"{shares[start]:.2f} times the mean of the others; take the recording from the "
                "beat after it on, or put NaN for as many beats as there were"
            )
        faults.append(_fault(shares[start:], start, 0, False))
    return np.array(found), faults


def _whole(shares: FloatArray, off: bool) -> int:
    """Beats in some intervals together, 0 if they are no whole number of beats."""
    if shares.size == 1 and not off:
        return 1
    total = float(shares.sum())
    count = round(total) if np.isfinite(total) else 0
    return count if count <= _MOST and abs(total - count) < _NEAR else 0


def _fault(shares: FloatArray, index: int, count: int, known: bool) -> str:
    """What was found at intervals, and what was done, in words."""
    alone = shares.size == 1
    name = f"beat {index} is" if alone else f"beats {index} to {index + shares.size - 1} are"
    sizes = " and ".join(f"{share:.2f}" for share in shares)
    if count == 0:
        what = "a tick after the last beat, which is left out"
    elif known:
        what = "an echo, whose parts are joined"
    elif alone:
        missed = "a tick was" if count == 2 else f"{count - 1} ticks were"
        what = f"{missed} not heard, and {count} beats are left out"
    else:
        left = "the beat is" if count == 1 else f"{count} beats are"
        what = f"ticks are missing, out of place or too many, and {left} left out"
    return f"{name} {sizes} of the others: {what}"


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
    out = np.flatnonzero(np.nan_to_num(np.abs(apart)) > _OUT * scatter + least)
    if out.size > 0.1 * beats.size:
        return
    for index in out.tolist():
        yield (
            f"engagement {index} takes {beats[index] / (beats[index] - apart[index]):.3f} times as "
            "long as with the same pin and slot in other rounds: a tick is out of place, and the "
            "beat is left out"
        )
        beats[index] = np.nan
