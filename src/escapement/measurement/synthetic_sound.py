"""Recordings of a ticking mechanism that are computed, for tests and to try the analysis.

A tick is the ringing of a few resonances of the frame, which begins at full amplitude with the
sample behind the strike. A room adds a tail of decaying noise, and the microphone adds noise.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.files import AnyPath, pending_file
from escapement.mechanisms.protocol import FloatArray

_LONGEST = 12.0  # decay times after which a tick has ended
_PEAK = 0.7  # greatest amplitude in a file, of full scale
_BITS = 16


class Resonances(NamedTuple):
    """Resonances of the frame, of which each tick is made.

    frequencies : their frequencies [Hz].
    decay : time in which their amplitude falls to 1/e [s].
    """

    frequencies: tuple[float, ...] = (2300.0, 4100.0, 7400.0)
    decay: float = 3e-3


def synthetic_recording(
    times: ArrayLike,
    loudness: ArrayLike = 1.0,
    *,
    rate: int = 48000,
    signal_to_noise: float = 30.0,
    room: float = 0.0,
    resonances: Resonances | None = None,
    duration: float | None = None,
    seed: int = 0,
) -> FloatArray:
    """A recording of ticks in noise.

    Parameters
    ----------
    times : array_like, shape (n,)
        Instants of the ticks [s], such as `motion.impacts.times`.
    loudness : float or array_like, shape (n,)
        Amplitude of each tick [-], such as the square root of the energy of its impact.
    rate : int
        Samples a second [Hz].
    signal_to_noise : float
        Ratio of the median amplitude of the ticks to the standard deviation of the noise [dB].
    room : float
        Amplitude with which the tail of the room begins, as a share of that of the tick [-]; it
        decays to 1/e within 30 ms.
    resonances : Resonances, optional
        Those of the frame that ring.
    duration : float, optional
        Length of the recording [s]. Default: it ends a quarter of a second after the last tick.
    seed : int
        Seed of the noise.

    Returns
    -------
    ndarray, shape (samples,)
        The recording; the median amplitude of its ticks is 1.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    at = np.atleast_1d(np.asarray(times, float))
    loud = np.broadcast_to(np.asarray(loudness, float), at.shape)
    if at.ndim != 1 or not at.size or not np.isfinite(at).all() or at.min() < 0.0:
        raise validate.fail(
            "times", "a row of instants, each 0 or greater", times, "give them in s"
        )
    frequency = validate.integer("rate", rate, 1000, "give the samples a second in Hz")
    parts, rng = resonances or Resonances(), np.random.default_rng(seed)
    length = math.ceil((duration or float(at.max()) + 0.25) * frequency)
    sound = np.zeros(length)
    reach = min(math.ceil(_LONGEST * max(parts.decay, 0.03 if room else 0.0) * frequency), length)
    for instant, size in zip(at.tolist(), (loud / np.median(loud)).tolist(), strict=True):
        first = math.ceil(instant * frequency)
        if first < length:
            after = (np.arange(first, min(first + reach, length)) - instant * frequency) / frequency
            sound[first : first + after.size] += size * _tick(after, parts, room, rng)
    noise = 10.0 ** (-0.05 * signal_to_noise) * rng.normal(size=length)
    return np.asarray(sound + noise)


def _tick(
    after: FloatArray, resonances: Resonances, room: float, rng: np.random.Generator
) -> FloatArray:
    """The sound of one strike at some times after it."""
    waves = np.cos(2.0 * np.pi * np.outer(resonances.frequencies, after)).mean(axis=0)
    tick = np.exp(-after / resonances.decay) * waves
    if room:
        tick += room * np.exp(-after / 0.03) * rng.normal(size=after.size)
    return np.asarray(tick)


def write_recording(
    path: AnyPath, recording: ArrayLike, rate: int = 48000, *, force: bool = False
) -> None:
    """Write a recording as a WAV file of 16 bits.

    Raises
    ------
    InvalidValue
        When the recording is not a row of finite numbers.
    CannotCreate, StorageError
        When the file exists already, or cannot be written.
    """
    from scipy.io import wavfile

    values = np.asarray(recording, float)
    if values.ndim != 1 or not values.size or not np.isfinite(values).all():
        raise validate.fail("recording", "a row of finite numbers", recording, "give samples")
    scale = _PEAK * (2 ** (_BITS - 1) - 1) / (np.abs(values).max() or 1.0)
    with pending_file(path, force) as handle:
        wavfile.write(handle, rate, np.rint(scale * values).astype(np.int16))
