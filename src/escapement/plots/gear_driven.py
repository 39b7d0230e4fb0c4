"""Gear-driven Geneva wheels drawn to scale, and the curves their pins trace."""

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement import validate
from escapement.mechanisms import GearDriven
from escapement.outlines.gear_driven import GearDrivenOutline
from escapement.plots import style
from escapement.plots.bodies import draw_body
from escapement.plots.tabulated import plot_mechanism

_FOLLOWER, _PLANET, _PIN = "#F5D7A9", "#DCE9F7", "#00446B"
_CHAIN = (0, (8, 2, 1.5, 2))


@plot_mechanism.register
def plot_gear_driven(mechanism: GearDriven, theta: float = 0.0, ax: Axes | None = None) -> Axes:
    """Gear-driven Geneva wheel to scale: fixed gear, planet, pin path and wheel.

    Parameters
    ----------
    mechanism : GearDriven
        What to draw. Pin and slot widths are the drawing's choice. Where unused
        lobes pass through the locked wheel it is cut away.
    theta : float
        Carrier angle from dead centre of the first pin [rad], of any size; in a
        dwell the wheel stands locked.
    ax : Axes, optional
        Where to draw; limits are set in fixed-gear radii, the axis at the origin.

    Returns
    -------
    Axes
        Artists carry ids: "follower", "fixed-gear", "planet", "carrier", "path",
        and "pin-k" with k counted from 0.

    Raises
    ------
    InvalidValue
        For more than 200 slots, a path of more than 200 lobes or turns,
        or an angle that is not finite.
    """
    angle = validate.number("theta", theta, "give the carrier angle in rad")
    style.check_drawn("slots", mechanism.slots)
    ratio = mechanism.gear_ratio
    style.check_drawn("lobes of the whole path", max(abs(ratio.numerator), ratio.denominator))
    outline = GearDrivenOutline(mechanism)
    if ax is None:
        ax = style.new_axes(style.ONE_COLUMN, style.ONE_COLUMN)
    _draw_wheel(ax, outline, angle)
    _draw_gears(ax, outline, angle)
    _draw_pins(ax, outline, angle)
    room = 1.06 * outline.reach
    ax.set(xlim=(-room, room), ylim=(-room, room), aspect="equal")
    ax.set_axis_off()
    return ax


def plot_gear_driven_examples() -> Figure:
    """Dijksman's mechanisms of figures 6 to 9, each in the middle of its motion."""
    cases = {
        6: GearDriven(4, 1, "epicycloid"),
        7: GearDriven(12, 5, "epicycloid"),
        8: GearDriven(4, 0, "hypocycloid"),
        9: GearDriven(12, 3, "hypocycloid"),
    }
    figure = style.new_figure(style.TWO_COLUMN, 2.25)
    for ax, (number, mechanism) in zip(figure.subplots(1, 4), cases.items(), strict=True):
        plot_gear_driven(mechanism, ax=ax)
        text = f"figure {number}: n = {mechanism.stations}, k = {mechanism.gear_ratio}"
        ax.set_title(text, fontsize=style.SMALL_SIZE)
    return figure


def plot_curves() -> Figure:
    """The four cycloids: two paths, each made by two pairs of gears (figure 2)."""
    cases = (
        GearDriven(12, 3, "hypocycloid"),
        GearDriven(12, 3, "contracted-hypocycloid"),
        GearDriven(12, 3, "epicycloid"),
        GearDriven(12, 3, "pericycloid"),
    )
    figure = style.new_figure(style.TWO_COLUMN, 2.35)
    for ax, mechanism in zip(figure.subplots(1, 4), cases, strict=True):
        outline = GearDrivenOutline(mechanism)
        _draw_gears(ax, outline, 0.5)
        _draw_pins(ax, outline, 0.5)
        room = 1.06 * outline.reach
        ax.set(xlim=(-room, room), ylim=(-room, room), aspect="equal")
        ax.set_axis_off()
        name = {"hypocycloid": "protracted\nhypocycloid"}.get(mechanism.curve, mechanism.curve)
        title = f"{name.replace('-', chr(10))}\nk = {mechanism.gear_ratio}"
        ax.set_title(title if "\n" in name or "-" in mechanism.curve else "\n" + title,
                     fontsize=style.SMALL_SIZE)  # fmt: skip
    return figure


def _draw_wheel(ax: Axes, outline: GearDrivenOutline, theta: float) -> None:
    """The wheel, cut away where unused lobes pass."""
    wheel = draw_body(
        ax, outline.wheel(theta), facecolor=_FOLLOWER, edgecolor=style.BLACK, linewidth=0.8,
        zorder=1, joinstyle="round",
    )  # fmt: skip
    for relief in outline.reliefs(theta):
        # the white fill hides the inner half of an edge, and where reliefs overlap
        look: dict[str, Any] = {"edgecolor": style.BLACK, "linewidth": 1.6, "zorder": 1.1}
        draw_body(ax, relief, fill=False, **look).set_clip_path(wheel)
        draw_body(ax, relief, color="white", linewidth=0, zorder=1.2)


def _draw_gears(ax: Axes, outline: GearDrivenOutline, theta: float) -> None:
    """Pitch circles of the fixed gear and the planet, the carrier between their axes."""
    fixed, planet = outline.gears(theta)
    pitch: dict[str, Any] = {"linewidth": 0.9, "linestyle": _CHAIN, "zorder": 2.2}
    draw_body(ax, fixed, fill=False, ec=style.GREY, **pitch)
    draw_body(ax, planet, fc=_PLANET, alpha=0.55, lw=0, zorder=2.1)
    draw_body(ax, planet, fill=False, ec=style.BLUE, **pitch)
    x, y = [0.0, planet.centre.real], [0.0, planet.centre.imag]
    ax.plot(x, y, color=style.BLACK, lw=1.4, zorder=2.5, gid="carrier")
    ax.plot(x, y, "o", color="white", mec=style.BLACK, ms=3.2, mew=0.8, zorder=2.6)
    path = outline.path()
    ax.plot(path.real, path.imag, color=style.VERMILLION, lw=0.8, zorder=2.3, gid="path")


def _draw_pins(ax: Axes, outline: GearDrivenOutline, theta: float) -> None:
    """Pins large enough to be seen, and the arms that carry them."""
    start = outline.carrier_end(theta)
    for pin in outline.pins(theta):
        ends = np.array([start, pin.centre])
        ax.plot(ends.real, ends.imag, color=_PIN, lw=1.2, zorder=2.7)
        seen = replace(pin, radius=max(pin.radius, 0.018 * outline.reach))
        draw_body(ax, seen, color=_PIN, lw=0, zorder=3)
