"""Figures of a motion: velocities, phase portrait, contact moment, or all on one sheet."""

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from escapement.errors import InvalidValue
from escapement.model import FloatArray
from escapement.motion import Motion
from escapement.plots import style
from escapement.plots.style import label, scaled

_CROWDED = 30  # lines of full height at more handoffs would grey the figure
_REPEATS = 0.01  # a cycle is terminal when its two handoff speeds agree within this share


def plot_velocities(motion: Motion, ax: Axes | None = None) -> Axes:
    """Driver and follower velocity against time.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure across two columns.

    Returns
    -------
    Axes
        Time [s, or ms where that is short] and velocity [rad/s].

    Source: the figure is Meyer (1973), figure 8.
    """
    times = _times(motion)
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.0)
    factor, unit = scaled("s", times)
    state = motion.at(times)
    ax.plot(times * factor, state.theta_dot, color=style.BLUE, lw=1.3, label="driver")
    dashes = style.LOOKS[1].linestyle
    ax.plot(times * factor, state.phi_dot, color=style.VERMILLION, lw=1.1, ls=dashes,
            label="follower")  # fmt: skip
    _mark_reversals(ax, motion.reversals.time * factor, motion.reversals.theta_dot)
    _mark_handoffs(ax, motion, factor)
    ax.set(xlabel=label("time", unit), ylabel=label("angular velocity", "rad/s"))
    ax.set_xlim(times[0] * factor, times[-1] * factor)
    ax.set_ylim(bottom=min(0.0, float(state.phi_dot.min())))
    style.legend_above(ax, 4)
    return ax


def plot_phase_portrait(motion: Motion, ax: Axes | None = None) -> Axes:
    """Driver velocity against driver angle from dead centre, engagement over engagement.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure in one column.

    Returns
    -------
    Axes
        Angle [degrees] and velocity [rad/s]. The last whole engagement is
        bold, and called the terminal cycle when its two handoff speeds agree
        within 1 %; a dwell is shaded.
    """
    times = _times(motion)
    ax = ax or style.new_axes(style.ONE_COLUMN, 3.0)
    mechanism = motion.escapement.mechanism
    entry, exit_, cell = mechanism.breaks[0], mechanism.breaks[-1], mechanism.cell_angle
    ends = motion.handoff_times[motion.handoff_times > times[0]]
    last = ends.size - 1
    if entry + cell - exit_ > 1e-9:
        dwell = np.degrees([exit_, entry + cell])
        ax.axvspan(*dwell, color=style.LIGHT_GREY, alpha=0.35, lw=0, label="dwell")
    ax.axvline(0.0, color=style.LIGHT_GREY, lw=0.6, ls=":", zorder=0)
    places = np.searchsorted(times, np.unique([times[0], *ends, times[-1]]))
    for index, (start, end) in enumerate(pairwise(places)):
        state = motion.at(times[start : end + 1])
        angle = np.degrees(state.theta - index * cell)
        if index == last:
            name = "terminal cycle" if _repeats(motion) else "last whole engagement"
            ax.plot(angle, state.theta_dot, color=style.BLUE, lw=1.8, zorder=3, label=name)
        else:
            name = "_" if index > 0 else "transient" if last > 0 else "unfinished"
            ax.plot(angle, state.theta_dot, color=style.GREY, lw=0.6, alpha=0.7, label=name)
    found = motion.reversals
    local = np.degrees(found.theta - cell * np.floor((found.theta - entry) / cell))
    _mark_reversals(ax, local, found.theta_dot)
    ax.set_xlim(*np.degrees([entry, entry + cell]))
    ax.set_ylim(bottom=0.0)
    ax.xaxis.set_major_locator(_degrees(np.degrees(cell)))
    ax.set(xlabel=label("driver angle from dead centre", "°"))
    ax.set(ylabel=label("driver velocity", "rad/s"))
    style.legend_above(ax, 2)
    return ax


def plot_contact_moment(motion: Motion, ax: Axes | None = None) -> Axes:
    """Moment of the pin on the follower against time; it jumps at handoffs.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure across two columns.

    Returns
    -------
    Axes
        Time [s] and moment [N m], with the prefixes that suit. Below zero,
        shaded, the follower drives the pin; in a dwell there is no contact.
    """
    times, moments = _moments(motion)
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.0)
    factor, unit = scaled("s", times)
    prefix, moment_unit = scaled("N m", moments)
    x, y = times * factor, moments * prefix
    ax.axhline(0.0, color=style.BLACK, lw=0.6)
    ax.plot(x, y, color=style.BLUE, lw=1.1, label="contact moment")
    driven = y < 0.0
    if driven.any():
        ax.fill_between(
            x, y, 0.0, where=driven, color=style.SKY, alpha=0.45, lw=0, label="follower drives"
        )
    _mark_reversals(ax, motion.reversals.time * factor, np.zeros(motion.reversals.time.size))
    _mark_handoffs(ax, motion, factor)
    ax.set(xlabel=label("time", unit), ylabel=label("moment on the follower", moment_unit))
    ax.set_xlim(0.0, motion.end_time * factor)
    style.legend_above(ax, 4)
    return ax


def _times(motion: Motion) -> FloatArray:
    """Times even in time and in angle, every event among them: no sharp peak is cut."""
    grid = motion.t
    if grid.size < 2:
        raise InvalidValue(
            f"motion must have a length to be plotted, got none ({motion.message}); "
            "change what prevents the motion"
        )
    theta = motion.theta
    even = np.interp(np.linspace(theta[0], theta[-1], 2 * grid.size), theta, grid)
    events = [motion.handoff_times, motion.extrema.time, motion.reversals.time]
    return np.unique(np.concatenate([grid, even, *events]))


def _moments(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Times and contact moments, one-sided at jumps; NaN between pieces of the solution."""
    times = _times(motion)
    bounds = np.append(motion.trajectory.start, motion.end_time)
    gap = np.array([np.nan])
    found_t, found_m = [gap], [gap]
    for piece, (start, end) in enumerate(pairwise(bounds)):
        if motion.trajectory.sign[piece] != 0.0:
            first, last = np.searchsorted(times, start, "right"), np.searchsorted(times, end)
            t = np.concatenate([[start], times[first:last], [end]])
            found_t += [t, gap]
            found_m += [motion.within(piece, t).contact_moment, gap]
    return np.concatenate(found_t), np.concatenate(found_m)


def _repeats(motion: Motion) -> bool:
    speeds = motion.handoff_velocities[-2:]
    return speeds.size == 2 and bool(abs(speeds[1] - speeds[0]) <= _REPEATS * abs(speeds[1]))


def _mark_handoffs(ax: Axes, motion: Motion, factor: float) -> None:
    times = motion.handoff_times * factor
    if times.size:
        # many handoffs get short lines at the top, where no curve hides them
        bottom, line = (0.0, ":") if times.size <= _CROWDED else (0.97, "-")
        ax.vlines(
            times, bottom, 1.0, transform=ax.get_xaxis_transform(), color=style.LIGHT_GREY,
            lw=0.7, ls=line, zorder=0, label="handoff",
        )  # fmt: skip


def _mark_reversals(ax: Axes, x: FloatArray, y: FloatArray) -> None:
    if x.size:
        marks: dict[str, Any] = {"mfc": "white", "mec": style.BLACK, "mew": 0.8, "zorder": 4}
        ax.plot(x, y, "o", ms=4.0 if x.size <= _CROWDED else 2.5, label="pin reversal", **marks)


def _degrees(span: float) -> MultipleLocator:
    """Ticks at round angles, for a span in degrees."""
    steps = [step for step in (5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0) if span / step <= 8.0]
    return MultipleLocator(steps[0] if steps else 90.0)


def plot_motion(motion: Motion) -> Figure:
    """Velocities and contact moment against time, and the phase portrait.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns.

    Raises
    ------
    InvalidValue
        For a motion without length.
    """
    figure = style.new_figure(style.TWO_COLUMN, 8.2)
    velocities, moment, phase = (style.dress(ax) for ax in figure.subplots(3, 1))
    plot_velocities(motion, velocities)
    plot_contact_moment(motion, moment)
    plot_phase_portrait(motion, phase)
    return figure
