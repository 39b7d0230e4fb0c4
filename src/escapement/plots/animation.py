"""Film of a motion: the turning mechanism to scale, beside its velocities."""

import math
from collections.abc import Callable

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes

from escapement.base import validate
from escapement.dynamics.motion import Motion, State
from escapement.mechanisms import EllipticalPlanetary, Geneva
from escapement.mechanisms.protocol import Mechanism
from escapement.mechanisms.two_bodies import TwoBodies
from escapement.plots import drawing, style
from escapement.plots.clearance_drawing import draw_close_up, exaggerated
from escapement.plots.geneva import plot_geneva
from escapement.plots.motion_plots import plot_velocities
from escapement.plots.planetary import draw_planetary, extent
from escapement.plots.touching_bodies import plot_touching

_MOST_FRAMES = 2_000


def animate(
    motion: Motion,
    start: float = 0.0,
    stop: float | None = None,
    *,
    frames: int = 100,
    rate: float = 25.0,
) -> FuncAnimation:
    """Film of a motion, in slow motion: drive and follower to scale, and their velocities.

    With clearance a further panel shows the pin in its slot, its clearance drawn wider.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns; the `motion` of `escapement.terminal` is periodic, so
        its film can loop.
    start, stop : float
        Part of the motion that is shown [s]. Default: all of it.
    frames : int
        Number of pictures, evenly spaced in time; some ten take about a second.
    rate : float
        Pictures per second when shown [1/s]; no viewer shows more than 50 of a .gif.

    Returns
    -------
    matplotlib.animation.FuncAnimation
        It can be written with `save` as .gif, .mp4 or .webm, or shown in a notebook with
        `IPython.display.HTML(film.to_jshtml())`. Its title gives the time and the factor of slow
        motion.

    Raises
    ------
    InvalidValue
        For a table of angles, which has no shape to be drawn, a part that is not within the
        motion, or a number of pictures beyond 2000.
    """
    mechanism = motion.escapement.mechanism
    # a mechanism without its own drawing function has no bodies
    if drawing.plot_mechanism.dispatch(type(mechanism)) is drawing.plot_mechanism.dispatch(object):
        remedy = "draw its motion with plot_velocities"
        raise validate.fail("motion", "of a mechanism that can be drawn", mechanism, remedy)
    end = float(motion.end_time)
    last = end if stop is None else stop
    if not 0.0 <= start < last <= end:
        given = f"start {start:g} and stop {last:g}"
        raise validate.fail("film", f"a part of the motion's {end:g} s", given, "leave both out")
    count = validate.integer("frames", frames, 2, "100 is a good choice", _MOST_FRAMES)
    rate = validate.positive("rate", rate, "25 pictures a second look smooth")
    times = np.linspace(start, last, count, endpoint=False)
    state = motion.at(times)
    figure = style.new_figure(style.TWO_COLUMN, 3.2)
    loose = _loose(mechanism)
    shares = (1.1, 0.8, 1.1) if loose else (1.0, 1.35)
    scene, *aside, velocities = figure.subplots(1, len(shares), width_ratios=shares)
    plot_velocities(motion, style.dress(velocities))
    factor, unit = style.scaled("s", [end])
    velocities.set_xlim(start * factor, last * factor)
    instant = velocities.axvline(start * factor, color=style.BLACK, lw=0.8, zorder=4)
    (marks,) = velocities.plot([], [], "o", color=style.BLACK, ms=4, zorder=5)
    draw = _drawing(scene, mechanism, state)
    wide = exaggerated(loose, state) if loose else None
    slower = count / rate / (last - start)
    rounded = float(f"{max(slower, 1.0 / slower):.3g}")
    pace = f"{rounded:g} times {'slower' if slower >= 1.0 else 'faster'}"
    # so many decimals that successive pictures have different titles
    digits = max(0, math.ceil(-math.log10(factor * (last - start) / count)))

    def show(frame: int) -> None:
        for ax in (scene, *aside):
            # to clear the axes would take longer: their scales and limits stay
            for artist in (*ax.patches, *ax.lines, *ax.texts):
                artist.remove()
        draw(frame)
        if wide is not None:
            draw_close_up(aside[0], wide, float(state.theta[frame]), frame)
        shown_time = times[frame] * factor
        # a second picture leaves less room
        between = "\n" if loose else ", "
        told = f"{shown_time:.{digits}f} {unit}{between}{pace}"
        # a title of fixed height saves the search for a free one
        scene.set_title(told, fontsize=style.SMALL_SIZE, y=1.0)
        instant.set_xdata([shown_time, shown_time])
        marks.set_data([shown_time, shown_time], [state.theta_dot[frame], state.phi_dot[frame]])

    show(0)
    # if the layout were made again for every picture, the axes would tremble
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    return FuncAnimation(figure, show, frames=count, interval=1e3 / rate)


def _loose(mechanism: Mechanism) -> Geneva | None:
    """A wheel with clearance, None for others."""
    return mechanism if isinstance(mechanism, Geneva) and mechanism.clearance > 0.0 else None


def _drawing(ax: Axes, mechanism: Mechanism, state: State) -> Callable[[int], object]:
    """What draws the mechanism at one of the times, with limits that do not change."""
    angles, follower_angles = state.theta.tolist(), state.phi.tolist()
    if wheel := _loose(mechanism):
        return lambda k: plot_geneva(wheel, angles[k], ax, follower_angle=follower_angles[k])
    if isinstance(mechanism, TwoBodies):
        return lambda k: plot_touching(mechanism, angles[k], ax, follower_angle=follower_angles[k])
    if not isinstance(mechanism, EllipticalPlanetary):
        return lambda k: drawing.plot_mechanism(mechanism, angles[k], ax)
    # the carrier turns, so the limits must have room for every picture
    left, right, bottom, top = np.array([extent(mechanism, theta) for theta in angles]).T
    box = left.min(), right.max(), bottom.min(), top.max()
    return lambda k: draw_planetary(drawing.dress_scene(ax, box), mechanism, angles[k], angles[k])
