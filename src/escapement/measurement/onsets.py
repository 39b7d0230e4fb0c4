"""Instants at which the ticks of a recording begin, each with its interval.

The recording is cut into short frames. In each frequency the median power of all frames tells the
noise, which ticks hardly change. The band in which frames stand out most from this noise gives the
first ticks. From these, frequencies are weighted by S/(1 + S), where S is the power of a tick over
that of the noise, and frames whose weighted power stands out from those before them are candidates.

The beginning of a tick is then searched sample by sample. A causal filter with the same weights,
which also makes the noise white, moves no sound before its beginning. Behind the beginning the
variance rises as that of a decaying burst of noise through this filter, and then as the mean tick
that follows. The likelihoods of all instants give the likeliest one and its interval.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.base.lazy import Lazy
from escapement.mechanisms.protocol import FloatArray

fft = Lazy("scipy.fft")
ndimage = Lazy("scipy.ndimage")
signal = Lazy("scipy.signal")
special = Lazy("scipy.special")
_FRAME = 1.4e-3  # length of a frame, half of which lies beyond the one before it [s]
_GUARD = 2  # frames before a candidate that the tick may reach already
_BEFORE = 8  # frames before those that tell the noise there
_NEAR = 3  # the nearest of these frames, which tell it where the noise decays
_QUIET = 0.1, 0.03  # shares of frames that hold noise alone, in a frequency and in all together
_APART = 2  # frames between two ticks, at least
_WINDOWS = (1, 2, 4)  # lengths in frames that are tried
_WEAK = 0.02  # probability with which noise makes a candidate, which only a rhythm may confirm
_SHARED = np.array([1.0, 16.0, 36.0, 16.0, 1.0]) / 36.0
"""Correlation of the powers of noise in frequencies beside each other, with a Hann window."""
_FALSE = 0.02  # sure candidates that noise alone is allowed to make in a recording
_SHARE = 5e-4  # or so many for each sure candidate, where that is more
_BLOCK = 1 << 15  # frames that are transformed at a time
_SAMPLED = 1 << 14  # frames that tell the noise
_RARE = 1e-6  # probability of the power beyond which a frame counts as a burst
_SILENCE = 3  # frames before a tick that tell the noise there, sample by sample
_TAPS = 256  # coefficients of the filter
_GIVEN = 8.0  # ticks for which the burst counts in the mean tick
_LEVEL = 0.95  # confidence level of the intervals
_DECAYS = 0.2e-3 * 1.5 ** np.arange(9)  # times in which a tick may decay [s]
_TICKS = 2048  # ticks that are refined at a time
_FLOOR = 1e-10  # of the greatest power of the noise; below it a spectrum is rounding


class Onsets(NamedTuple):
    """Beginnings of the ticks of a recording, in turn; arrays of shape (n,).

    times : [s].
    half_widths : half the widths of their 95 % intervals [s].
    loudness : root mean square of the tick, in standard deviations of the noise before it [-].
    often : how often noise alone makes such a tick [1/s].
    sure : whether it hardly does so in the whole recording.
    """

    times: FloatArray
    half_widths: FloatArray
    loudness: FloatArray
    often: FloatArray
    sure: NDArray[np.bool_]


class _Spectrum(NamedTuple):
    """What is known by frequency; arrays of shape (size // 2 + 1,).

    size : samples of a frame.
    noise : power of the noise in a frame.
    weights : S/(1 + S).
    """

    size: int
    noise: FloatArray
    weights: FloatArray


def find_onsets(samples: NDArray[Any], rate: float) -> Onsets:
    """The beginnings of all ticks.

    Parameters
    ----------
    samples : ndarray, shape (n,)
        The recording, of any real type.
    rate : float
        Samples a second [Hz].
    """
    empty = np.empty(0)
    none = Onsets(empty, empty, empty, empty, np.empty(0, bool))
    size = 2 * int(fft.next_fast_len(max(round(0.5 * _FRAME * rate), 4), real=True))
    if samples.size < 4 * _BEFORE * size or not np.ptp(samples):
        return none
    spectrum = _band(samples, size)
    for _ in range(2):
        found = _candidates(samples, spectrum)
        if not found.sure.any():
            return none
        spectrum = _weighted(samples, spectrum, found.frames[found.sure])
    return _refined(samples, spectrum, rate, _candidates(samples, spectrum))


def _powers(samples: NDArray[Any], size: int, frames: NDArray[np.int64]) -> FloatArray:
    """Power of some frames in each frequency, shape (frames, size // 2 + 1)."""
    every = np.lib.stride_tricks.sliding_window_view(samples, size)
    pieces = every[frames * (size // 2)].astype(np.float32)
    pieces *= signal.get_window("hann", size).astype(np.float32)
    found = np.fft.rfft(pieces)
    return np.asarray(found.real**2 + found.imag**2)


def _count(samples: NDArray[Any], size: int) -> int:
    """Number of frames of a recording."""
    return samples.size // (size // 2) - 1


def _band(samples: NDArray[Any], size: int) -> _Spectrum:
    """The noise, and the band in which bursts stand out most; all frequencies if none does."""
    count = _count(samples, size)
    some = np.unique(np.linspace(0, count - 1, min(count, _SAMPLED)).astype(np.int64))
    powers = _powers(samples, size, some)
    # noise has exponentially distributed powers; ticks hardly change the least of them
    noise = np.quantile(powers, _QUIET[0], axis=0) / -math.log1p(-_QUIET[0])
    noise = np.maximum(noise, _FLOOR * max(float(noise.max()), float(powers.mean())))
    last, bands = noise.size - 1, []
    for width in (2 ** np.arange(1, int(math.log2(last)) + 1)).tolist():
        bands += [(start, start + width) for start in range(1, last - width + 1, width // 2)]
    low, high = np.array(bands).T
    alike = _SHARED.sum()
    shape, score = (high - low) / alike, np.zeros(low.size)
    level = alike * special.gammainccinv(shape, _RARE)
    for part in _in_parts(count):
        total = np.cumsum(_powers(samples, size, part) / noise, axis=1)
        power = total[:, high - 1] - total[:, low - 1]
        score += (np.maximum(power - level, 0.0) / np.sqrt(shape)).sum(axis=0)
    best, grid = int(score.argmax()), np.arange(noise.size)
    ends = (low[best], high[best]) if score[best] > 0.0 else (1, last)
    weights = np.where((grid >= ends[0]) & (grid < ends[1]), 1.0, 0.0)
    return _Spectrum(size, noise, weights)


def _in_parts(count: int) -> Iterator[NDArray[np.int64]]:
    for start in range(0, count, _BLOCK):
        yield np.arange(start, min(start + _BLOCK, count))


class _Candidates(NamedTuple):
    """Frames in which ticks begin, or that follow such a frame.

    chances : probability that noise makes so much of a frame.
    sure : whether it hardly does so in any frame.
    """

    frames: NDArray[np.int64]
    chances: FloatArray
    sure: NDArray[np.bool_]


def _candidates(samples: NDArray[Any], spectrum: _Spectrum) -> _Candidates:
    """The candidates of the window that finds most sure ones."""
    weights = spectrum.weights / spectrum.noise
    count = _count(samples, spectrum.size)
    power = np.concatenate(
        [_powers(samples, spectrum.size, part) @ weights for part in _in_parts(count)]
    )
    found = [_peaks(power, spectrum, window) for window in _WINDOWS]
    return max(found, key=lambda one: int(one.sure.sum()))


def _peaks(power: FloatArray, spectrum: _Spectrum, window: int) -> _Candidates:
    """Frames at which the mean power of a window rises above that before it."""
    mean = np.convolve(power, np.full(window, 1.0 / window))[window - 1 :]
    shape, noise = _noise_of(mean, spectrum.weights, window)
    before = np.minimum(
        _earlier(ndimage.median_filter(power, _BEFORE, mode="nearest"), _GUARD + _BEFORE // 2 - 1),
        _earlier(ndimage.uniform_filter1d(power, _NEAR, mode="nearest"), _GUARD + _NEAR // 2),
    )
    ratio = np.log(mean / np.maximum(before, noise))
    weak = math.log(float(special.gammainccinv(shape, _WEAK)) / shape)
    # the tail of a tick varies as noise does, so that a tick must rise above what was before it
    at, _ = signal.find_peaks(ratio, height=weak, prominence=weak, distance=_APART)
    chances = special.gammaincc(shape, shape * np.exp(ratio[at]))
    number = int(np.count_nonzero(chances < _FALSE / power.size))
    return _Candidates(at, chances, chances < max(_FALSE, _SHARE * number) / power.size)


def _noise_of(power: FloatArray, weights: FloatArray, window: int) -> tuple[float, float]:
    """Shape and mean of the gamma distribution that the mean power of a window of noise has.

    The mean follows from the least powers, because dense ticks leave little time without any.
    """
    alike = np.convolve(weights, _SHARED, "same") @ weights
    shape = window * float(weights.sum() ** 2 / alike)
    low = float(special.gammaincinv(shape, _QUIET[1])) / shape
    return shape, float(np.quantile(power, _QUIET[1])) / low


def _earlier(values: FloatArray, shift: int) -> FloatArray:
    """The values of so many frames before; the first one is repeated."""
    return np.concatenate([np.full(shift, values[0]), values[:-shift]])


def _weighted(samples: NDArray[Any], spectrum: _Spectrum, frames: NDArray[np.int64]) -> _Spectrum:
    """The spectrum with the weights that follow from some ticks."""
    some = frames[:: -(-frames.size // _SAMPLED)]
    ratio = np.median(_powers(samples, spectrum.size, some) / spectrum.noise, axis=0)
    above = np.maximum(ratio / math.log(2.0) - 1.0, 0.0)
    above[[0, -1]] = 0.0
    weights = above / (1.0 + above)
    return spectrum._replace(weights=weights if weights.any() else spectrum.weights)


def _filter(spectrum: _Spectrum) -> FloatArray:
    """Causal filter that makes noise white and weights frequencies, shape (_TAPS,)."""
    grid = np.linspace(0.0, spectrum.size // 2, 4 * _TAPS + 1)
    gain = np.maximum(spectrum.weights, 1e-4) / spectrum.noise
    response = np.interp(grid, np.arange(gain.size), np.log(gain))
    # the cepstrum of a filter of minimum phase is that of its magnitude, folded
    cepstrum = np.fft.irfft(0.5 * response)
    half = cepstrum.size // 2
    cepstrum[1:half] *= 2.0
    cepstrum[half + 1 :] = 0.0
    found = np.fft.irfft(np.exp(np.fft.rfft(cepstrum)))[:_TAPS]
    return np.asarray(found / np.sqrt(found @ found))


def _refined(samples: NDArray[Any], spectrum: _Spectrum, rate: float, found: _Candidates) -> Onsets:
    """The beginnings near candidates, by the likelihood of each instant."""
    taps, first = _filter(spectrum), found.frames * (spectrum.size // 2)
    # so many neighbouring squares tell as much as one that is independent
    alike = float((np.correlate(taps, taps, "full") ** 2).sum())
    profile, rows = np.empty(0), []
    for k in range(0, first.size, _TICKS):
        squares = _squares(samples, taps, first[k : k + _TICKS], spectrum.size)
        if not profile.size:
            sure = found.sure[:_TICKS]
            profile = _best_profile(squares[sure] if sure.any() else squares, taps, rate)
        rows.append(_likeliest(squares, profile, alike))
    shift, half, loud = (np.concatenate(column) for column in zip(*rows, strict=True))
    # a strike falls on average half a sample before the first sample that shows it
    times = (first + shift - 0.5) / rate
    order = np.argsort(times, kind="stable")
    often = found.chances * rate / (spectrum.size // 2)
    return Onsets(times[order], (half / rate)[order], loud[order], often[order], found.sure[order])


def _squares(
    samples: NDArray[Any], taps: FloatArray, first: NDArray[np.int64], size: int
) -> FloatArray:
    """Squares of filtered samples near candidates, in units of the noise before each.

    Shape (n, 4 size): a tick may begin in the first half, at most `size` from the candidate.
    """
    rows, before = [], _SILENCE * size
    start = before + 2 * size + taps.size
    for at in first.tolist():
        low, high = at - start, at + 3 * size
        piece = samples[max(low, 0) : min(high, samples.size)].astype(float)
        edges = max(-low, 0), max(high - samples.size, 0)
        rows.append(np.pad(piece, edges, mode="reflect" if piece.size > max(edges) else "edge"))
    found = signal.oaconvolve(np.array(rows), taps[None, :], axes=1)
    squares = found[:, taps.size : start + 3 * size] ** 2
    noise = squares[:, :before].mean(axis=1, keepdims=True)
    return np.asarray(squares[:, before + size :] / np.maximum(noise, 1e-300))


def _best_profile(squares: FloatArray, taps: FloatArray, rate: float) -> FloatArray:
    """Rise of the variance over the mean tick, with the mean 1.

    Ticks are laid on each other where bursts with the likeliest time of decay begin.
    """
    found, length = [], squares.shape[1] // 2
    for decay in _DECAYS.tolist():
        burst = np.exp(-np.arange(length) / (decay * rate))
        profile = np.convolve(taps**2, burst)[:length]
        found.append(profile / profile.mean())
    best = max(found, key=lambda one: float(np.median(_likelihoods(squares, one)[0].max(axis=1))))
    each, rise = _likelihoods(squares, best)
    at = each.argmax(axis=1)[:, None] + np.arange(length)
    ticks = np.take_along_axis(squares, at, axis=1) - 1.0
    mean = np.maximum(_GIVEN * np.median(rise) * best + ticks.sum(axis=0), 0.0)
    return np.asarray(mean / mean.mean())


def _likelihoods(squares: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Logarithms of the likelihoods of all beginnings, and the mean rise of each tick."""
    length, sums = profile.size, np.cumsum(squares, axis=1)
    power = (sums[:, length:] - sums[:, :-length]).max(axis=1) / length
    rise = np.maximum(power - 1.0, 0.02)
    ratio = 1.0 + rise[:, None] * profile
    kept, constant = 1.0 - 1.0 / ratio, np.log(ratio).sum(axis=1)
    each = [
        np.einsum("ij,ij->i", squares[:, k : k + length], kept) - constant
        for k in range(length + 1)
    ]
    return 0.5 * np.stack(each, axis=1), rise


def _likeliest(
    squares: FloatArray, profile: FloatArray, alike: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Shift of the likeliest beginning, half the width of its interval, and the loudness."""
    each, rise = _likelihoods(squares, profile)
    best, grid = each.argmax(axis=1), np.arange(profile.size + 1)
    chances = np.exp((each - each.max(axis=1, keepdims=True)) / alike)
    chances /= chances.sum(axis=1, keepdims=True)
    half = []
    for chance, middle in zip(chances, best.tolist(), strict=True):
        within = np.bincount(np.abs(grid - middle), chance, grid.size).cumsum()
        # each sample stands for all instants within half of one
        half.append(np.interp(_LEVEL, [0.0, *within], [0.0, *(grid + 0.5)]))
    return best - profile.size // 2, np.array(half), np.sqrt(rise)
