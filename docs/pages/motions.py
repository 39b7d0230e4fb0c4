"""Figures of Geneva wheels and their motions."""

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

import escapement as esc
from escapement import plots
from escapement.numerics.gauss import POINTS
from escapement.plots import style
from pages import FIGURES, LINES, drawn, panels, timer

_PLAIN = {"facecolor": "w", "edgecolor": "none", "pad": 1.0}
"""Background of a word that stands on a line."""


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


@drawn
def pieces_and_walls() -> Figure:
    """The pieces of an engagement and the points of their panels; the two walls of a slot."""
    figure, (left, right) = panels(2, 3.3)
    design = timer(4, 0.35, 0.10)
    motion = esc.simulate(design, 1, initial_speed=esc.terminal(design).handoff_velocity)
    table = motion.at(np.linspace(0.0, motion.end_time, 2000))
    ends = np.array([-np.pi / 4, 0.0, motion.reversals.theta[0], np.pi / 4])
    rho = design.inertia.driver / design.inertia.follower
    g = design.mechanism.transmission(table.theta).g
    energy = (rho + g**2) * table.theta_dot**2 / 1e3
    degrees = np.degrees(table.theta)
    names = ("pin on the front wall", None, "pin on the rear wall")
    colors = (style.BLUE, style.BLUE, style.VERMILLION)
    for start, end, name, color in zip(ends, ends[1:], names, colors, strict=False):
        part = (table.theta >= start) & (table.theta <= end)
        left.plot(degrees[part], energy[part], color=color, label=name)
        points = np.degrees((start + end) / 2 + (end - start) / 2 * np.array(POINTS))
        left.plot(points, np.interp(points, degrees, energy), "o", ms=3, color=color)
    top = 1.25 * energy.max()
    events = ("entry", "dead\ncentre", "reversal", "exit")
    sides = ("left", "center", "center", "right")
    for angle, event, side in zip(np.degrees(ends), events, sides, strict=True):
        left.axvline(angle, color=style.GREY, lw=0.8)
        left.text(angle, 0.98 * top, event, ha=side, va="top", fontsize=8, bbox=_PLAIN)
    left.set(xlabel="Driver angle from dead centre (°)", ylim=(0.0, top))
    left.set_ylabel("$E = (\\rho + g^2)\\,\\dot\\theta^2$ (1000 rad²/s²)")
    left.legend(frameon=False, loc="lower center", fontsize=8)
    _draw_walls(right)
    return figure


def _draw_walls(ax: Axes) -> None:
    """A slot with the pin on its front wall, and where the pin may be between the walls."""
    for height, name in ((1.0, "front wall, $s = +1$"), (-1.0, "rear wall, $s = -1$")):
        ax.plot([-2.2, 2.2], [height, height], color=style.BLACK, lw=1.6)
        ax.text(-2.1, 1.17 * height, name, ha="left", va="center", fontsize=9)
    ax.axhline(0.0, color=style.GREY, lw=0.8, ls="-.")
    ax.text(2.15, -0.04, "centre line", ha="right", va="top", fontsize=8)
    ax.add_patch(Circle((0.0, 0.4), 0.6, fc=style.LIGHT_GREY, ec=style.BLACK))
    ax.plot(0.0, 0.4, "+", color=style.BLACK)
    arrows = (
        ((0.0, 0.4), (0.0, 1.75), style.BLUE, "force of the pin\non the wheel", (0.12, 1.62)),
        ((1.0, 0.0), (1.0, 0.4), style.VERMILLION, "$\\delta = s\\,c$", (1.08, 0.2)),
        ((-1.35, -0.4), (-1.35, 0.4), style.GREY, "$2c$", (-1.27, 0.2)),
    )
    for start, end, color, words, at in arrows:
        looks = {"arrowstyle": "<->" if words == "$2c$" else "->", "color": color, "lw": 1.4}
        ax.annotate("", end, start, arrowprops=looks | {"shrinkA": 0, "shrinkB": 0})
        ax.text(*at, words, color=color, ha="left", va="center", fontsize=9)
    for height in (-0.4, 0.4):
        ax.plot([-1.6, 1.6], [height, height], color=style.GREY, lw=0.6, ls=":")
    ax.set(xlim=(-2.4, 2.4), ylim=(-1.5, 2.0), aspect="equal")
    ax.axis("off")
