"""Beats in time: the sound with its beats, the strip of a timegrapher, and the spectrum."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.base import validate
from escapement.measurement import MotionFit, Readings, Recording, Timekeeping
from escapement.plots import style

_SHOWN = 6  # beats of the sound that are drawn
_BINS = 4000  # points of the drawn sound


def plot_timing(
    beats: Readings, keeping: Timekeeping, recording: Recording | None = None
) -> Figure:
    """Three panels: the sound or the intervals, how late each beat is, and what repeats.

    Parameters
    ----------
    beats : Readings
        What `escapement.read_beats` returns.
    keeping : Timekeeping
        Their `escapement.timekeeping`.
    recording : Recording, optional
        The sound, of which the first beats are drawn. Default: intervals are drawn instead.

    Returns
    -------
    Figure
        Above: the sound and the instants of beats. In the middle: how late each beat is, as a
        timegrapher draws it, with the offsets of the positions. Below: amplitudes of what repeats,
        by its frequency.
    """
    if not isinstance(beats, Readings) or beats.half_widths is None:
        raise validate.fail("beats", "Readings of beats", beats, "give what read_beats returns")
    if not isinstance(keeping, Timekeeping):
        raise validate.fail("keeping", "a Timekeeping", keeping, "give what timekeeping returns")
    figure = style.new_figure(style.TWO_COLUMN, 7.0)
    above, strip, below = (style.dress(axes) for axes in figure.subplots(3, 1))
    if recording is None:
        _intervals(above, beats)
    else:
        _sound(above, beats, recording)
    _strip(strip, beats, keeping)
    _spectrum(below, beats, keeping)
    return figure


def plot_run_up(beats: Readings, fit: MotionFit, ax: Axes | None = None) -> Axes:
    """Intervals of beats of a motion from rest, measured and computed with the fitted numbers.

    Parameters
    ----------
    beats : Readings
        What `escapement.read_beats` returns.
    fit : MotionFit
        What `escapement.fit_motion` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure.

    Returns
    -------
    Axes
        Number of the beat behind the release, and the interval that ends with it.
    """
    if not isinstance(fit, MotionFit):
        raise validate.fail("fit", "a MotionFit", fit, "give what fit_motion returns")
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.0)
    heard, times = beats.beats, beats.heard
    one = np.diff(heard) == 1
    steps, computed = np.diff(times)[one], np.diff(times - fit.residuals)[one]
    factor, unit = style.scaled("s", steps)
    number = heard[1:][one] + 1
    ax.plot(number, factor * computed, color=style.BLUE, lw=1.2, label="fitted model")
    look: dict[str, Any] = {"color": style.VERMILLION, "ms": 4, "mfc": "white"}
    ax.plot(number, factor * steps, "o", label="measured", **look)
    return style.finished(ax, ("beat", ""), ("interval", unit), 2)


def _sound(ax: Axes, beats: Readings, recording: Recording) -> None:
    """The sound of the first beats, as the range of its amplitude, and their instants."""
    heard = beats.heard[: _SHOWN + 1]
    start, stop = max(heard[0] - 0.3 * beats.period, 0.0), heard[-1]
    low, high = int(start * recording.rate), int(stop * recording.rate) + 1
    piece = recording.samples[low:high].astype(float)
    size = max(piece.size // _BINS, 1)
    rows = piece[: piece.size // size * size].reshape(-1, size)
    at = (low + size * (np.arange(len(rows)) + 0.5)) / recording.rate
    top = float(np.abs(piece).max()) or 1.0
    ax.fill_between(at, rows.min(axis=1) / top, rows.max(axis=1) / top, color=style.BLUE, lw=0.4)
    for k, instant in enumerate(heard[:-1]):
        label = "beat" if k == 0 else None
        ax.axvline(instant, color=style.VERMILLION, lw=1.2, ls="--", label=label)
    style.finished(ax, ("time", "s"), ("sound", ""), 2)


def _intervals(ax: Axes, beats: Readings) -> None:
    """Intervals of beats that follow each other."""
    times = np.asarray(beats.time)
    steps = np.diff(times)
    factor, unit = style.scaled("s", steps[np.isfinite(steps)])
    ax.plot(times[1:], factor * steps, ".", ms=3, color=style.BLUE, label="interval")
    style.finished(ax, ("time", "s"), ("interval", unit), 2)


def _strip(ax: Axes, beats: Readings, keeping: Timekeeping) -> None:
    """How late each beat is against the mean rate, by its position in the pattern."""
    heard, size = beats.beats, len(keeping.offsets)
    late = keeping.residuals + np.array([one.value for one in keeping.offsets])[heard % size]
    factor, unit = style.scaled("s", late)
    for k, look in zip(range(size), style.LOOKS, strict=False):
        some = heard % size == k
        marks: dict[str, Any] = {"color": look.color, "ms": 3, "ls": ""}
        label = f"position {k}" if size > 1 else "beat"
        ax.plot(beats.heard[some], factor * late[some], look.marker, label=label, **marks)
    style.finished(ax, ("time", "s"), ("late by", unit), min(size, 6))


def _spectrum(ax: Axes, beats: Readings, keeping: Timekeeping) -> None:
    """Amplitude of sinusoidal lateness, by frequency up to half the beats a second."""
    heard, size = beats.beats, len(keeping.offsets)
    late = np.zeros(len(beats.input))
    late[heard] = keeping.residuals + np.array([one.value for one in keeping.offsets])[heard % size]
    amplitude = 2.0 / heard.size * np.abs(np.fft.rfft(late))[1:]
    if late.size % 2 == 0:
        amplitude[-1] *= 0.5  # beats that alternate have no phase
    frequency = np.fft.rfftfreq(late.size, beats.period)[1:]
    factor, unit = style.scaled("s", amplitude)
    ax.plot(frequency, factor * amplitude, color=style.BLUE, lw=1.0)
    ax.set_ylim(0.0, None)
    style.finished(ax, ("frequency", "Hz"), ("amplitude", unit), 2, legend=False)
