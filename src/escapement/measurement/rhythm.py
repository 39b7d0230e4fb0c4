"""The rhythm of sounds and of ticks: which beat each of them belongs to.

A cycle holds one sound or several, at fixed shares of its length: the two beats of a clock that is
out of beat, or the two sounds of one beat of a wheel with clearance. Sounds are followed one by
one, and the rhythm follows them, so that a rate that changes slowly is no hindrance. A sound that
comes at another time is passed over, so that the numbers of all later beats stay right.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.base.errors import InvalidValue
from escapement.measurement.onsets import Onsets
from escapement.mechanisms.protocol import FloatArray

_FEWEST = 8  # sounds of which a rhythm is sought
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
    sounds : number of sounds of a beat.
    """

    beats: NDArray[np.int64]
    doubles: NDArray[np.int64]
    sounds: int


class _Cycle(NamedTuple):
    """What repeats: its length [s], and the shares of it at which sounds come, the first at 0."""

    length: float
    shares: FloatArray


def find_rhythm(sounds: Onsets, nominal: float | None = None, run_up: bool = False) -> Rhythm:
    """Number the beats.

    Parameters
    ----------
    sounds : Onsets
        The sounds. Those that are not sure count only where the rhythm expects a beat.
    nominal : float, optional
        Expected time of a beat [s], which tells how many sounds it has.
    run_up : bool
        Whether there is no rhythm yet: then each sure sound is a beat.

    Raises
    ------
    InvalidValue
        When the sounds have no rhythm.
    """
    times, certain = sounds.times, np.flatnonzero(sounds.sure)
    if certain.size < _FEWEST:
        raise InvalidValue(
            f"a rhythm must have at least {_FEWEST} sounds, got {certain.size}; record longer, or "
            "nearer to the mechanism"
        )
    if run_up:
        return Rhythm(certain, np.empty(0, int), 1)
    cycle = _cycle_of(times[certain])
    per_beat = _sounds_of_beat(cycle, nominal)
    slots, apart = _followed(times[certain], cycle)
    taken = _one_each(slots, apart)
    _check(slots, apart, taken, cycle)
    found = dict(zip(slots[taken].tolist(), certain[taken].tolist(), strict=True))
    _add_weak(found, sounds, cycle.shares.size, apart[taken])
    first, last = min(found), max(found)
    every = np.array([found.get(slot, -1) for slot in range(first, last + 1)])
    # a beat of several sounds begins with the one that follows the longest silence
    every = every[-first % per_beat :: per_beat]
    filled = np.flatnonzero(every >= 0)
    others = np.setdiff1d([*certain, *found.values()], every)
    return Rhythm(every[filled[0] : filled[-1] + 1], others, per_beat)


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
    if nominal is not None:
        whole, single = (abs(math.log(x / nominal)) for x in (cycle.length, cycle.length / count))
        return count if whole < single else 1
    steps = np.diff([*cycle.shares, 1.0])
    return count if steps.min() < _PAIRED * steps.max() else 1


def _followed(times: FloatArray, cycle: _Cycle) -> tuple[NDArray[np.int64], FloatArray]:
    """The slot of each sound, and how far it is from the rhythm [s].

    Slots count the sounds of all cycles from the first one on; a sound that fits none has -1.
    """
    count, shares = cycle.shares.size, np.append(cycle.shares, 1.0)
    steps = np.diff(shares)
    # a sound may be as far from its time as a share of the interval beside it
    reach = (_NEAR * np.minimum(steps, np.roll(steps, 1))).tolist()
    slots, apart = np.full(times.size, -1), np.full(times.size, np.nan)
    origin, length, places = _phase(times, cycle), cycle.length, shares.tolist()
    for i, time in enumerate(times.tolist()):
        turns = (time - origin) / length
        whole = math.floor(turns + reach[0])
        rest = turns - whole
        k = min(range(count + 1), key=lambda j: abs(rest - places[j]))
        off = rest - places[k]
        if abs(off) < reach[k % count]:
            slots[i], apart[i] = whole * count + k, off * length
            origin += _FOLLOW * off * length
    fits = slots >= 0
    slots[fits] -= slots[fits].min(initial=slots.max()) // count * count
    return slots, apart


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
    count = cycle.shares.size
    heard = taken.size / (np.ptp(slots[taken]) + 1.0) if taken.size else 0.0
    scatter = float(np.std(apart[taken])) * count / cycle.length if taken.size else math.inf
    few = taken.size < max(_FEWEST * count, _FITTING * slots.size)
    if few or heard < _FILLED or scatter > _SCATTER:
        raise InvalidValue(
            f"sounds must have a rhythm, got {slots.size} of which {taken.size} fit the one of "
            f"{cycle.length / count:.3g} s, where {100.0 * heard:.0f} % of the beats "
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
