"""The rhythm of sounds: which beat each of them belongs to.

A cycle holds one sound or several, at fixed shares of its length: the two beats of a clock that is
out of beat, or the two sounds of one beat of a wheel with clearance. Sounds are followed one by
one, and the rhythm follows them, so that a rate that changes slowly is no hindrance.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.base.errors import InvalidValue
from escapement.measurement.onsets import Onsets
from escapement.mechanisms.protocol import FloatArray

FEWEST = 8
"""Sounds below which no rhythm is sought."""
_MOST = 4  # sounds in a cycle
_ALTERNATES = 3.0  # so much less do intervals of several sounds scatter, if they alternate
_STEADY = 0.02  # scatter of intervals, as a share, below which they do not alternate
_PAIRED = 0.6  # two sounds belong to one beat if their interval is shorter than this share
_NEAR = 0.25  # a sound this near to its time in the rhythm, as a share of an interval, fits
_FOLLOW = 0.2  # share of a deviation by which the rhythm follows a sound
_FITTING, _FILLED = 0.8, 0.5  # shares of sounds that fit, and of beats that are heard, at least
_SCATTER = 0.1  # scatter of sounds that have a rhythm, as a share of their interval, at most
_SPREAD = 4.0  # standard deviations from the rhythm within which a weak sound is a beat
_BY_CHANCE = 0.03  # probability with which noise may make such a sound there


class Rhythm(NamedTuple):
    """Beats in turn, and the sounds of each.

    beats : index of the sound with which each beat begins, -1 where none was heard, shape (N,).
    doubles : indices of other sounds: further ones of a beat, echoes and noises.
    period : mean time of a beat [s].
    sounds : number of sounds of a beat.
    """

    beats: NDArray[np.int64]
    doubles: NDArray[np.int64]
    period: float
    sounds: int


class _Cycle(NamedTuple):
    """What repeats: its length [s], and the shares of it at which sounds come, the first at 0."""

    length: float
    shares: FloatArray


def find_rhythm(sounds: Onsets, nominal: float | None = None) -> Rhythm:
    """Number the beats.

    Parameters
    ----------
    sounds : Onsets
        The sounds. Those that are not sure count only where the rhythm expects a beat.
    nominal : float, optional
        Expected time of a beat [s], which tells how many sounds it has.

    Raises
    ------
    InvalidValue
        When the sounds have no rhythm.
    """
    times, certain = sounds.times, np.flatnonzero(sounds.sure)
    if certain.size < FEWEST:
        raise InvalidValue(
            f"a rhythm must have at least {FEWEST} sounds, got {certain.size}; record longer, or "
            "nearer to the mechanism"
        )
    cycle = _cycle_of(times[certain])
    per_beat = _sounds_of_beat(cycle, nominal)
    slots, apart = _followed(times[certain], cycle)
    taken = _one_each(slots, apart)
    _check(slots, apart, taken, cycle)
    found = dict(zip(slots[taken].tolist(), certain[taken].tolist(), strict=True))
    _add_weak(found, sounds, cycle.shares.size, apart[taken])
    first, last = min(found), max(found)
    every = np.array([found.get(slot, -1) for slot in range(first, last + 1)])
    if per_beat > 1:
        # a beat begins with the sound that follows the longest silence
        begin = -first % per_beat
        every = every[begin::per_beat]
    used = {*every.tolist()}
    others = [i for i in sorted({*certain.tolist(), *found.values()}) if i not in used]
    filled = np.flatnonzero(every >= 0)
    span = times[every[filled[-1]]] - times[every[filled[0]]]
    period = float(span / (filled[-1] - filled[0]))
    return Rhythm(every[filled[0] : filled[-1] + 1], np.array(others, int), period, per_beat)


def _cycle_of(times: FloatArray) -> _Cycle:
    """The shortest cycle in which sounds repeat."""
    spreads, lengths = [], []
    for count in range(1, min(_MOST, times.size // 3) + 1):
        over = times[count:] - times[:-count]
        low, middle, high = np.quantile(over, (0.2, 0.5, 0.8)).tolist()
        lengths.append(middle)
        spreads.append(0.6 * (high - low) / middle)  # the standard deviation of normal numbers
    count = 1
    for more in range(2, len(spreads) + 1):
        if spreads[count - 1] > max(_STEADY, _ALTERNATES * spreads[more - 1]):
            count = more
    length = lengths[count - 1]
    steps = np.diff(times)
    # the cycle begins behind its longest silence
    means = [float(np.median(steps[k::count])) for k in range(count)]
    begin = (int(np.argmax(means)) + 1) % count
    after = np.cumsum([0.0, *(means[(begin + k) % count] for k in range(count - 1))])
    return _Cycle(length, after / length)


def _sounds_of_beat(cycle: _Cycle, nominal: float | None) -> int:
    """How many sounds belong to a beat: 1, or all of the cycle."""
    count = cycle.shares.size
    if count == 1:
        return 1
    if nominal is not None:
        whole, single = (abs(math.log(x / nominal)) for x in (cycle.length, cycle.length / count))
        return count if whole < single else 1
    steps = np.diff([*cycle.shares, 1.0])
    return count if steps.min() < _PAIRED * steps.max() else 1


def _followed(times: FloatArray, cycle: _Cycle) -> tuple[NDArray[np.int64], FloatArray]:
    """The slot of each sound, and how far it is from the rhythm [s].

    Slots count the sounds of all cycles; a sound that fits none has the slot -1.
    """
    count, shares = cycle.shares.size, [*cycle.shares.tolist(), 1.0]
    # a sound may be as far from its time as a share of the interval beside it
    reach = [
        _NEAR * min(shares[k + 1] - shares[k], shares[k] - (shares[k - 1] if k else shares[-2] - 1))
        for k in range(count)
    ]
    slots, apart = np.full(times.size, -1), np.full(times.size, np.nan)
    begin = _phase(times, cycle)
    origin, length = begin, cycle.length
    for i, time in enumerate(times.tolist()):
        turns = (time - origin) / length
        whole = math.floor(turns + reach[0])
        rest = turns - whole
        k = min(range(count + 1), key=lambda j: abs(rest - shares[j]))
        off = rest - shares[k]
        whole, k = (whole + 1, 0) if k == count else (whole, k)
        if abs(off) < reach[k]:
            slots[i], apart[i] = whole * count + k, off * length
            origin += _FOLLOW * off * length
    return slots - (slots[slots >= 0].min() if (slots >= 0).any() else 0) * (slots >= 0), apart


def _phase(times: FloatArray, cycle: _Cycle) -> float:
    """A time before all sounds at which a cycle begins, from the first few cycles."""
    some = times[: 8 * cycle.shares.size]
    begins = (some[:, None] - cycle.shares * cycle.length).ravel()
    turns = (some - begins[:, None])[..., None] / cycle.length - cycle.shares
    off = np.abs(turns - np.round(turns)).min(axis=2).sum(axis=1)
    found = float(begins[np.argmin(np.round(off, 12))])
    return found - cycle.length * (math.ceil((found - float(times[0])) / cycle.length) + 1)


def _one_each(slots: NDArray[np.int64], apart: FloatArray) -> NDArray[np.int64]:
    """Indices of the sound of each slot, the nearest to the rhythm, in turn."""
    order = np.lexsort((np.abs(apart), slots))
    order = order[slots[order] >= 0]
    return order[np.unique(slots[order], return_index=True)[1]]


def _check(
    slots: NDArray[np.int64], apart: FloatArray, taken: NDArray[np.int64], cycle: _Cycle
) -> None:
    """Raise InvalidValue unless most sounds fit the rhythm, and most beats are heard."""
    fitting, count = taken.size / slots.size, cycle.shares.size
    heard = taken.size / (slots.max() - slots[taken].min() + 1) if taken.size else 0.0
    scatter = float(np.std(apart[taken])) * count / cycle.length if taken.size else math.inf
    few = taken.size < FEWEST * count
    if fitting < _FITTING or heard < _FILLED or scatter > _SCATTER or few:
        raise InvalidValue(
            f"sounds must have a rhythm, got {slots.size} of which {taken.size} fit the one of "
            f"{cycle.length / cycle.shares.size:.3g} s, where {100.0 * heard:.0f} % of the beats "
            "are heard; record without other noises, nearer to the mechanism"
        )


def _add_weak(found: dict[int, int], sounds: Onsets, count: int, apart: FloatArray) -> None:
    """Fill slots in which nothing is sure with a weak sound that is close to its time."""
    filled = np.array(sorted(found))
    missing = np.setdiff1d(np.arange(filled[0], filled[-1] + 1), filled)
    scatter = 1.4826 * float(np.median(np.abs(apart - np.median(apart))))
    reach = np.hypot(_SPREAD * scatter, sounds.half_widths)
    possible = np.flatnonzero(~sounds.sure & (sounds.often * 2.0 * reach < _BY_CHANCE))
    if not possible.size:
        return
    at, reach = sounds.times[possible], reach[possible]
    for k in range(count):
        same, here = filled[filled % count == k], missing[missing % count == k]
        if same.size < 2:
            continue
        # the rhythm runs straight from one sure sound to the next one of its kind
        expected = np.interp(here, same, sounds.times[[found[slot] for slot in same.tolist()]])
        for slot, time in zip(here.tolist(), expected.tolist(), strict=True):
            near = int(np.abs(at - time).argmin())
            if abs(at[near] - time) <= reach[near]:
                found[slot] = int(possible[near])
