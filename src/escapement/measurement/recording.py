"""Recordings of sound: WAV files of any usual kind."""

import warnings
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.base.errors import InputFileError
from escapement.base.files import AnyPath, check_input
from escapement.base.lazy import Lazy

wavfile = Lazy("scipy.io.wavfile")
_CONVERT = "convert it, for example with: ffmpeg -i {path} recording.wav"
_RATES = (8000, 192000)
_FULL = 3  # samples in a row at full scale show that a recording is clipped
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


_OTHERS = (".mp3", ".m4a", ".aac", ".ogg", ".opus", ".flac", ".mp4", ".3gp", ".aiff", ".aif")


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
    if not _RATES[0] <= rate <= _RATES[1]:
        raise InputFileError(
            f"recording {path} must have 8000 to 192000 samples a second, got {rate}; record it "
            "anew, or convert it"
        )
    channels = 1 if values.ndim == 1 else values.shape[1]
    if channels > 1:
        spread = [
            float(np.std(values[:: max(len(values) // 10**6, 1), k])) for k in range(channels)
        ]
        values = values[:, int(np.argmax(spread))]
    if values.size == 0 or not np.ptp(values):
        raise InputFileError(
            f"recording {path} must hold sound, and is silent; check the microphone, and record "
            "again"
        )
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        raise InputFileError(
            f"recording {path} must hold finite numbers, and does not; convert it again"
        )
    if (share := _clipped(values)) > _CLIPPED:
        raise InputFileError(
            f"recording {path} must not be clipped, got {100.0 * share:.2g} % of its samples at "
            "full scale; record it with less gain, or further away"
        )
    return Recording(values, float(rate), channels)


def _read(path: AnyPath) -> tuple[int, NDArray[Any]]:
    """Rate and samples of a WAV file, shape (n,) or (n, channels)."""
    with open(path, "rb") as file:
        head = file.read(12)
    if head[:4] not in (b"RIFF", b"RIFX", b"RF64") or head[8:] != b"WAVE":
        raise InputFileError(
            f"recording {path} must be a WAV file, and is not; {_CONVERT.format(path=path)}"
        )
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            rate, values = wavfile.read(path)
        except (ValueError, TypeError, EOFError, OSError) as error:
            raise InputFileError(
                f"recording {path} must be a WAV file of 8 to 32 bits, got: {error}; "
                f"{_CONVERT.format(path=path)}"
            ) from None
    if any("EOF" in str(one.message) for one in told):
        raise InputFileError(f"recording {path} must be whole, and is cut short; copy it again")
    return int(rate), values


def _clipped(values: NDArray[Any]) -> float:
    """Share of the samples that stand in rows of equal samples at one of the extremes."""
    share = 0
    for extreme in (values.max(), values.min()):
        at = np.flatnonzero(values == extreme)
        if at.size >= _FULL:
            ends = np.flatnonzero(np.diff(at, prepend=-2, append=at[-1] + 2) != 1)
            runs = np.diff(ends)
            share += int(runs[runs >= _FULL].sum())
    return share / values.size
