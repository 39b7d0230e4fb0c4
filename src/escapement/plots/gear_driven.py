"""Gear-driven Geneva wheels drawn to scale, and the curves of their pins."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from escapement.base import validate
from escapement.mechanisms import GearDriven
from escapement.outlines.gears import GearDrivenOutline
from escapement.plots import drawing, style

_PIN = "#00446B"
_PITCH: dict[str, Any] = {"linestyle": (0, (8, 2, 1.5, 2))}
_LOOKS: dict[str, dict[str, Any]] = {
    "follower": {
        "facecolor": "#F5D7A9", "linewidth": 0.8, "zorder": 1, "joinstyle": "round",
        "label": "wheel",
    },
    "fixed-gear": {
        **_PITCH, "fill": False, "edgecolor": style.GREY, "zorder": 2.2, "label": "fixed gear",
    },
    "planet": {
        **_PITCH, "facecolor": ("#DCE9F7", 0.55), "edgecolor": style.BLUE, "zorder": 2.1,
        "label": "planet",
    },
    "pin": {"color": _PIN, "linewidth": 0, "zorder": 3},
}  # fmt: skip
# the white fill hides the inner half of a relief's edge, and where reliefs overlap
_EDGE = {"relief": {"fill": False, "edgecolor": style.BLACK, "linewidth": 1.6, "zorder": 1.1}}
_EDGE["relief"]["label"] = "cut away"
_ROOM = {"relief": {"color": "white", "linewidth": 0, "zorder": 1.2}}
_GAP = 0.02  # around what is drawn in a panel, of its height
_WORDS = 0.65  # room of key and titles [in]

_EXAMPLES = ((4, 1, "epicycloid"), (12, 5, "epicycloid"), (4, 0, "hypocycloid"), (12, 3))
_CURVES = ("hypocycloid", "contracted-hypocycloid", "epicycloid", "pericycloid")


@drawing.plot_mechanism.register
def plot_gear_driven(mechanism: GearDriven, theta: float = 0.0, ax: Axes | None = None) -> Axes:
    """Gear-driven Geneva wheel to scale: fixed gear, planet, pin path and wheel.

    Parameters
    ----------
    mechanism : GearDriven
        What to draw. Pins without a `pin_radius`, and their slots, are drawn with a symbolic
        width. Where unused lobes pass through the locked wheel it is cut away.
    theta : float
        Carrier angle from dead centre of the first pin [rad], of any size; in a
        dwell the wheel stands locked.
    ax : Axes, optional
        Where to draw; limits are set in fixed-gear radii, the axis at the origin.

    Returns
    -------
    Axes
        Artists carry ids: "follower", "fixed-gear", "planet", "carrier", "path",
        and "pin-k" with k counted from 0; and labels for `ax.legend()`.

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
    """Dijksman's mechanisms of figures 6 to 9, each soon after the middle of its motion."""
    wheels = [GearDriven(*numbers) for numbers in _EXAMPLES]
    titles = [
        f"figure {number}, {it.curve}\n{it.stations} stations, {_ratio(it)}"
        for number, it in enumerate(wheels, 6)
    ]
    return plot_row(dict(zip(titles, wheels, strict=True)), 0.12)


def plot_curves() -> Figure:
    """The four cycloids: two paths, each made by two pairs of gears (figure 2)."""
    wheels = [GearDriven(12, 3, curve) for curve in _CURVES]
    titles = [f"{it.curve.replace('-', ' ')}\n{_ratio(it)}" for it in wheels]
    return plot_row(dict(zip(titles, wheels, strict=True)), 0.5, wheel=False)


def plot_row(mechanisms: Mapping[str, GearDriven], theta: float, *, wheel: bool = True) -> Figure:
    """Mechanisms side by side and equally high, above a key to their colours.

    Parameters
    ----------
    mechanisms : mapping
        What to draw, by its title.
    theta : float
        Carrier angle from dead centre of the first pin [rad].
    wheel : bool
        Whether to draw the wheels, or only the parts that move the pins.
    """
    figure = style.new_figure(style.TWO_COLUMN)
    figure.set_layout_engine("compressed")
    panels, key, shapes = figure.subplots(1, len(mechanisms)), dict[str, Any](), list[float]()
    for ax, (title, mechanism) in zip(panels, mechanisms.items(), strict=True):
        _draw(ax, GearDrivenOutline(mechanism), theta, wheel=wheel)
        # no room for other positions
        scale = ax.transData.inverted()
        boxes = [patch.get_window_extent().transformed(scale) for patch in ax.patches]
        whole = Bbox.union([ax.dataLim, *boxes])
        box = whole.padded(_GAP * whole.height)
        ax.set(xlim=box.intervalx, ylim=box.intervaly)
        ax.set_title(title, fontsize=style.SMALL_SIZE)
        shapes.append(box.width / box.height)
        handles, labels = ax.get_legend_handles_labels()
        key |= zip(labels, handles, strict=True)
    panels[0].get_gridspec().set_width_ratios(shapes)
    figure.set_figheight(style.TWO_COLUMN / sum(shapes) + _WORDS)
    style.add_legend(
        figure, len(key), handles=[*key.values()], loc="outside lower center", columnspacing=1.2
    )
    return figure


def _ratio(mechanism: GearDriven) -> str:
    """The gear ratio, with the sign as printed."""
    return f"k = {mechanism.gear_ratio}".replace("-", "−")


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
    visible = [pin._replace(radius=max(pin.radius, least)) for pin in pins]
    drawing.bodies(ax, [fixed, planet, *visible], _LOOKS, linewidth=0.9)
    arm = np.array([0.0, planet.centre])
    look: dict[str, Any] = {"lw": 1.4, "zorder": 2.5, "gid": "carrier", "label": "carrier"}
    drawing.curve(ax, arm, color=style.BLACK, **look)
    drawing.curve(ax, arm, "o", color="white", mec=style.BLACK, ms=3.2, mew=0.8, zorder=2.6)
    look = {"lw": 0.8, "zorder": 2.3, "gid": "path", "label": "path of a pin"}
    drawing.curve(ax, outline.path(), color=style.VERMILLION, **look)
    look = {"lw": 1.2, "zorder": 2.7, "label": "arm with its pin"}
    for pin in pins:
        drawing.curve(ax, np.array([planet.centre, pin.centre]), color=_PIN, **look)
    return ax
