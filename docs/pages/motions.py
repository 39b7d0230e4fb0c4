"""Figures of Geneva wheels and their motions."""

import numpy as np
from matplotlib.figure import Figure

import escapement as esc
from escapement import plots
from pages import LINES, drawn, panels, timer


@drawn
def mechanisms() -> Figure:
    """The three continuous drives."""
    return plots.plot_configurations(np.radians(-15.0))


@drawn
def dwell_and_internal() -> Figure:
    """A drive in its dwell, a fine one at dead centre, an internal one."""
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
    for slots, (color, style) in zip((3, 4, 6), LINES, strict=False):
        wheel = esc.Geneva(slots)
        theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 400)
        table = wheel.transmission(theta)
        for ax, values in zip(axes, (table.g, table.u), strict=True):
            ax.plot(np.degrees(theta), values, ls=style, color=color, label=f"{slots} slots")
    for ax, name in zip(axes, ("Transmission g", "Sliding u"), strict=True):
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
    figure, (left, right) = panels(2, 3.1)
    entry = np.linspace(0.0, 350.0, 15)
    for mu, (color, style) in zip((0.0, 0.05, 0.1, 0.2, 0.35), LINES, strict=True):
        design = timer(4, mu, 0.10)
        leave = [esc.simulate(design, 1, initial_speed=v).handoff_velocities[0] for v in entry]
        name = f"µ = {mu:.2f}"
        left.plot(entry**2 / 1e3, np.square(leave) / 1e3, ls=style, color=color, label=name)
        speeds = [0.0, *esc.simulate(design, 8).handoff_velocities]
        right.plot(range(9), speeds, ls=style, marker="o", ms=4, mfc="white", color=color)
    left.plot([0, 122], [0, 122], color="grey", lw=0.8)
    left.set(xlim=(0, 122), ylim=(0, 230))
    left.set_xlabel("w at a handoff (1000 rad²/s²)")
    left.set_ylabel("w at the next (1000 rad²/s²)")
    right.set(xlabel="Engagement", ylabel="Handoff velocity (rad/s)", ylim=(0, 1000))
    figure.legend(loc="outside upper center", ncols=5, frameon=False, fontsize=8)
    return figure
