"""Gear-driven Geneva wheels drawn to scale, and the curves their pins trace."""

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement import validate
from escapement.mechanisms import GearDriven
from escapement.outlines import Body
from escapement.outlines.gear_driven import GearDrivenOutline
from escapement.plots import style
from escapement.plots.bodies import draw_bodies, dress_scene
from escapement.plots.tabulated import plot_mechanism

_PIN = "#00446B"
_PITCH: dict[str, Any] = {"fill": False, "linestyle": (0, (8, 2, 1.5, 2)), "zorder": 2.2}
_LOOKS: dict[str, dict[str, Any]] = {
    "follower": {"facecolor": "#F5D7A9", "linewidth": 0.8, "zorder": 1, "joinstyle": "round"},
    "fixed-gear": {**_PITCH, "edgecolor": style.GREY},
    "planet": {**_PITCH, "edgecolor": style.BLUE},
    "pin": {"color": _PIN, "linewidth": 0, "zorder": 3},
}
_PLANET = {"planet": {"facecolor": "#DCE9F7", "alpha": 0.55, "linewidth": 0, "zorder": 2.1}}
# the white fill hides the inner half of a relief's edge, and where reliefs overlap
_EDGE = {"relief": {"fill": False, "edgecolor": style.BLACK, "linewidth": 1.6, "zorder": 1.1}}
_ROOM = {"relief": {"color": "white", "linewidth": 0, "zorder": 1.2}}


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
    return _draw(ax, outline, angle, wheel=True)


def plot_gear_driven_examples() -> Figure:
    """Dijksman's mechanisms of figures 6 to 9, each in the middle of its motion."""
    wheels = (
        GearDriven(4, 1, "epicycloid"),
        GearDriven(12, 5, "epicycloid"),
        GearDriven(4, 0, "hypocycloid"),
        GearDriven(12, 3, "hypocycloid"),
    )
    titles = {
        f"figure {number}: n = {wheel.stations}, k = {wheel.gear_ratio}": wheel
        for number, wheel in enumerate(wheels, 6)
    }
    return _draw_row(titles, 2.25, 0.0, wheel=True)


def plot_curves() -> Figure:
    """The four cycloids: two paths, each made by two pairs of gears (figure 2)."""
    names = {
        "protracted\nhypocycloid": "hypocycloid",
        "contracted\nhypocycloid": "contracted-hypocycloid",
        "\nepicycloid": "epicycloid",
        "\npericycloid": "pericycloid",
    }
    wheels = {name: GearDriven(12, 3, curve) for name, curve in names.items()}
    titles = {f"{name}\nk = {wheel.gear_ratio}": wheel for name, wheel in wheels.items()}
    return _draw_row(titles, 2.35, 0.5, wheel=False)


def _draw_row(titles: dict[str, GearDriven], height: float, theta: float, *, wheel: bool) -> Figure:
    figure = style.new_figure(style.TWO_COLUMN, height)
    axes = figure.subplots(1, len(titles))
    for ax, (title, mechanism) in zip(axes, titles.items(), strict=True):
        _draw(ax, GearDrivenOutline(mechanism), theta, wheel=wheel)
        ax.set_title(title, fontsize=style.SMALL_SIZE)
    return figure


def _draw(ax: Axes | None, outline: GearDrivenOutline, theta: float, *, wheel: bool) -> Axes:
    """Gears, carrier, path and pins, with or without the wheel that they turn."""
    room = 1.06 * outline.reach
    ax = dress_scene(ax, (-room, room, -room, room))
    follower, fixed, planet, *pins = outline.bodies(theta)
    if wheel:
        _draw_wheel(ax, outline, follower, theta)
    # pins are drawn large enough to be seen
    least = 0.018 * outline.reach
    seen = [replace(pin, radius=max(pin.radius, least)) for pin in pins]
    draw_bodies(ax, [planet], _PLANET)
    draw_bodies(ax, [fixed, planet, *seen], _LOOKS, linewidth=0.9)
    centre = planet.centre
    x, y = [0.0, centre.real], [0.0, centre.imag]
    ax.plot(x, y, color=style.BLACK, lw=1.4, zorder=2.5, gid="carrier")
    ax.plot(x, y, "o", color="white", mec=style.BLACK, ms=3.2, mew=0.8, zorder=2.6)
    path = outline.path()
    ax.plot(path.real, path.imag, color=style.VERMILLION, lw=0.8, zorder=2.3, gid="path")
    for pin in pins:
        ends = np.array([centre, pin.centre])
        ax.plot(ends.real, ends.imag, color=_PIN, lw=1.2, zorder=2.7)
    return ax


def _draw_wheel(ax: Axes, outline: GearDrivenOutline, follower: Body, theta: float) -> None:
    """The wheel, cut away where unused lobes pass."""
    wheel = draw_bodies(ax, [follower], _LOOKS, edgecolor=style.BLACK)["follower"]
    for relief in outline.reliefs(theta):
        draw_bodies(ax, [relief], _EDGE)["relief"].set_clip_path(wheel)
        draw_bodies(ax, [relief], _ROOM)
