"""Times of beats, from a recording of their sound or from a text file."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from escapement.base import validate
from escapement.base.columns import wrong_unit
from escapement.base.errors import InputFileError, InvalidValue
from escapement.base.files import AnyPath
from escapement.base.headings import TIMES, name_and_unit
from escapement.base.lines import BrokenLine
from escapement.base.text_table import Content, Layout, read_table
from escapement.measurement.loggers import check_increasing
from escapement.measurement.onsets import Onsets, find_onsets
from escapement.measurement.readings import Readings
from escapement.measurement.recording import is_recording, read_recording
from escapement.measurement.rhythm import Rhythm, find_rhythm
from escapement.mechanisms.protocol import FloatArray

HOUR = 3600.0
_INTERVALS = ("interval", "intervals", "beat", "beats", "duration", "durations", "period")
_INSTANTS = ("time", "times", "t", "timestamp", "onset", "onsets")
_CONTENT = Content("file of beats", "times", "a column of times, or of intervals", single=True)


def read_beats(
    path: AnyPath, *, nominal: float | None = None, time_unit: str | None = None,
    run_up: bool = False,
) -> Readings:  # fmt: skip
    """Read the times of beats from a recording, or from a text file.

    Parameters
    ----------
    path : path
        A WAV file of 8, 16, 24 or 32 bits or floating point, of one channel or more, with 8 to
        192 kHz. Or a text file with a column of instants, or of intervals, of beats.
    nominal : float, optional
        Beats an hour, > 0. It decides whether two sounds are one beat or two; without it they are
        one where they follow each other within .6 of the silence that comes then.
    time_unit : str, optional
        "s", "ms" or "us" of a text file. Default: as in its heading, else seconds.
    run_up : bool
        Whether the mechanism runs up, so that there is no rhythm yet: then each sound is a beat.

    Returns
    -------
    Readings
        Their `remark` says what must be known of these beats.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    MissingInput, InputFileError
        When the file cannot be read, or holds no beats: it is silent, clipped or cut short, or its
        sounds have no rhythm.

    Notes
    -----
    The clock of the recorder decides on the rate: that of a telephone may be wrong by some parts
    in 10^5, which are a few seconds a day.
    """
    expected = None
    if nominal is not None:
        expected = HOUR / validate.positive("nominal", nominal, "give the beats an hour")
    if is_recording(path):
        if time_unit is not None:
            raise validate.fail("time_unit", "left out for a recording", time_unit, "leave it out")
        recording = read_recording(path)
        found = find_onsets(recording.samples, recording.rate)
        duration = recording.duration
    else:
        times = read_times(path, time_unit)
        nan = np.full(times.size, np.nan)
        found = Onsets(times, 0.0 * times, nan, 0.0 * times, np.isfinite(times))
        duration = float(np.nanmax(times, initial=0.0))
    try:
        if not is_recording(path):
            check_increasing("time", found.times)
        rhythm = find_rhythm(found, expected, run_up)
    except InvalidValue as error:
        what = "recording" if is_recording(path) else "file"
        raise InputFileError(f"{what} {path} must hold beats: {error}") from None
    index = rhythm.beats

    def of(values: FloatArray) -> FloatArray:
        return np.where(index >= 0, values[index], np.nan)

    return Readings.of_beats(
        of(found.times), of(found.half_widths), loudness=of(found.loudness),
        doubles=found.times[rhythm.doubles], sounds=rhythm.sounds,
        remark="; ".join(_remarks(rhythm, of(found.times), duration)),
    )  # fmt: skip


def _remarks(rhythm: Rhythm, times: FloatArray, duration: float) -> Iterator[str]:
    """What a reader must know of beats."""
    heard = times[np.isfinite(times)]
    if missed := times.size - heard.size:
        yield f"{missed} of {times.size} beats were not heard"
    if rhythm.sounds > 1:
        yield (
            f"each beat has {rhythm.sounds} sounds, of which the one after the longest silence "
            "counts; if each of them is a beat, give the nominal rate"
        )
    if (extra := rhythm.doubles.size - (rhythm.sounds - 1) * heard.size) > 0:
        yield f"{extra} other sounds are left out"
    if max(heard[0], duration - heard[-1]) > 10.0 * np.ptp(heard) / times.size:
        yield f"beats are heard from {heard[0]:.3g} s to {heard[-1]:.3g} s of {duration:.3g} s"


def read_times(path: AnyPath, time_unit: str | None = None) -> FloatArray:
    """Instants of beats [s], in turn.

    Parameters
    ----------
    path : path
        Text as `read_table` reads it, with a column of instants, or of intervals. It is the one
        named time or interval, else the only one. Numbers that increase throughout are instants,
        unless the heading says otherwise.
    time_unit : str, optional
        A key of `headings.TIMES`. Default: as in the heading, else seconds.

    Raises
    ------
    MissingInput, InputFileError
        When there is no such file, or it holds no times.
    InvalidValue
        For an unknown unit.
    """
    if time_unit is not None:
        validate.choice("time_unit", time_unit, tuple(TIMES))
    table = read_table(path, _CONTENT, partial(_find_layout, time_unit=time_unit))
    intervals, instants = table.columns
    if instants is not None:
        found = np.asarray(instants[np.isfinite(instants)])
        if intervals is None or (np.diff(found) > 0.0).all():
            return found
    steps = np.asarray(intervals)
    wrong = np.flatnonzero(~(steps > 0.0))
    if wrong.size:
        raise InputFileError(
            f"{path}, line {table.line[wrong[0]]} must have an interval greater than 0, got "
            f"{steps[wrong[0]]:g} s; give times of the beats instead"
        )
    return np.concatenate([[0.0], np.cumsum(steps)])


def _find_layout(
    fields: list[str], names: list[str], header: bool, time_unit: str | None
) -> Layout:
    """The column of intervals and that of instants, which are one if no heading tells which."""
    named = [name_and_unit(name) for name in names] if header else [("", None)]
    usual = [i for i, (name, _) in enumerate(named) if name in (*_INSTANTS, *_INTERVALS, "")]
    if not usual and len(fields) > 1:
        raise BrokenLine("have one column called time or interval", "rename the column of times")
    index = usual[0] if usual else 0
    name, stated = named[index]
    unit = time_unit or stated or "s"
    if unit not in TIMES:
        raise wrong_unit(unit, timed=True)
    indices = (None if name in _INSTANTS else index, None if name in _INTERVALS else index)
    return Layout(indices, (unit, unit), (TIMES[unit], TIMES[unit]))
