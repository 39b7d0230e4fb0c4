"""The planetary drive with elliptical gears drawn to scale, in any position."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from escapement.base import validate
from escapement.base.spoken import drawn_unit
from escapement.mechanisms import EllipticalPlanetary
from escapement.outlines.bodies import arc
from escapement.outlines.gears import EllipticalOutline
from escapement.plots import drawing, style

_SPUR: dict[str, Any] = {"facecolor": "#f2f2f2", "linewidth": 0.8, "zorder": 1}
_ELLIPSE: dict[str, Any] = {"linewidth": 0.9, "alpha": 0.85}
_LOOKS: dict[str, dict[str, Any]] = {
    "sun": _SPUR | {"label": "sun, fixed"},
    "planet": _SPUR,
    "driven": _ELLIPSE | {"facecolor": "#f6d9a8", "zorder": 2.0, "label": "output ellipse"},
    "driving": _ELLIPSE | {"facecolor": "#9cc7e8", "zorder": 2.1, "label": "driving ellipse"},
}
# broken lines show the parts of the spur gears behind the ellipses
_BROKEN: dict[str, Any] = {"fill": False, "ec": style.GREY, "ls": (0, (4, 2.5)), "zorder": 2.4}
_HIDDEN = {"sun": _BROKEN, "planet": _BROKEN | {"label": "planet"}}
_LETTERS = "A: axis of carrier and output\nC: shaft of planet and driving ellipse"
_WORDS = 0.95  # height of the legend [in]
_MARGIN = 0.12  # the room around the gears is this share of the centre distance


@drawing.plot_mechanism.register
def plot_planetary(
    mechanism: EllipticalPlanetary,
    theta: float = 0.0,
    ax: Axes | None = None,
    *,
    legend: bool = True,
) -> Axes:
    """Planetary drive with elliptical gears to scale; the axes count millimetres.

    Parameters
    ----------
    mechanism : EllipticalPlanetary
        What to draw: pitch curves, without teeth.
    theta : float
        Driver angle from greatest output speed [rad], of any size.
    ax : Axes, optional
        Where to draw; the carrier's axis is its origin. Default: a new figure.
    legend : bool
        Whether to draw one.

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
    box, distance = extent(mechanism, angle), 1e3 * mechanism.centre_distance
    alone, ax = ax is None, drawing.dress_scene(ax, box)
    draw_planetary(ax, mechanism, angle, angle)
    # letters are to the right of the carrier, arrows to its left and behind it
    along, behind = np.exp(1j * angle), angle + np.pi
    aside = -10j * along
    for letter, point in (("A", 0.0 * along), ("C", distance * along)):
        style.annotate(ax, letter, (point.real, point.imag), (aside.real, aside.imag))
    # the carrier turns counter-clockwise and the output the other way
    drawing.arrow(ax, arc(distance, angle + 0.1, angle + 0.4, 21))
    drawing.arrow(ax, arc(0.42e3 * mechanism.sun_radius, behind + 0.9, behind - 0.9, 31))
    # the bar has the greatest round length below half the centre distance
    size, unit = drawn_unit()
    length = style.round_below(0.5 * mechanism.centre_distance / size)
    point = (box[0] + 0.04 * distance, box[2] + _MARGIN * distance)
    drawing.length(ax, point, 1e3 * size * length, f"{length:g} {unit}")
    if legend:
        style.legend_above(ax, 2, _LETTERS)
    if alone and legend:
        figure: Any = ax.figure
        figure.set_figheight(figure.get_figheight() + _WORDS)
    return ax


def draw_planetary(ax: Axes, mechanism: EllipticalPlanetary, theta: float, carrier: float) -> None:
    """Gears and line of centres in millimetres; the carrier points along `carrier` [rad]."""
    outline = EllipticalOutline(mechanism)
    bodies = outline.bodies(theta, carrier)
    drawing.bodies(ax, bodies, _LOOKS, edgecolor=style.BLACK)
    drawing.bodies(ax, bodies, _HIDDEN, linewidth=0.6)
    for ellipse in bodies[2:]:
        # the long axis shows how an ellipse is turned
        corners = ellipse.edges[0].corners
        ends = corners[[0, corners.size // 2]]
        drawing.curve(ax, ends, color=style.GREY, lw=0.6, ls=(0, (6, 2, 1, 2)), zorder=2.3)
    _, shaft, contact = np.array(outline.line_of_centres(theta)) * np.exp(1j * carrier)
    look: dict[str, Any] = {"color": style.BLACK, "lw": 1.6, "mfc": "white", "zorder": 3}
    drawing.curve(ax, np.array([0.0, shaft]), "o-", ms=4, gid="carrier", label="carrier", **look)
    look = {"ms": 4, "zorder": 4, "gid": "contact", "label": "point of contact"}
    drawing.curve(ax, contact, "o", color=style.VERMILLION, **look)


def extent(mechanism: EllipticalPlanetary, theta: float) -> drawing.Box:
    """Left, right, bottom and top of the picture, room for arrows and scale included."""
    sun, _, _, driving = EllipticalOutline(mechanism).bodies(theta)
    room = _MARGIN * 1e3 * mechanism.centre_distance
    # the other two gears are within these
    ends = np.append(driving.edges[0].drawn(), sun.radius * np.array([1.0, 1j, -1.0, -1j]))
    (left, right), (bottom, top) = ((part.min(), part.max()) for part in (ends.real, ends.imag))
    return left - room, right + room, bottom - 2.0 * room, top + room
