"""Gear-driven Geneva wheels drawn to scale, and the curves their pins trace."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement import validate
from escapement.mechanisms import GearDriven
from escapement.outlines.gears import GearDrivenOutline
from escapement.plots import drawing, style

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

_EXAMPLES = ((4, 1, "epicycloid"), (12, 5, "epicycloid"), (4, 0, "hypocycloid"), (12, 3))
_CURVES = {
    "hypocycloid": "protracted\nhypocycloid",
    "contracted-hypocycloid": "contracted\nhypocycloid",
    "epicycloid": "\nepicycloid",
    "pericycloid": "\npericycloid",
}


@drawing.plot_mechanism.register
def plot_gear_driven(mechanism: GearDriven, theta: float = 0.0, ax: Axes | None = None) -> Axes:
    """Gear-driven Geneva wheel to scale: fixed gear, planet, pin path and wheel.

    Parameters
    ----------
    mechanism : GearDriven
        What to draw. The width of pins without a `pin_radius` and of their slots is the
        drawing's choice. Where unused lobes pass through the locked wheel it is cut away.
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
    wheels = [GearDriven(*numbers) for numbers in _EXAMPLES]
    titles = [f"figure {i}: n = {w.stations}, k = {w.gear_ratio}" for i, w in enumerate(wheels, 6)]
    return _draw_row(wheels, titles, 2.25, 0.0, wheel=True)


def plot_curves() -> Figure:
    """The four cycloids: two paths, each made by two pairs of gears (figure 2)."""
    wheels = [GearDriven(12, 3, curve) for curve in _CURVES]
    names = zip(_CURVES.values(), wheels, strict=True)
    titles = [f"{name}\nk = {wheel.gear_ratio}" for name, wheel in names]
    return _draw_row(wheels, titles, 2.35, 0.5, wheel=False)


def _draw_row(
    wheels: Sequence[GearDriven], titles: Sequence[str], height: float, theta: float, *, wheel: bool
) -> Figure:
    figure = style.new_figure(style.TWO_COLUMN, height)
    panels = zip(figure.subplots(1, len(wheels)), wheels, titles, strict=True)
    for ax, mechanism, title in panels:
        _draw(ax, GearDrivenOutline(mechanism), theta, wheel=wheel)
        ax.set_title(title, fontsize=style.SMALL_SIZE)
    return figure


def _draw(ax: Axes | None, outline: GearDrivenOutline, theta: float, *, wheel: bool) -> Axes:
    """Gears, carrier, path and pins, with or without the wheel that they turn."""
    room = 1.06 * outline.reach
    ax = drawing.dress_scene(ax, (-room, room, -room, room))
    follower, fixed, planet, *pins = outline.bodies(theta)
    if wheel:
        solid = drawing.bodies(ax, [follower], _LOOKS, edgecolor=style.BLACK)["follower"]
        for relief in outline.reliefs(theta):  # the wheel is cut away where unused lobes pass
            drawing.bodies(ax, [relief], _EDGE)["relief"].set_clip_path(solid)
            drawing.bodies(ax, [relief], _ROOM)
    rollers = {"roller": {"facecolor": "white", "edgecolor": _PIN, "zorder": 2.9}}
    drawing.bodies(ax, pins, rollers, linewidth=0.9)
    # pins of no given radius are drawn large enough to be seen
    least = 0.0 if outline.mechanism.contact_radius else 0.018 * outline.reach
    seen = [pin._replace(radius=max(pin.radius, least)) for pin in pins]
    drawing.bodies(ax, [planet], _PLANET)
    drawing.bodies(ax, [fixed, planet, *seen], _LOOKS, linewidth=0.9)
    arm = np.array([0.0, planet.centre])
    drawing.curve(ax, arm, color=style.BLACK, lw=1.4, zorder=2.5, gid="carrier")
    drawing.curve(ax, arm, "o", color="white", mec=style.BLACK, ms=3.2, mew=0.8, zorder=2.6)
    drawing.curve(ax, outline.path(), color=style.VERMILLION, lw=0.8, zorder=2.3, gid="path")
    for pin in pins:
        drawing.curve(ax, np.array([planet.centre, pin.centre]), color=_PIN, lw=1.2, zorder=2.7)
    return ax
