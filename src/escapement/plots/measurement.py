"""Plots of measured positions against theory: errors, their distribution and periodogram."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.base import validate
from escapement.measurement import Measurement, MotionFit, position
from escapement.measurement.encoder import sensor_uncertainty
from escapement.measurement.positions import spread_samples
from escapement.plots import style
from escapement.plots.style import Named

_MOST_POINTS = 4000  # more points cannot be distinguished in print
_CURVE = 400
_FALSE_ALARM = 0.01


def plot_positions(result: Measurement, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Measured and theoretical position of the output over the input.

    Parameters
    ----------
    result : Measurement
        What `escapement.measure` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Driver angle from dead centre and follower angle [degrees]; both grow
        over the turns, whatever the sense of the output's encoder.

    Source: Prikhodko (2020), figure 6.
    """
    ax = _ready(result, ax)
    driver = result.input + result.fit.phase
    angles = np.linspace(driver.min(), driver.max(), _CURVE)
    phi = np.degrees(position(result.mechanism, angles))
    ax.plot(np.degrees(angles), phi, color=style.BLUE, lw=1.0, label="theory", zorder=3)
    some = spread_samples(driver.size, _MOST_POINTS)
    found = position(result.mechanism, driver[some]) + result.fit.sense * result.errors[some]
    look: dict[str, Any] = {"mfc": "none", "mew": 0.7, "color": style.VERMILLION}
    ax.plot(np.degrees(driver[some]), np.degrees(found), "o", ms=2.5, label="measured", **look)
    return _finished(
        ax, result, legend, ("driver angle from dead centre", "°"), ("follower angle", "°")
    )


def plot_errors(result: Measurement, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Errors over the input angle.

    Parameters
    ----------
    result : Measurement
        What `escapement.measure` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Input angle from the first sample and error [degrees]. Broken lines: the
        interval of the errors. Shaded, where the encoders are known: twice the
        standard uncertainty that the encoders alone cause.

    Source: Prikhodko (2020), figure 7.
    """
    ax = _ready(result, ax)
    some = spread_samples(result.errors.size, _MOST_POINTS)
    some = some[np.argsort(result.input[some])]
    angle = np.degrees(result.input[some] - result.input[0])
    if result.encoder is not None:
        width = 2.0 * np.degrees(sensor_uncertainty(result.encoder, result.fit.slope[some]))
        ax.fill_between(angle, -width, width, label="encoders", **style.SHADE)
    ax.axhline(0.0, **style.ZERO)
    ax.plot(angle, np.degrees(result.errors[some]), ".", ms=2.5, color=style.BLUE, label="errors")
    name = f"{100.0 * result.confidence:g} % interval"
    # the legend names the first of the two limits alone
    for limit, text in zip(np.degrees(result.interval), (name, "_"), strict=True):
        ax.axhline(limit, lw=1.0, **style.BROKEN, label=text)
    ax.margins(x=0.01)
    return _finished(ax, result, legend, ("input angle", "°"), ("error", "°"), columns=3)


def plot_error_histogram(
    result: Measurement, ax: Axes | None = None, *, legend: bool = True
) -> Axes:
    """Density of the errors in classes, and of a normal distribution.

    Parameters
    ----------
    result : Measurement
        What `escapement.measure` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Error [degrees] and share of the errors per degree.

    Source: Prikhodko (2020), figure 8.
    """
    ax = _ready(result, ax)
    classes = result.histogram
    edges = np.degrees(classes.edges)
    density = classes.observed / (classes.observed.sum() * np.diff(edges))
    look: dict[str, Any] = {"fc": style.SKY, "ec": style.BLACK, "lw": 0.7, "alpha": 0.6}
    ax.stairs(density, edges, fill=True, label="errors", **look)
    mean, deviation = np.degrees([result.mean, result.standard_deviation])
    reach = max(3.5 * deviation, float(np.abs(edges - mean).max()))
    x = np.linspace(-reach, reach, _CURVE) / deviation
    bell = np.exp(-0.5 * x**2) / (deviation * np.sqrt(2.0 * np.pi))
    ax.plot(mean + deviation * x, bell, color=style.VERMILLION, lw=1.4, label="normal law")
    ax.set_ylim(0.0, None)
    return _finished(ax, result, legend, ("error", "°"), ("density", "1/°"))


def plot_frequencies(result: Measurement, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Number of errors in each class, and the number expected of a normal distribution.

    Parameters
    ----------
    result : Measurement
        What `escapement.measure` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Middle of the class [degrees] and number of errors.

    Source: Prikhodko (2020), figure 9.
    """
    ax = _ready(result, ax)
    classes = result.histogram
    middle = np.degrees(0.5 * (classes.edges[1:] + classes.edges[:-1]))
    width = 0.4 * (middle[1] - middle[0])
    sky: dict[str, Any] = {"fc": style.SKY, "ec": style.BLACK, "lw": 0.6}
    ax.bar(middle - 0.5 * width, classes.observed, width, label="empirical", **sky)
    hatched: dict[str, Any] = {"fc": "white", "ec": style.VERMILLION, "lw": 0.9, "hatch": "////"}
    ax.bar(middle + 0.5 * width, classes.expected, width, label="theoretical", **hatched)
    return _finished(ax, result, legend, ("middle of the class", "°"), ("number of errors", ""))


def plot_periodogram(result: Measurement, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Amplitude of errors that repeat, over their frequency.

    Parameters
    ----------
    result : Measurement
        What `escapement.measure` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Cycles per turn of the input and share of the variance explained [%], from the
        lowest frequency on at which the samples tell a sinusoid from its mean. Broken
        line: one set of independent errors in a hundred has a higher peak anywhere.
        Dotted: once a turn of the input, of the output, and once a cell.
    """
    ax = _ready(result, ax)
    found = result.periodogram
    ax.plot(found.frequency, 100.0 * found.power, color=style.BLUE, lw=0.9)
    level = 100.0 * found.level(_FALSE_ALARM)
    ax.axhline(level, lw=1.0, **style.BROKEN, label=f"{100.0 * _FALSE_ALARM:g} % false alarm")
    cells = 2.0 * np.pi / result.mechanism.cell_angle
    rounds = abs(result.mechanism.follower_step) / result.mechanism.cell_angle
    marks = {"input turn": 1.0, "output turn": rounds, "cell": cells}
    looks = style.LOOKS[5], style.LOOKS[2], style.LOOKS[3]
    for look, (name, frequency) in zip(looks, marks.items(), strict=True):
        if frequency <= found.frequency[-1]:
            ax.axvline(frequency, color=look.color, lw=0.9, ls=look.linestyle, label=name, zorder=0)
    ax.set(xlim=(0.0, found.frequency[-1]), ylim=(0.0, None))
    return _finished(
        ax, result, legend, ("cycles per turn of the input", ""), ("share of variance", "%")
    )


def plot_speeds(fit: MotionFit, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Measured driver speeds and those of the fitted motion over time.

    Parameters
    ----------
    fit : MotionFit
        What `escapement.fit_motion` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Time from the release [s] and mean speed between neighbouring samples [rad/s].
    """
    if not isinstance(fit, MotionFit):
        raise validate.fail("fit", "a MotionFit", fit, "give what fit_motion returns")
    ax = ax or style.new_axes(5.0, 3.4)
    since = fit.mid_time - fit.release.value
    factor, unit = style.scaled("s", since)
    some = np.sort(spread_samples(since.size, _MOST_POINTS))
    look: dict[str, Any] = {"mfc": "none", "mew": 0.7, "color": style.VERMILLION}
    ax.plot(factor * since[some], fit.speeds[some], "o", ms=2.5, label="measured", **look)
    curve: dict[str, Any] = {"color": style.BLUE, "lw": 1.0, "label": "model"}
    ax.plot(factor * since[some], fit.computed_speeds[some], **curve)
    return style.finished(ax, ("time", unit), ("driver speed", "rad/s"), 2, legend=legend)


def plot_measurement(result: Measurement) -> Figure:
    """Positions, errors, their distribution and periodogram, on one sheet."""
    figure = style.new_figure(style.TWO_COLUMN, 5.6)
    draw = (plot_positions, plot_errors, plot_error_histogram, plot_periodogram)
    for ax, plot in zip(figure.subplots(2, 2).flat, draw, strict=True):
        # the heading says what is synthetic, once for all panels
        plot(result, style.dress(ax)).get_legend().set_title(None)  # type: ignore
    if result.readings.synthetic:
        figure.suptitle("Synthetic data", fontsize=style.LABEL_SIZE)
    return figure


def _ready(result: Measurement, ax: Axes | None) -> Axes:
    if not isinstance(result, Measurement):
        raise validate.fail("result", "a Measurement", result, "give what measure returns")
    return ax or style.new_axes(5.0, 3.4)


def _finished(
    ax: Axes, result: Measurement, legend: bool, x: Named, y: Named, columns: int = 2
) -> Axes:
    """The same axes with the names of both, and a legend that says what is synthetic."""
    title = "synthetic data" if result.readings.synthetic else None
    return style.finished(ax, x, y, columns, title, legend=legend)
