"""Measured beats beside those of fitted parts, and the lines of their spectrum."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from escapement.base import validate
from escapement.measurement import BeatFit, BeatSpectrum
from escapement.plots import style

_CULPRITS = ("pins", "slots", "pins or slots", "pairs")


def plot_beats(fit: BeatFit, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Beats of a pattern about their mean, measured and computed with the fitted errors.

    Parameters
    ----------
    fit : BeatFit
        What `escapement.fit_beats` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Engagement, by its pin and slot, and beat minus the mean beat. Bars: two standard
        deviations of what is drawn, to either side; time stamps, whose jitter makes neighbouring
        beats alternate, count with that covariance.
    """
    if not isinstance(fit, BeatFit):
        raise validate.fail("fit", "a BeatFit", fit, "give what fit_beats returns")
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.0)
    rounds, wheel = fit.rounds, fit.escapement.mechanism
    mean, k = rounds.means.mean(), np.arange(rounds.pattern)
    factor, unit = style.scaled("s", rounds.means - mean)
    ax.axhline(0.0, **style.ZERO)
    line: dict[str, Any] = {"color": style.BLUE, "lw": 1.2, "label": "fitted parts"}
    ax.step(k, factor * (fit.computed - mean), where="mid", **line)
    doubt = 2.0 * factor * fit.noise * rounds.spread
    look: dict[str, Any] = {"fmt": "o", "ms": 4, "mfc": "white", "color": style.VERMILLION}
    ax.errorbar(k, factor * (rounds.means - mean), doubt, label="measured", capsize=2, **look)
    pins, slots = wheel.pins, wheel.slots
    ax.set_xticks(k, [f"{j % pins}\n{j % slots}" for j in k])
    return style.finished(ax, ("pin, and slot below it", ""), ("beat minus mean", unit), 2,
                          legend=legend)  # fmt: skip


def plot_beat_spectrum(
    spectrum: BeatSpectrum, ax: Axes | None = None, *, legend: bool = True
) -> Axes:
    """Spectral lines of beats with the parts that cause them.

    Parameters
    ----------
    spectrum : BeatSpectrum
        What `escapement.beat_spectrum` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Cycles per turn of the driver, and amplitude. Broken line: noise alone exceeds it in one
        of a hundred lines.
    """
    if not isinstance(spectrum, BeatSpectrum):
        raise validate.fail("spectrum", "a BeatSpectrum", spectrum, "see beat_spectrum")
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.0)
    factor, unit = style.scaled("s", [line.amplitude for line in spectrum.lines])
    for name, look in zip(_CULPRITS, style.LOOKS, strict=False):
        lines = [line for line in spectrum.lines if line.culprit == name]
        if lines:
            frequencies, sizes = zip(
                *((x.frequency, factor * x.amplitude) for x in lines), strict=True
            )
            ax.vlines(frequencies, 0.0, sizes, color=look.color, lw=1.4)
            ax.plot(frequencies, sizes, look.marker, color=look.color, ms=5, label=name)
    errors = [line.standard_error for line in spectrum.lines]
    if np.isfinite(errors).all():
        # two components of noise together exceed this length once in a hundred times
        level = factor * float(np.median(errors)) * np.sqrt(-2.0 * np.log(0.01))
        ax.axhline(level, lw=1.0, ls="--", color=style.GREY, label="1 % of noise")
    ax.set_ylim(0.0, None)
    return style.finished(
        ax, ("cycles per turn of the driver", ""), ("amplitude", unit), 5, legend=legend
    )
