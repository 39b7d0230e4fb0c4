"""The planetary drive with elliptical gears drawn to scale, in any position."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Polygon
from matplotlib.path import Path

from escapement import validate
from escapement.mechanisms import EllipticalPlanetary
from escapement.model import FloatArray
from escapement.plots import style

_SPUR, _DRIVING, _DRIVEN = "#e4e4e4", "#9cc7e8", "#f6d9a8"
_MARGIN = 0.12  # of the centre distance
_POINTS = 241


def plot_planetary(
    mechanism: EllipticalPlanetary, theta: float = 0.0, ax: Axes | None = None
) -> Axes:
    """Planetary drive with elliptical gears to scale, in millimetres.

    Parameters
    ----------
    mechanism : EllipticalPlanetary
        What to draw: pitch curves, without teeth.
    theta : float
        Driver angle from greatest output speed [rad], of any size.
    ax : Axes, optional
        Where to draw; the carrier's axis is its origin. Default: a new figure.

    Returns
    -------
    Axes
        Artists carry ids: "sun", "planet", "driven", "driving" (the ellipses),
        "contact" (of the ellipses) and "carrier".

    Raises
    ------
    InvalidValue
        For another mechanism, or an angle that is not finite.
    """
    if not isinstance(mechanism, EllipticalPlanetary):
        raise validate.fail(
            "mechanism", "a planetary drive with elliptical gears", mechanism,
            "give EllipticalPlanetary(16e-3, 9e-3)",
        )  # fmt: skip
    angle = validate.number("theta", theta, "give the driver angle in rad")
    left, right, bottom, top = box = extent(mechanism, angle)
    if ax is None:
        ax = style.new_axes(style.ONE_COLUMN, style.ONE_COLUMN * (top - bottom) / (right - left))
    draw_planetary(ax, mechanism, angle, angle)
    _draw_senses(ax, mechanism, angle)
    _draw_scale(ax, mechanism, box)
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    ax.set_axis_off()
    return ax


def draw_planetary(
    ax: Axes, mechanism: EllipticalPlanetary, theta: float, carrier: float
) -> FloatArray:
    """Gears and line of centres; the carrier points along `carrier` [rad].

    Returns
    -------
    ndarray, shape (4,)
        Distances of A, B, C and D from the carrier's axis along the carrier [mm]:
        the axis, the rolling point of the spur gears, the planet's shaft and the
        contact of the ellipses.
    """
    sun, planet = 1e3 * mechanism.sun_radius, 1e3 * mechanism.planet_radius
    distance = sun + planet
    along = np.exp(1j * carrier)
    shaft = distance * along
    edge: dict[str, Any] = {"edgecolor": style.BLACK, "linewidth": 0.8}
    place = (shaft.real, shaft.imag)
    for centre, radius, name in (((0.0, 0.0), sun, "sun"), (place, planet, "planet")):
        ax.add_patch(Circle(centre, radius, facecolor=_SPUR, zorder=1, gid=name, **edge))
    driven, driving = outlines(mechanism, theta)
    ax.add_patch(_body(driven * along, _DRIVEN, "driven", 2.0))
    ax.add_patch(_body(shaft + driving * along, _DRIVING, "driving", 2.1))
    for centre, radius in (((0.0, 0.0), sun), (place, planet)):  # what the ellipses hide
        ax.add_patch(
            Circle(centre, radius, fill=False, ec=style.GREY, lw=0.6, ls=(0, (4, 2.5)), zorder=2.4)
        )
    for line in (driven * along, shaft + driving * along):  # long axes tell how they are turned
        ends = line[[0, _POINTS // 2]]
        ax.plot(ends.real, ends.imag, color=style.GREY, lw=0.6, ls=(0, (6, 2, 1, 2)), zorder=2.3)
    ax.plot(
        [0, shaft.real], [0, shaft.imag], "o-", color=style.BLACK, lw=1.6, ms=4, mfc="white",
        zorder=3, gid="carrier",
    )  # fmt: skip
    rho = 1e3 * float(mechanism.pitch_ellipses[0].radius(mechanism.ratio * theta))
    contact = (distance - rho) * along
    ax.plot(contact.real, contact.imag, "o", color=style.VERMILLION, ms=4, zorder=4, gid="contact")
    return np.array([0.0, sun, distance, distance - rho])


def outlines(mechanism: EllipticalPlanetary, theta: float) -> tuple[np.ndarray, np.ndarray]:
    """Edges of driven and driving ellipse, as complex numbers [mm].

    Each about its own pivot, the carrier along the real axis from the driven
    ellipse's pivot to the driving one's.
    """
    driving, driven = mechanism.pitch_ellipses
    sweep = np.linspace(0.0, 2.0 * np.pi, _POINTS)
    turned = theta + float(mechanism.follower_angle(theta))
    inner = 1e3 * driven.radius(sweep) * np.exp(1j * (sweep - turned))
    outer = -1e3 * driving.radius(sweep) * np.exp(1j * (sweep + mechanism.ratio * theta))
    return inner, outer


def _body(edge: np.ndarray, colour: str, name: str, order: float) -> Polygon:
    return Polygon(
        np.column_stack([edge.real, edge.imag]), facecolor=colour, edgecolor=style.BLACK,
        linewidth=0.9, zorder=order, gid=name, alpha=0.85,
    )  # fmt: skip


def _draw_senses(ax: Axes, mechanism: EllipticalPlanetary, theta: float) -> None:
    """Letters at the pivots, and arrows for carrier and output."""
    distance = 1e3 * mechanism.centre_distance
    shaft = distance * np.exp(1j * theta)
    # letters to the right of the carrier, arrows to its left and behind it
    aside = 10.0 * np.exp(1j * (theta - 0.5 * np.pi))
    style.write(ax, "A", (0.0, 0.0), (aside.real, aside.imag))
    style.write(ax, "C", (shaft.real, shaft.imag), (aside.real, aside.imag))
    # the carrier turns counter-clockwise, the output the other way
    for arc in (
        distance * np.exp(1j * (theta + np.linspace(0.1, 0.4, 21))),
        0.42e3 * mechanism.sun_radius * np.exp(1j * (theta + np.pi - np.linspace(-0.9, 0.9, 31))),
    ):
        arrow = FancyArrowPatch(
            path=Path(np.column_stack([arc.real, arc.imag])), arrowstyle="-|>", mutation_scale=8
        )
        ax.add_patch(arrow)
        arrow.set(color=style.BLACK, linewidth=0.8, zorder=5, fill=True)


def extent(mechanism: EllipticalPlanetary, theta: float) -> tuple[float, float, float, float]:
    """Left, right, bottom and top of the picture, room for arrows and scale included."""
    sun, distance = 1e3 * mechanism.sun_radius, 1e3 * mechanism.centre_distance
    shaft = distance * np.exp(1j * theta)
    room = _MARGIN * distance
    # the ellipses reach as far as the sun's radius from their pivots
    return (
        min(-sun, shaft.real - sun) - room,
        max(sun, shaft.real + sun) + room,
        min(-sun, shaft.imag - sun) - 2.0 * room,
        max(sun, shaft.imag + sun) + room,
    )


def _draw_scale(
    ax: Axes, mechanism: EllipticalPlanetary, box: tuple[float, float, float, float]
) -> None:
    """A bar of a round length."""
    distance = 1e3 * mechanism.centre_distance
    power = 10.0 ** np.floor(np.log10(0.5 * distance))
    length = float(max(step for step in (1.0, 2.0, 5.0) if step * power <= 0.5 * distance) * power)
    x, y = box[0] + 0.04 * distance, box[2] + _MARGIN * distance
    ax.plot([x, x + length], [y, y], "-|", color=style.BLACK, lw=0.9, ms=6, mew=0.9)
    ax.annotate(
        f"{length:g} mm", (x + length, y), (5, 0), textcoords="offset points", va="center",
        fontsize=style.SMALL_SIZE,
    )  # fmt: skip
