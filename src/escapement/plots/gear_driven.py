"""Gear-driven Geneva wheels drawn to scale, and the curves their pins trace."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, PathPatch
from matplotlib.path import Path

from escapement import validate
from escapement.mechanisms import GearDriven
from escapement.outlines.gear_driven import GearWheels
from escapement.plots import style

_FOLLOWER, _PLANET, _PIN = "#F5D7A9", "#DCE9F7", "#00446B"
_CHAIN = (0, (8, 2, 1.5, 2))


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
        For another mechanism, more than 200 slots, a path of more than 200 lobes or turns,
        or an angle that is not finite.
    """
    if not isinstance(mechanism, GearDriven):
        raise validate.fail(
            "mechanism", "gear-driven", mechanism, "give for example GearDriven(12, 3)"
        )
    angle = validate.number("theta", theta, "give the carrier angle in rad")
    style.check_drawn("slots", mechanism.slots)
    ratio = mechanism.gear_ratio
    style.check_drawn("lobes of the whole path", max(abs(ratio.numerator), ratio.denominator))
    wheels = GearWheels(mechanism)
    if ax is None:
        ax = style.new_axes(style.ONE_COLUMN, style.ONE_COLUMN)
    _draw_wheel(ax, wheels, angle)
    _draw_gears(ax, wheels, angle)
    _draw_pins(ax, wheels, angle)
    room = 1.06 * wheels.reach
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
        wheels = GearWheels(mechanism)
        _draw_gears(ax, wheels, 0.5)
        _draw_pins(ax, wheels, 0.5)
        room = 1.06 * wheels.reach
        ax.set(xlim=(-room, room), ylim=(-room, room), aspect="equal")
        ax.set_axis_off()
        name = {"hypocycloid": "protracted\nhypocycloid"}.get(mechanism.curve, mechanism.curve)
        title = f"{name.replace('-', chr(10))}\nk = {mechanism.gear_ratio}"
        ax.set_title(title if "\n" in name or "-" in mechanism.curve else "\n" + title,
                     fontsize=style.SMALL_SIZE)  # fmt: skip
    return figure


def _draw_wheel(ax: Axes, wheels: GearWheels, theta: float) -> None:
    turn = np.exp(1j * wheels.wheel_at(theta))
    rings = [Path(_points(outline * turn), closed=True) for outline in wheels.outlines()]
    body = PathPatch(
        Path.make_compound_path(*rings), facecolor=_FOLLOWER, edgecolor=style.BLACK,
        linewidth=0.8, zorder=1, joinstyle="round", gid="follower",
    )  # fmt: skip
    ax.add_patch(body)
    for outline in wheels.reliefs():
        shape = Path(_points(outline * turn), closed=True)
        # fills hide the inner half of all edges, and what one relief cuts off another
        edge = PathPatch(shape, fill=False, edgecolor=style.BLACK, linewidth=1.6)
        ax.add_patch(edge).set(zorder=1.1, clip_path=body, gid="relief")
        ax.add_patch(PathPatch(shape, color="white", linewidth=0, zorder=1.2))


def _draw_gears(ax: Axes, wheels: GearWheels, theta: float) -> None:
    """Pitch circles of the fixed gear and the planet, the carrier between their axes."""
    centre = wheels.mechanism.arms.first * np.exp(1j * theta)
    place = (centre.real, centre.imag)
    pitch: dict[str, Any] = {"linewidth": 0.9, "linestyle": _CHAIN, "zorder": 2.2}
    ax.add_patch(Circle((0, 0), 1.0, fill=False, ec=style.GREY, gid="fixed-gear", **pitch))
    ax.add_patch(Circle(place, wheels.planet, fc=_PLANET, alpha=0.55, lw=0, zorder=2.1))
    ax.add_patch(Circle(place, wheels.planet, fill=False, ec=style.BLUE, gid="planet", **pitch))
    ax.plot([0, place[0]], [0, place[1]], color=style.BLACK, lw=1.4, zorder=2.5, gid="carrier")
    ax.plot([0, place[0]], [0, place[1]], "o", color="white", mec=style.BLACK, ms=3.2, mew=0.8,
            zorder=2.6)  # fmt: skip
    path = wheels.path()
    ax.plot(path.real, path.imag, color=style.VERMILLION, lw=0.8, zorder=2.3, gid="path")


def _draw_pins(ax: Axes, wheels: GearWheels, theta: float) -> None:
    centre = wheels.mechanism.arms.first * np.exp(1j * theta)
    for number in range(wheels.mechanism.pins):
        pin = complex(wheels.pin_at(theta, number))
        ax.plot([centre.real, pin.real], [centre.imag, pin.imag], color=_PIN, lw=1.2, zorder=2.7)
        size = max(wheels.pin, 0.018 * wheels.reach)
        ax.add_patch(Circle((pin.real, pin.imag), size, color=_PIN, lw=0, zorder=3,
                            gid=f"pin-{number}"))  # fmt: skip


def _points(values: np.ndarray) -> np.ndarray:
    """Complex numbers as rows of x and y."""
    return np.column_stack([values.real, values.imag])
