"""Geneva drives drawn to scale, in any position."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, PathPatch, Polygon
from matplotlib.path import Path

from escapement import validate
from escapement.mechanisms import Geneva
from escapement.outlines.geneva import Wheels, locking_disc, pose
from escapement.plots import style

_PLATE, _DISC, _PIN = "#dcebf7", "#9cc7e8", "#00466f"
_FOLLOWER = "#f6d9a8"
_CHAIN = (0, (9, 2, 2, 2))
_MARGIN = 0.30  # room for arrows, in crank radii
_LARGE = 5.0  # follower radius beyond which the room grows and lines get thinner
_CONTINUOUS = (3, 4, 6)


def plot_mechanism(mechanism: Geneva, theta: float = 0.0, ax: Axes | None = None) -> Axes:
    """Geneva drive to scale, driver on the right.

    Parameters
    ----------
    mechanism : Geneva
        What to draw. Pin and slot widths are the drawing's choice: the model
        has none.
    theta : float
        Driver angle from dead centre of the reference pin [rad], of any size;
        in a dwell the follower stands locked.
    ax : Axes, optional
        Where to draw; its limits are set in crank radii, follower axis at the
        origin. Default: a new figure.

    Returns
    -------
    Axes
        Artists carry ids: "follower", "crank-disc", "locking-disc", and
        "pin-k" and "slot-k" (its centre line) with k counted from 0.

    Raises
    ------
    InvalidValue
        For any but a Geneva drive, with the function that draws it, for more than 200 slots,
        or an angle that is not finite.

    Notes
    -----
    The picture is that of Meyer (1973), figures 12-14: with the follower's axis
    at the origin a pin stands at c - exp(-i theta), for an internal wheel at
    c + exp(i theta).
    """
    if not isinstance(mechanism, Geneva):
        remedy = (
            "give Geneva(slots=4), or draw a planetary drive with plot_planetary, a gear-driven "
            "wheel with plot_gear_driven, a table with plot_table"
        )
        raise validate.fail("mechanism", "a Geneva drive", mechanism, remedy)
    angle = validate.number("theta", theta, "give the driver angle in rad")
    style.check_drawn("slots", mechanism.slots)
    wheels = Wheels(mechanism)
    box = _extent(wheels)
    if ax is None:
        height = style.ONE_COLUMN * (box[3] - box[2]) / (box[1] - box[0])
        ax = style.new_axes(style.ONE_COLUMN, height)
    _draw(ax, wheels, angle)
    _draw_scale(ax, wheels)
    return ax


def plot_configurations(theta: float = 0.0) -> Figure:
    """The three continuous Geneva drives side by side, crank radii equal.

    Parameters
    ----------
    theta : float
        Driver angle from dead centre [rad].

    Source: Meyer (1973), eq. 1-3 and figures 12-14.
    """
    angle = validate.number("theta", theta, "give the driver angle in rad")
    drives = [Wheels(Geneva(slots=n)) for n in _CONTINUOUS]
    boxes = [_extent(drive) for drive in drives]
    widths = [box[1] - box[0] for box in boxes]
    half = max(box[3] for box in boxes) + 0.05
    height = style.TWO_COLUMN * 2.0 * half / sum(widths) + 0.3
    figure = style.new_figure(style.TWO_COLUMN, height)
    axes = figure.subplots(1, 3, width_ratios=widths)
    for ax, wheels in zip(axes, drives, strict=True):
        _draw(ax, wheels, angle)
        ax.set_ylim(-half, half)
        title = f"{wheels.mechanism.slots} slots, {wheels.mechanism.pins} pins"
        ax.set_title(title, fontsize=style.LABEL_SIZE)
    _draw_scale(axes[0], drives[0])
    return figure


def _draw(ax: Axes, wheels: Wheels, theta: float) -> None:
    phi = pose(wheels.mechanism, theta)
    follower = _draw_follower(ax, wheels, phi)
    _draw_driver(ax, wheels, theta, follower)
    _draw_lines(ax, wheels, phi)
    _draw_senses(ax, wheels)
    box = _extent(wheels)
    ax.set(xlim=box[:2], ylim=box[2:], aspect="equal")
    ax.set_axis_off()


def _extent(wheels: Wheels) -> tuple[float, float, float, float]:
    """Left, right, bottom and top of the picture, room for arrows and scale included."""
    c = wheels.mechanism.centre_distance
    half = max(wheels.body, wheels.plate)
    right = max(wheels.body, c + wheels.plate)
    room = _MARGIN * _size(wheels)
    return -wheels.body - room, right + room, -half - 1.7 * room, half + room / 3.0


def _size(wheels: Wheels) -> float:
    return max(1.0, wheels.body / _LARGE)


def _draw_follower(ax: Axes, wheels: Wheels, phi: float) -> PathPatch:
    rings = [wheels.outline * np.exp(1j * phi)]
    if wheels.mechanism.internal:
        rings.append(wheels.body * np.exp(-1j * np.linspace(0.0, 2.0 * np.pi, 361)))
    path = Path.make_compound_path(*(Path(_points(ring), closed=True) for ring in rings))
    edge: dict[str, Any] = {"edgecolor": style.BLACK, "linewidth": 0.9 / _size(wheels)}
    follower = PathPatch(
        path, facecolor=_FOLLOWER, zorder=2, joinstyle="round", gid="follower", **edge
    )
    ax.add_patch(follower)
    if not wheels.mechanism.internal:
        shaft = min(0.12, 0.5 * (wheels.slot_end - wheels.half_slot))
        ax.add_patch(Circle((0, 0), shaft, facecolor="white", zorder=2.1, **edge))
    return follower


def _draw_driver(ax: Axes, wheels: Wheels, theta: float, follower: PathPatch) -> None:
    """Crank disc behind the follower, locking disc in its plane, pins in front."""
    mechanism, c = wheels.mechanism, wheels.mechanism.centre_distance
    edge: dict[str, Any] = {"edgecolor": style.BLACK, "linewidth": 0.9 / _size(wheels)}
    ax.add_patch(Circle((c, 0), wheels.plate, facecolor=_PLATE, zorder=1, gid="crank-disc", **edge))
    hidden = Circle((c, 0), wheels.plate, fill=False, ec=style.GREY, lw=0.6, ls=(0, (4, 2.5)))
    ax.add_patch(hidden).set(zorder=2.2, clip_path=follower)
    if wheels.locks:
        outline = c + locking_disc(wheels) * np.exp(1j * wheels.side * theta)
        ax.add_patch(
            Polygon(_points(outline), facecolor=_DISC, zorder=2.5, gid="locking-disc", **edge)
        )
    shaft = 0.12 if mechanism.internal else min(0.14, 0.5 * (c - wheels.rim))
    ax.add_patch(Circle((c, 0), shaft, facecolor="white", zorder=2.6, **edge))
    for k in range(mechanism.pins or 1):
        turn = np.exp(1j * wheels.side * (theta - k * mechanism.cell_angle))
        pin = c + wheels.side * turn
        ax.add_patch(
            Circle((pin.real, pin.imag), wheels.pin, color=_PIN, lw=0, zorder=3, gid=f"pin-{k}")
        )


def _draw_lines(ax: Axes, wheels: Wheels, phi: float) -> None:
    """Line of centres, axes, pin circle and the slots' centre lines."""
    mechanism, c = wheels.mechanism, wheels.mechanism.centre_distance
    thin: dict[str, Any] = {"lw": 0.5 / _size(wheels), "linestyle": _CHAIN, "zorder": 2.8}
    left, right, _, _ = _extent(wheels)
    across = [left + 0.15, right - 0.15]
    ax.plot(across, [0, 0], color=style.GREY, gid="line-of-centres", **thin)
    ax.add_patch(Circle((c, 0), 1.0, fill=False, edgecolor=style.GREY, **thin))
    for k in range(mechanism.slots):
        ray = np.exp(1j * (phi + k * mechanism.follower_step))
        ends = (0.3 * wheels.slot_end, wheels.rim + 0.1)
        if mechanism.internal:
            ends = (wheels.rim - 0.1, wheels.body - 0.05)
        line = np.array(ends) * ray
        ax.plot(line.real, line.imag, color=style.GREY, gid=f"slot-{k}", **thin)
    ax.plot([0, c], [0, 0], "+", color=style.BLACK, ms=6, mew=0.8, zorder=4, gid="axes")


def _draw_senses(ax: Axes, wheels: Wheels) -> None:
    """Arrows beside the wheels: which way they turn."""
    c = wheels.mechanism.centre_distance
    room = 0.4 * _MARGIN * _size(wheels)
    follower = (wheels.body + room) * np.exp(1j * np.linspace(np.pi - 0.3, np.pi + 0.3, 21))
    if wheels.mechanism.internal:
        driver = c + 0.25 * np.exp(1j * np.linspace(0.7, 5.0, 41))
    else:
        driver = c + (wheels.plate + room) * np.exp(1j * np.linspace(0.4, -0.4, 21))
    for arc in (follower, driver):
        arrow = FancyArrowPatch(path=Path(_points(arc)), arrowstyle="-|>", mutation_scale=8)
        ax.add_patch(arrow)
        arrow.set(color=style.BLACK, linewidth=0.8, zorder=5, fill=True)


def _draw_scale(ax: Axes, wheels: Wheels) -> None:
    """A bar one crank radius long, with the radius where it is known."""
    left, _, bottom, _ = _extent(wheels)
    x, y = left + 0.15, bottom + 0.5 * _MARGIN * _size(wheels)
    radius = wheels.mechanism.crank_radius
    text = "crank radius" if radius is None else f"crank radius {1e3 * radius:.4g} mm"
    ax.plot([x, x + 1.0], [y, y], "-|", color=style.BLACK, lw=0.9, ms=6, mew=0.9)
    ax.annotate(
        text, (x + 1.0, y), (5, 0), textcoords="offset points", va="center",
        fontsize=style.SMALL_SIZE,
    )  # fmt: skip


def _points(values: np.ndarray) -> np.ndarray:
    """Complex numbers as rows of x and y."""
    return np.column_stack([values.real, values.imag])
