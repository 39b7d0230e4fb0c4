"""Recordings of sound: WAV files of any usual kind, and recordings of ticks that are computed.

A tick is the ringing of a few resonances of the frame, which begins at full amplitude with the
sample behind the strike. A room adds a tail of decaying noise, and the microphone adds noise.
"""

import math
import warnings
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from escapement.base import validate
from escapement.base.errors import InputFileError
from escapement.base.files import AnyPath, check_input, pending_file
from escapement.base.lazy import Lazy
from escapement.mechanisms.protocol import FloatArray

wavfile = Lazy("scipy.io.wavfile")
_CONVERT = "convert it, for example with: ffmpeg -i {path} recording.wav"
_OTHERS = (".mp3", ".m4a", ".aac", ".ogg", ".opus", ".flac", ".mp4", ".3gp", ".aiff", ".aif")
_CLIPPED = 1e-4  # share of such samples from which on ticks have lost their beginning


class Recording(NamedTuple):
    """One channel of a recording.

    samples : shape (n,), of the type in the file.
    rate : samples a second [Hz].
    channels : number of channels in the file, of which the loudest is taken.
    """

    samples: NDArray[Any]
    rate: float
    channels: int

    @property
    def duration(self) -> float:
        """Length of the recording [s]."""
        return self.samples.size / self.rate


def is_recording(path: AnyPath) -> bool:
    """Whether the name of a file is that of a recording."""
    return str(path).lower().endswith((".wav", ".wave", *_OTHERS))


def read_recording(path: AnyPath) -> Recording:
    """Read a WAV file.

    Raises
    ------
    MissingInput
        If there is no such file.
    InputFileError
        If it is no WAV file, is cut short, silent or clipped, or has another rate than 8 to
        192 kHz.
    """
    check_input(path, "recording")
    rate, values = _read(path)
    channels = 1 if values.ndim == 1 else values.shape[1]
    if channels > 1:
        step = max(len(values) // 10**6, 1)
        spread = [float(np.std(values[::step, k])) for k in range(channels)]
        values = values[:, int(np.argmax(spread))]
    if not 8000 <= rate <= 192000:
        remedy = "record it anew, or convert it"
        raise _fail(path, f"have 8000 to 192000 samples a second, got {rate}", remedy)
    if values.size == 0 or not np.ptp(values):
        remedy = "check the microphone, and record again"
        raise _fail(path, "hold sound, and is silent", remedy)
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        raise _fail(path, "hold finite numbers, and does not", "convert it again")
    if (share := 100.0 * _clipped(values)) > 100.0 * _CLIPPED:
        rule = f"not be clipped, got {share:.2g} % of its samples at full scale"
        raise _fail(path, rule, "record it with less gain, or further away")
    return Recording(values, float(rate), channels)


def _fail(path: AnyPath, rule: str, remedy: str = _CONVERT) -> InputFileError:
    return InputFileError(f"recording {path} must {rule}; {remedy.format(path=path)}")


def _read(path: AnyPath) -> tuple[int, NDArray[Any]]:
    """Rate and samples of a WAV file, shape (n,) or (n, channels)."""
    with open(path, "rb") as file:
        head = file.read(12)
    if head[:4] not in (b"RIFF", b"RIFX", b"RF64") or head[8:] != b"WAVE":
        raise _fail(path, "be a WAV file, and is not")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            rate, values = wavfile.read(path)
        except (ValueError, TypeError, EOFError, OSError) as error:
            raise _fail(path, f"be a WAV file of 8 to 32 bits, got: {error}") from None
    if any("EOF" in str(one.message) for one in told):
        raise _fail(path, "be whole, and is cut short", "copy it again")
    return int(rate), values


def _clipped(values: NDArray[Any]) -> float:
    """Share of the samples that are the last of three in a row at an extreme."""
    full = (values == values.max()) | (values == values.min())
    return float(np.sum(full[2:] & full[1:-1] & full[:-2])) / values.size


_LONGEST = 12.0  # decay times after which a tick has ended
_PEAK = 0.7  # greatest amplitude in a file, of full scale
_BITS = 16


_RESONANCES = 2300.0, 4100.0, 7400.0  # of the frame, of which a tick is made [Hz]
_DECAY, _ECHO = 3e-3, 0.03  # time in which their amplitude, and that of the room, falls to 1/e [s]


def synthetic_recording(
    times: ArrayLike, loudness: ArrayLike = 1.0, *, rate: int = 48000,
    signal_to_noise: float = 30.0, room: float = 0.0, duration: float | None = None, seed: int = 0,
) -> FloatArray:  # fmt: skip
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
    rng = np.random.default_rng(seed)
    length = math.ceil((duration or float(at.max()) + 0.25) * frequency)
    sound = np.zeros(length)
    reach = min(math.ceil(_LONGEST * (_ECHO if room else _DECAY) * frequency), length)
    for instant, size in zip(at.tolist(), (loud / np.median(loud)).tolist(), strict=True):
        first = math.ceil(instant * frequency)
        if first < length:
            after = (np.arange(first, min(first + reach, length)) - instant * frequency) / frequency
            waves = np.cos(2.0 * np.pi * np.outer(_RESONANCES, after)).mean(axis=0)
            tick = np.exp(-after / _DECAY) * waves
            if room:
                tick += room * np.exp(-after / _ECHO) * rng.normal(size=after.size)
            sound[first : first + after.size] += size * tick
    noise = 10.0 ** (-0.05 * signal_to_noise) * rng.normal(size=length)
    return np.asarray(sound + noise)


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
    values = np.asarray(recording, float)
    if values.ndim != 1 or not values.size or not np.isfinite(values).all():
        raise validate.fail("recording", "a row of finite numbers", recording, "give samples")
    scale = _PEAK * (2 ** (_BITS - 1) - 1) / (np.abs(values).max() or 1.0)
    with pending_file(path, force) as handle:
        wavfile.write(handle, rate, np.rint(scale * values).astype(np.int16))
