"""Two bodies whose outlines touch anywhere, drawn to scale in any pose."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from escapement.base import validate
from escapement.base.spoken import drawn_unit
from escapement.mechanisms.escape_wheel import EscapeWheel
from escapement.mechanisms.two_bodies import TwoBodies
from escapement.outlines.bodies import Body, arc
from escapement.outlines.touching import PLATE, bodies, verge_angle
from escapement.plots import drawing, style

_LOOKS: dict[str, dict[str, Any]] = {
    "plate": {"facecolor": "#f2f2f2", "edgecolor": style.GREY, "linewidth": 0.6, "zorder": 1.0},
    "driver": {"facecolor": "#9cc7e8", "linewidth": 0.8, "zorder": 2.0, "label": "driver"},
    "follower": {"facecolor": "#f6d9a8", "linewidth": 0.8, "zorder": 2.1, "label": "follower"},
    "shaft": {"facecolor": "white", "linewidth": 0.8, "zorder": 3.0},
}
_MARGIN = 0.12  # room around the bodies, as a share of the distance of the axes


@drawing.plot_mechanism.register
def plot_touching(
    mechanism: TwoBodies,
    theta: float = 0.0,
    ax: Axes | None = None,
    *,
    follower_angle: float | None = None,
) -> Axes:
    """Driver and follower to scale, their axes on a horizontal line.

    Parameters
    ----------
    mechanism : Runaway, Deadbeat, Recoil or Outlines
        What to draw.
    theta : float
        Driver angle [rad], counterclockwise.
    ax : Axes, optional
        Where to draw; the driver's axis is its origin. Default: a new figure.
    follower_angle : float, optional
        Follower angle [rad], counterclockwise. Default: that at which the escape wheel pushes a
        pallet; of outlines of one's own that at the start of a motion.

    Returns
    -------
    Axes
        Artists carry ids: "driver", "follower", "plate" and "shaft".
    """
    angle = validate.number("theta", theta, "give the driver angle in rad")
    phi = verge_angle(mechanism, angle) if follower_angle is None else follower_angle
    apart, size = mechanism.axes_distance, _reach(mechanism)
    room = _MARGIN * apart
    # a verge only swings, and nothing of it is far behind its axis
    beyond = 2.0 * PLATE if isinstance(mechanism, EscapeWheel) else size[1]
    left, right = min(-size[0], apart - size[1]), max(size[0], apart + beyond)
    high = max(size)
    ax = drawing.dress_scene(ax, (left - room, right + room, -high - room, high + room))
    drawing.bodies(ax, bodies(mechanism, angle, phi), _LOOKS, edgecolor=style.BLACK)
    drawing.arrow(ax, arc(0.45 * size[0], 0.4 + np.pi, 1.4 + np.pi, 31))
    unit, name = drawn_unit()
    length = style.round_below(0.5 * mechanism.crank_radius / unit)
    point = (left, -high - 0.5 * room)
    drawing.length(ax, point, length * unit / mechanism.crank_radius, f"{length:g} {name}")
    return ax


def _reach(mechanism: TwoBodies) -> tuple[float, float]:
    """How far driver and follower reach from their axes."""
    shown: list[Any] = bodies(mechanism, 0.0, 0.0)
    axis, found = mechanism.axes_distance, {}
    for name, centre in (("driver", 0.0), ("follower", axis)):
        body: Body = next(one for one in shown if one.name == name)
        found[name] = max(float(np.abs(edge.drawn() - centre).max()) for edge in body.edges)
    return found["driver"], found["follower"]
