"""Figures of Geneva wheels and their motions."""

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.figure import Figure

import escapement as esc
from escapement import plots
from escapement.plots import style
from pages import FIGURES, LINES, drawn, panels, timer


@drawn
def mechanisms() -> Figure:
    """The three continuous drives."""
    return plots.plot_configurations(np.radians(-15.0))


@drawn
def dwell_and_internal() -> Figure:
    """A drive in its dwell, one with many slots, an internal one."""
    figure, axes = panels(3, 2.9)
    shown = (
        (esc.Geneva(4, pins=1), 180.0, "4 slots, 1 pin, in dwell"),
        (esc.Geneva(8), 10.0, "8 slots, 1 pin"),
        (esc.Geneva(4, internal=True), -50.0, "4 slots, internal"),
    )
    for ax, (mechanism, degrees, title) in zip(axes, shown, strict=True):
        plots.plot_mechanism(mechanism, np.radians(degrees), ax)
        limits = np.array([ax.get_xlim(), ax.get_ylim()])
        half = np.array([-0.5, 0.5]) * np.ptp(limits, axis=1).max()
        ax.set(xlim=limits[0].mean() + half, ylim=limits[1].mean() + half)  # titles in one row
        ax.set_title(title, fontsize=9)
    return figure


@drawn
def transmission() -> Figure:
    """Transmission function and sliding of the three continuous drives."""
    figure, axes = panels(2, 2.8)
    for slots, (color, dashes) in zip((3, 4, 6), LINES, strict=False):
        wheel = esc.Geneva(slots)
        theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 400)
        table = wheel.transmission(theta)
        for ax, values in zip(axes, (table.g, table.u), strict=True):
            ax.plot(np.degrees(theta), values, ls=dashes, color=color, label=f"{slots} slots")
    for ax, name in zip(axes, ("Transmission g = dφ/dθ", "Relative sliding speed u"), strict=True):
        ax.set(xlabel="Driver angle from dead centre (°)", ylabel=name, xlim=(-60, 60))
    axes[0].legend(frameon=False)
    return figure


@drawn
def velocities() -> Figure:
    """Meyer's figure 8."""
    return plots.plot_velocities(esc.simulate(timer(4, 0.35, 0.10), 5)).figure


@drawn
def contact_moment() -> Figure:
    """Two terminal engagements."""
    design = timer(4, 0.35, 0.10)
    handoff = esc.terminal(design).handoff_velocity
    return plots.plot_contact_moment(esc.simulate(design, 2, initial_speed=handoff)).figure


@drawn
def phase_portrait() -> Figure:
    """From rest to the terminal cycle with little friction."""
    ax = plots.new_axes(5.4, 3.6)
    plots.plot_phase_portrait(esc.simulate(timer(4, 0.05, 0.10), 9), ax)
    return ax.figure


@drawn
def handoff_map() -> Figure:
    """Squared handoff speed against the one before, and the handoff speeds."""
    figure, (left, right) = panels(2, 3.3)
    least, most = 0.0, 170.0  # of the squared speed, in 1000 rad²/s²
    entry = np.sqrt(1e3 * np.linspace(least, most, 15))
    for mu, (color, dashes) in zip((0.0, 0.05, 0.1, 0.2, 0.35), LINES, strict=False):
        design = timer(4, mu, 0.10)
        leave = [esc.simulate(design, 1, initial_speed=v).handoff_velocities[0] for v in entry]
        look = {"ls": dashes, "color": color}
        left.plot(entry**2 / 1e3, np.square(leave) / 1e3, label=f"µ = {mu:.2f}", **look)
        if mu > 0.0:
            fixed = esc.terminal(design).handoff_velocity ** 2 / 1e3
            left.plot(fixed, fixed, "o", color=color, ms=6, mec="black", mew=0.8, zorder=4)
        speeds = [0.0, *esc.simulate(design, 8).handoff_velocities]
        right.plot(range(9), speeds, marker="o", ms=4, mfc="white", **look)
    left.plot([], [], "o", color="white", ms=6, mec="black", mew=0.8, label="fixed point")
    left.plot([least, most], [least, most], color=style.GREY, lw=0.8)
    left.text(
        0.61 * most, 0.61 * most - 4.0, "no change", color=style.GREY, va="top",
        fontsize=style.SMALL_SIZE, ha="center", rotation=45.0,
        rotation_mode="anchor", transform_rotates_text=True,
    )  # fmt: skip
    left.set(xlim=(least, most), ylim=(0, 280))
    left.set_xlabel("Squared handoff speed (1000 rad²/s²)")
    left.set_ylabel("At the next handoff (1000 rad²/s²)")
    right.set(xlabel="Engagement", ylabel="Handoff velocity (rad/s)", ylim=(0, 1000))
    where = {"loc": "outside upper center", "columnspacing": 1.2}
    style.add_legend(figure, 6, handlelength=style.HANDLE, **where)
    return figure


def timer_film() -> FuncAnimation:
    """The terminal cycle of Meyer's four-slot escapement."""
    return plots.animate(esc.terminal(timer(4, 0.35, 0.10)).motion, frames=36, rate=20.0)


FIGURES["timer.gif"] = timer_film
