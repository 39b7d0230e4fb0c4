"""Geneva drives drawn to scale, in any position."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.base import validate
from escapement.base.spoken import on_drawing
from escapement.mechanisms import Geneva
from escapement.outlines.bodies import Disc, arc
from escapement.outlines.geneva import GenevaOutline
from escapement.plots import drawing, style

# The crank disc lies behind the follower, the locking disc in its plane, pins lie in front.
_LOOKS: dict[str, dict[str, Any]] = {
    "crank-disc": {"facecolor": "#dcebf7", "zorder": 1},
    "follower": {"facecolor": "#f6d9a8", "zorder": 2, "joinstyle": "round"},
    "follower-shaft": {"facecolor": "white", "zorder": 2.1},
    "locking-disc": {"facecolor": "#9cc7e8", "zorder": 2.5},
    "driver-shaft": {"facecolor": "white", "zorder": 2.6},
    "roller": {"facecolor": "#dcebf7", "edgecolor": "#00466f", "zorder": 2.9},
    "pin": {"facecolor": "#00466f", "edgecolor": "#00466f", "linewidth": 0, "zorder": 3},
}
_BROKEN = {"fill": False, "ec": style.GREY, "lw": 0.6, "ls": (0, (4, 2.5)), "zorder": 2.2}
_CHAIN = (0, (9, 2, 2, 2))
_MARGIN = 0.30  # space for arrows, in crank radii
_LARGE = 5.0  # for a larger follower the margin grows, and lines get thinner
_CONTINUOUS = (3, 4, 6)


@drawing.plot_mechanism.register
def plot_geneva(
    mechanism: Geneva, theta: float = 0.0, ax: Axes | None = None, *, exaggerate: float = 1.0,
    follower_angle: float | None = None,
) -> Axes:  # fmt: skip
    """Geneva drive to scale, driver on the right, with the errors of its parts.

    Parameters
    ----------
    mechanism : Geneva
        What to draw. Pins without a `pin_radius`, and their slots, are drawn with a symbolic
        width.
    theta : float
        Driver angle from dead centre of the reference pin [rad], of any size;
        in a dwell the follower is locked.
    ax : Axes, optional
        Where to draw; its limits are set in crank radii, follower axis at the
        origin. Default: a new figure.
    exaggerate : float
        Factor on the errors of the parts, >= 0. Unless it is 1, broken lines show
        the perfect wheel and its pins.
    follower_angle : float, optional
        Angle of the follower [rad], as `State.phi` of a motion with clearance gives it.
        Default: the angle at which slots without clearance would hold it.

    Returns
    -------
    Axes
        Artists carry ids: "follower", "crank-disc", "locking-disc", and
        "pin-k", "roller-k" and "slot-k" (its centre line) with k counted from 0.

    Raises
    ------
    InvalidValue
        For more than 200 slots, an angle that is not finite, or errors with which a pin would
        miss its slot.

    Notes
    -----
    The picture is that of Meyer (1973), figures 12-14: with the follower's axis
    at the origin a pin stands at c - exp(-i theta), for an internal wheel at
    c + exp(i theta).
    """
    angle = validate.number("theta", theta, "give the driver angle in rad")
    style.check_drawn("slots", mechanism.slots)
    outline = GenevaOutline(mechanism, exaggerate)
    angle_of = outline.mechanism.follower_angle
    phi = float(angle_of(angle)) if follower_angle is None else follower_angle
    phi = validate.number("follower_angle", phi, "give it in rad, or leave it out")
    ax = _draw(ax, outline, angle, phi)
    if exaggerate != 1.0:
        ideal = GenevaOutline(outline.perfect).bodies(angle)
        shown = dict.fromkeys(("follower", "pin"), _BROKEN | {"zorder": 3.2})
        for patch in drawing.bodies(ax, ideal, shown).values():
            patch.set_gid("perfect")
    _draw_scale(ax, outline)
    return ax


def plot_configurations(theta: float = 0.0) -> Figure:
    """The three continuous Geneva drives side by side, equally wide, with their parts named.

    Parameters
    ----------
    theta : float
        Driver angle from dead centre [rad].

    Source: Meyer (1973), eq. 1-3 and figures 12-14.
    """
    angle = validate.number("theta", theta, "give the driver angle in rad")
    drives = [GenevaOutline(Geneva(slots=n)) for n in _CONTINUOUS]
    boxes = [_extent(drive) for drive in drives]
    # heights are shares of the widths, and have room for the highest drive and its bar
    top = max((box[3] + 0.05) / (box[1] - box[0]) for box in boxes)
    bottom = -top - 0.06
    wide = style.TWO_COLUMN
    figure = style.new_figure(wide, wide / 3.0 * (top - bottom) + 0.3)
    for ax, outline, (left, right, _, _) in zip(figure.subplots(1, 3), drives, boxes, strict=True):
        _draw(ax, outline, angle, float(outline.mechanism.follower_angle(angle)))
        width, wheel = right - left, outline.mechanism
        ax.set_ylim(bottom * width, top * width)
        ax.set_title(f"{wheel.slots} slots, {wheel.pins} pins", fontsize=style.LABEL_SIZE)
        _name_parts(ax, outline, angle)
        drawing.length(ax, (left + 0.15, (bottom + 0.03) * width), 1.0, "crank radius")
    return figure


def _name_parts(ax: Axes, outline: GenevaOutline, theta: float) -> None:
    """Names of driver, follower, the highest pin, and a slot on the lower left."""
    wheel, rim = outline.mechanism, outline.rim_radius
    # the disc with the highest centre is a pin
    centres = [body.centre for body in outline.bodies(theta) if isinstance(body, Disc)]
    phi = wheel.follower_angle(theta) + wheel.follower_step * np.arange(wheel.slots)
    slot = min(np.exp(1j * phi), key=lambda along: abs(along - np.exp(-2.4j)))
    aside = 13j * slot
    names = {
        "driver": (wheel.centre_distance + 0.3 - 0.4j, (0.0, 0.0)),
        "follower": (rim * np.exp(2.2j), (-8.0, 11.0)),
        "pin": (max(centres, key=lambda centre: centre.imag), (0.0, -11.0)),
        "slot": ((0.6 * outline.slot_end + 0.4 * rim) * slot, (aside.real, aside.imag)),
    }
    for name, (point, offset) in names.items():
        style.annotate(ax, name, (point.real, point.imag), offset)


def _draw(ax: Axes | None, outline: GenevaOutline, theta: float, phi: float) -> Axes:
    ax = drawing.dress_scene(ax, _extent(outline))
    draw_bodies(ax, outline, theta, phi)
    # arrows beside the outline tell which way they turn
    room = 0.4 * _MARGIN * _size(outline)
    driver = arc(outline.crank_disc_radius + room, 0.4, -0.4, 21)
    if outline.mechanism.internal:
        driver = arc(0.25, 0.7, 5.0, 41)
    drawing.arrow(ax, arc(outline.follower_radius + room, np.pi - 0.3, np.pi + 0.3, 21))
    drawing.arrow(ax, outline.centre + driver)
    return ax


def draw_bodies(ax: Axes, outline: GenevaOutline, theta: float, phi: float) -> None:
    """Bodies and thin lines into axes whose limits are set, the follower at its angle [rad]."""
    width = 0.9 / _size(outline)
    bodies = outline.bodies(theta, phi)
    drawn = drawing.bodies(ax, bodies, _LOOKS, edgecolor=style.BLACK, linewidth=width)
    # the part of the crank disc behind the follower is a broken line
    hidden = drawing.bodies(ax, bodies, {"crank-disc": _BROKEN})["crank-disc"]
    hidden.set(gid=None, clip_path=drawn["follower"])
    _draw_lines(ax, outline, phi)


def _extent(outline: GenevaOutline) -> drawing.Box:
    """Left, right, bottom and top of the picture, room for arrows and scale included."""
    c = outline.centre
    half = max(outline.follower_radius, outline.crank_disc_radius)
    right = max(outline.follower_radius, c + outline.crank_disc_radius)
    room = _MARGIN * _size(outline)
    return -outline.follower_radius - room, right + room, -half - 1.7 * room, half + room / 3.0


def _size(outline: GenevaOutline) -> float:
    return max(1.0, outline.follower_radius / _LARGE)


def _draw_lines(ax: Axes, outline: GenevaOutline, phi: float) -> None:
    """Line of centres, axes, pin circle and the slots' centre lines."""
    mechanism, c = outline.mechanism, outline.centre
    thin: dict[str, Any] = {"lw": 0.5 / _size(outline), "linestyle": _CHAIN, "zorder": 2.8}
    left, right, _, _ = _extent(outline)
    lines = {"line-of-centres": np.array([left + 0.15, right - 0.15])}
    lines["crank-circle"] = c + arc(1.0, 0.0, 2.0 * np.pi)
    ends = np.array([0.3 * outline.slot_end, outline.rim_radius + 0.1])
    if mechanism.internal:
        ends = np.array([outline.rim_radius - 0.1, outline.follower_radius - 0.05])
    for k, (angle, offset) in enumerate(
        zip(outline.slot_angles(), outline.slot_offsets(), strict=True)
    ):
        lines[f"slot-{k}"] = (ends + 1j * offset) * np.exp(1j * (phi + angle))
    for name, line in lines.items():
        drawing.curve(ax, line, color=style.GREY, gid=name, **thin)
    ax.plot([0, c], [0, 0], "+", color=style.BLACK, ms=6, mew=0.8, zorder=4, gid="axes")


def _draw_scale(ax: Axes, outline: GenevaOutline) -> None:
    """A bar one crank radius long, with the radius where it is known."""
    (left, _, bottom, _), radius = _extent(outline), outline.mechanism.crank_radius
    point = (left + 0.15, bottom + 0.5 * _MARGIN * _size(outline))
    text = "crank radius" if radius is None else f"crank radius {on_drawing(radius)}"
    drawing.length(ax, point, 1.0, text)
