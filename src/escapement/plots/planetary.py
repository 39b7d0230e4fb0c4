"""The planetary drive with elliptical gears drawn to scale, in any position."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from escapement import validate
from escapement.mechanisms import EllipticalPlanetary
from escapement.outlines.elliptical import EllipticalOutline
from escapement.plots import style
from escapement.plots.bodies import draw_arrow, draw_bodies, draw_length, dress_scene
from escapement.plots.tabulated import plot_mechanism

_SPUR: dict[str, Any] = {"facecolor": "#e4e4e4", "linewidth": 0.8, "zorder": 1}
_LOOKS: dict[str, dict[str, Any]] = {
    "sun": _SPUR,
    "planet": _SPUR,
    "driven": {"facecolor": "#f6d9a8", "linewidth": 0.9, "zorder": 2.0, "alpha": 0.85},
    "driving": {"facecolor": "#9cc7e8", "linewidth": 0.9, "zorder": 2.1, "alpha": 0.85},
}
# broken lines show what the ellipses hide of the spur gears
_BROKEN: dict[str, Any] = {"fill": False, "ec": style.GREY, "ls": (0, (4, 2.5)), "zorder": 2.4}
_HIDDEN = {"sun": _BROKEN, "planet": _BROKEN}
_MARGIN = 0.12  # the room around the gears is this share of the centre distance


@plot_mechanism.register
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
        For an angle that is not finite.
    """
    angle = validate.number("theta", theta, "give the driver angle in rad")
    box = extent(mechanism, angle)
    ax = dress_scene(ax, box)
    draw_planetary(ax, mechanism, angle, angle)
    _draw_senses(ax, mechanism, angle)
    _draw_scale(ax, mechanism, box)
    return ax


def draw_planetary(ax: Axes, mechanism: EllipticalPlanetary, theta: float, carrier: float) -> None:
    """Gears and line of centres in millimetres; the carrier points along `carrier` [rad]."""
    outline = EllipticalOutline(mechanism)
    bodies = outline.bodies(theta, carrier)
    draw_bodies(ax, bodies, _LOOKS, edgecolor=style.BLACK)
    draw_bodies(ax, bodies, _HIDDEN, linewidth=0.6)
    for ellipse in bodies[2:]:
        # the long axis shows how an ellipse is turned
        ends = ellipse.edges[0][[0, ellipse.edges[0].size // 2]]
        ax.plot(ends.real, ends.imag, color=style.GREY, lw=0.6, ls=(0, (6, 2, 1, 2)), zorder=2.3)
    _, shaft, contact = np.array(outline.line_of_centres(theta)) * np.exp(1j * carrier)
    ax.plot(
        [0, shaft.real], [0, shaft.imag], "o-", color=style.BLACK, lw=1.6, ms=4, mfc="white",
        zorder=3, gid="carrier",
    )  # fmt: skip
    ax.plot(contact.real, contact.imag, "o", color=style.VERMILLION, ms=4, zorder=4, gid="contact")


def _draw_senses(ax: Axes, mechanism: EllipticalPlanetary, theta: float) -> None:
    """Letters at the pivots, and arrows for carrier and output."""
    distance = 1e3 * mechanism.centre_distance
    shaft = distance * np.exp(1j * theta)
    # letters stand to the right of the carrier, arrows to its left and behind it
    aside = 10.0 * np.exp(1j * (theta - 0.5 * np.pi))
    style.annotate(ax, "A", (0.0, 0.0), (aside.real, aside.imag))
    style.annotate(ax, "C", (shaft.real, shaft.imag), (aside.real, aside.imag))
    # the carrier turns counter-clockwise and the output the other way
    for arc in (
        distance * np.exp(1j * (theta + np.linspace(0.1, 0.4, 21))),
        0.42e3 * mechanism.sun_radius * np.exp(1j * (theta + np.pi - np.linspace(-0.9, 0.9, 31))),
    ):
        draw_arrow(ax, arc)


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
    place = (box[0] + 0.04 * distance, box[2] + _MARGIN * distance)
    draw_length(ax, place, length, f"{length:g} mm")
