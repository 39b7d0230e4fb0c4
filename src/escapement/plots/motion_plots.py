"""Figures of a motion: velocities, phase portrait, contact moment, or all on one sheet."""

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from escapement.base import validate
from escapement.dynamics.motion import Motion
from escapement.mechanisms.protocol import FloatArray
from escapement.plots import style
from escapement.plots.style import finished, readable, scaled

_CROWDED = 30  # with more handoffs, lines of full height would make the figure grey
_ROOM = 0.02  # free space beyond the end, as a share of the motion's length
_REPEATS = 0.01  # a cycle is terminal when its two handoff speeds agree within this share


def plot_velocities(motion: Motion, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Driver and follower velocity against time.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure across two columns.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Time [s, or ms where that is short] and velocity [rad/s, on the command line in the
        user's units].

    Source: the figure is Meyer (1973), figure 8.
    """
    times = times_of(motion)
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.0)
    factor, unit = scaled("s", times)
    state = motion.at(times)
    size, speed = readable("speed", state.theta_dot)
    ax.plot(times * factor, state.theta_dot * size, color=style.BLUE, lw=1.3, label="driver")
    ax.plot(times * factor, state.phi_dot * size, lw=1.1, label="follower", **style.BROKEN)
    ax.set_ylim(bottom=min(0.0, 1.05 * float(state.phi_dot.min() * size)))
    _mark_events(ax, motion, factor, motion.reversals.theta_dot * size)
    return finished(ax, ("time", unit), ("angular velocity", speed), 4, legend=legend)


def plot_phase_portrait(motion: Motion, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Driver velocity against driver angle from dead centre or in its pitch, one over the other.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure in one column.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Angle [degrees] and velocity, as in `plot_velocities`. The last whole engagement is
        bold, and called the terminal cycle when its two handoff speeds agree
        within 1 %; a dwell is shaded.
    """
    times = times_of(motion)
    size, unit = readable("speed", motion.handoff_velocities)
    ax = ax or style.new_axes(style.ONE_COLUMN, 3.0)
    mechanism = motion.escapement.mechanism
    entry, exit_, cell = mechanism.breaks[0], mechanism.breaks[-1], mechanism.cell_angle
    # angles come from rounded numbers, so a gap below 1e-9 is not a dwell
    if entry + cell - exit_ > 1e-9:
        dwell = np.degrees([exit_, entry + cell])
        ax.axvspan(*dwell, label="dwell", **style.SHADE | {"color": style.LIGHT_GREY})
    slowest = min(0.0, 1.05 * size * float(motion.extrema.theta_dot.min(initial=0.0)))
    ax.axvline(0.0, color=style.LIGHT_GREY, lw=0.6, ls=":", zorder=0)
    ends = motion.handoff_times[motion.handoff_times > times[0]]
    last = ends.size - 1
    first_name = "transient" if last > 0 else "unfinished"
    speeds = motion.handoff_velocities[-2:]
    repeats = speeds.size == 2 and abs(speeds[1] - speeds[0]) <= _REPEATS * abs(speeds[1])
    last_name = "terminal cycle" if repeats else "last whole engagement"
    indices = np.searchsorted(times, np.unique([times[0], *ends, times[-1]]))
    for index, (start, end) in enumerate(pairwise(indices)):
        look: dict[str, Any] = {"color": style.GREY, "lw": 0.6, "alpha": 0.7}
        look["label"] = "_" if index > 0 else first_name
        if index == last:
            look = {"color": style.BLUE, "lw": 1.8, "zorder": 3, "label": last_name}
        state = motion.at(times[start : end + 1])
        ax.plot(np.degrees(state.theta - index * cell), state.theta_dot * size, **look)
    found = motion.reversals
    local = found.theta - cell * np.floor((found.theta - entry) / cell)
    _mark_reversals(ax, motion, np.degrees(local), found.theta_dot * size)
    ax.set(xlim=np.degrees([entry, entry + cell]), ylim=(slowest, None))
    # more than eight ticks would crowd the axis
    tick = next((size for size in (5, 10, 15, 30, 45, 60) if np.degrees(cell) <= 8 * size), 90)
    ax.xaxis.set_major_locator(MultipleLocator(tick))
    name = f"driver angle {'from dead centre' if mechanism.pitch is None else 'in its pitch'}"
    return finished(ax, (name, "°"), ("driver velocity", unit), 2, legend=legend)


def plot_contact_moment(motion: Motion, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Moment of the pin on the follower against time; it jumps at handoffs.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns.
    ax : Axes, optional
        Where to draw. Default: a new figure across two columns.
    legend : bool
        Whether to draw one.

    Returns
    -------
    Axes
        Time [s] and moment [N m, on the command line in the user's units], with the prefixes
        that suit. Below zero, shaded, the follower drives the pin of a slot; in a dwell there is no
        contact.
    """
    times, moments = _moments(motion)
    ax = ax or style.new_axes(style.TWO_COLUMN, 3.0)
    factor, unit = scaled("s", times)
    prefix, moment_unit = readable("torque", moments)
    x, y = times * factor, moments * prefix
    ax.axhline(0.0, **style.ZERO)
    ax.plot(x, y, color=style.BLUE, lw=1.1, label="contact moment")
    if motion.escapement.mechanism.pitch is None and np.any(y < 0.0):
        ax.fill_between(x, y, 0.0, where=y < 0.0, label="follower drives", **style.SHADE)
    _mark_events(ax, motion, factor, np.zeros(motion.reversals.time.size))
    return finished(ax, ("time", unit), ("moment on the follower", moment_unit), 4, legend=legend)


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
    plots = plot_velocities, plot_contact_moment, plot_phase_portrait
    for plot, ax in zip(plots, figure.subplots(3, 1), strict=True):
        plot(motion, style.dress(ax))
    return figure


def times_of(motion: Motion) -> FloatArray:
    """Times evenly spaced in time and in angle, with all events, so that every peak shows."""
    grid = motion.t
    if grid.size < 2:
        got = f"none ({motion.message})"
        raise validate.fail("motion", "longer than zero to be plotted", got, "change its inputs")
    theta = motion.theta
    even = np.interp(np.linspace(theta[0], theta[-1], 2 * grid.size), theta, grid)
    events = [motion.handoff_times, motion.extrema.time, motion.reversals.time]
    return np.unique(np.concatenate([grid, even, *events]))


def _moments(motion: Motion) -> FloatArray:
    """Times and contact moments, one-sided at jumps; NaN between pieces of the solution."""
    times = times_of(motion)
    bounds = np.append(motion.trajectory.start, motion.end_time)
    gap = np.full((2, 1), np.nan)
    found = [gap]
    for piece, (start, end) in enumerate(pairwise(bounds)):
        # a piece without a sign of sliding is a dwell, in which nothing touches
        if motion.trajectory.sign[piece] != 0.0:
            first, last = np.searchsorted(times, start, "right"), np.searchsorted(times, end)
            t = np.concatenate([[start], times[first:last], [end]])
            found += [np.array([t, motion.within(piece, t).contact_moment]), gap]
    return np.hstack(found)


def _mark_events(ax: Axes, motion: Motion, factor: float, heights: FloatArray) -> None:
    """Reversals at `heights`, handoffs and limits of a figure over time."""
    _mark_reversals(ax, motion, motion.reversals.time * factor, heights)
    times = motion.handoff_times * factor
    if times.size:
        # many handoffs get short lines at the top, where no curve hides them
        bottom, line = (0.0, ":") if times.size <= _CROWDED else (0.97, "-")
        look: dict[str, Any] = {"color": style.LIGHT_GREY, "lw": 0.7, "ls": line, "zorder": 0}
        across = ax.get_xaxis_transform()
        ax.vlines(times, bottom, 1.0, transform=across, label="handoff", **look)
    # the space at the right shows that the motion ends there, and its last handoff completely
    ax.set_xlim(0.0, (1.0 + _ROOM) * motion.end_time * factor)


def _mark_reversals(ax: Axes, motion: Motion, x: FloatArray, y: FloatArray) -> None:
    if x.size:
        size = 4.0 if x.size <= _CROWDED else 2.5
        # bodies without slots have no other wall to which the contact would change
        slotted = motion.escapement.mechanism.pitch is None
        look = style.REVERSAL if slotted else style.REVERSAL | {"label": "lift-off"}
        ax.plot(x, y, "o", ms=size, zorder=4, **look)
