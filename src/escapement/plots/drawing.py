"""Drawings of mechanisms to scale; a mechanism without bodies is drawn as its transmission.

The artists of all drawings are here: bodies, arrows for the direction of rotation, a scale bar.
"""

from collections.abc import Iterable, Mapping
from functools import singledispatch
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Patch, PathPatch
from matplotlib.path import Path

from escapement.mechanisms import Tabulated
from escapement.mechanisms.protocol import FloatArray, checked
from escapement.mechanisms.slotted import transmission
from escapement.outlines.bodies import Body, Disc
from escapement.outlines.curves import ComplexArray
from escapement.plots import style

Box = tuple[float, float, float, float]
"""Left, right, bottom and top of a picture."""
_SAMPLES = 721
_MOST_MARKS = 4000


@singledispatch
def plot_mechanism(mechanism: Any, theta: float = 0.0, ax: Axes | None = None) -> Axes:
    """Mechanism to scale, in any position; for one without bodies its transmission.

    The function for each class of mechanism is registered with `plot_mechanism.register`,
    and its docstring names what it draws.

    Parameters
    ----------
    mechanism : Mechanism
        What to draw.
    theta : float
        Driver angle [rad], of any size; it plays no part for a transmission.
    ax : Axes, optional
        Where to draw. Default: a new figure.

    Raises
    ------
    InvalidValue
        If the argument is not a mechanism, or an angle is not finite.
    """
    if isinstance(checked(mechanism), Tabulated):
        return plot_table(mechanism, ax)
    angles = np.linspace(mechanism.breaks[0], mechanism.breaks[-1], _SAMPLES)
    return _draw_transmission(ax, angles, transmission(mechanism.path, angles).g)


def plot_table(mechanism: Tabulated, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Transmission over a cell, with twice its standard deviation, and the rows.

    Parameters
    ----------
    mechanism : Tabulated
        What to show.
    ax : Axes, optional
        Where to draw. Rows are ticks at the foot, at the driver angles they have
        within the cell. Default: a new figure.
    legend : bool
        Whether to draw one.
    """
    theta = np.linspace(*mechanism.breaks, _SAMPLES)
    g, doubt = mechanism.transmission(theta).g, 2.0 * mechanism.deviation(theta).g
    ax = _draw_transmission(ax, theta, g)
    if mechanism.noise > 0.0:
        band = {"label": "± 2 standard deviations", **style.SHADE}
        ax.fill_between(np.degrees(theta), g - doubt, g + doubt, **band)
    first = mechanism.breaks[0]
    rows = np.array(mechanism.theta)[:_MOST_MARKS]
    angles = np.degrees(first + np.mod(rows - first, mechanism.cell_angle))
    low = float(min((g - doubt).min(), 0.0)) - 0.06 * float(np.ptp(g))
    ax.plot(angles, np.full(angles.size, low), "|", color=style.GREY, ms=5, mew=0.5, label="rows")
    if legend:
        style.legend_above(ax, 3)
    return ax


def _draw_transmission(ax: Axes | None, theta: FloatArray, g: FloatArray) -> Axes:
    ax, degrees = ax or style.new_axes(style.TWO_COLUMN, 3.2), np.degrees(theta)
    ax.axhline(0.0, **style.ZERO)
    ax.plot(degrees, g, color=style.BLUE, lw=1.4, label="transmission")
    ax.set(xlabel="Driver angle (°)", ylabel="Transmission g", xlim=(degrees[0], degrees[-1]))
    return ax


def bodies(
    ax: Axes, shown: Iterable[Body | Disc], looks: Mapping[str, Mapping[str, Any]], **look: Any
) -> dict[str, Patch]:
    """Bodies as patches whose ids are their names.

    Parameters
    ----------
    shown : iterable of Body or Disc
        What to draw; bodies without a look are skipped.
    looks : mapping
        Properties of the patch by the body's name, for "pin-k" by "pin".
    **look
        Properties of all that do not have their own.
    """
    drawn: dict[str, Patch] = {}
    for body in shown:
        if (chosen := looks.get(body.name.rstrip("-0123456789"))) is None:
            continue
        given: dict[str, Any] = {"gid": body.name, **look, **chosen}
        if isinstance(body, Disc):
            patch: Patch = Circle((body.centre.real, body.centre.imag), body.radius, **given)
        else:
            curves = (Path(rows(edge.drawn()), closed=True) for edge in body.edges)
            patch = PathPatch(Path.make_compound_path(*curves), **given)
        # limits are set for the whole scene, so the axes need not find those of the patch
        ax.add_artist(patch)
        drawn[body.name] = patch
    return drawn


def dress_scene(ax: Axes | None, box: Box) -> Axes:
    """Axes to scale without frame, of left, right, bottom and top; new ones by default."""
    left, right, bottom, top = box
    if ax is None:
        ax = style.new_axes(style.ONE_COLUMN, style.ONE_COLUMN * (top - bottom) / (right - left))
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    ax.set_axis_off()
    return ax


def curve(ax: Axes, points: ComplexArray, *form: str, **look: Any) -> None:
    """A line through points of the plane, in Matplotlib's words."""
    ax.plot(points.real, points.imag, *form, **look)


def arrow(ax: Axes, arc: ComplexArray) -> None:
    """An arrow along an arc, which shows the direction of rotation."""
    arrow = FancyArrowPatch(path=Path(rows(arc)), arrowstyle="-|>", mutation_scale=8)
    ax.add_patch(arrow)
    arrow.set(color=style.BLACK, linewidth=0.8, zorder=5, fill=True)


def length(ax: Axes, point: style.Point, size: float, text: str) -> None:
    """A bar of a length, with its name to the right."""
    x, y = point
    ax.plot([x, x + size], [y, y], "-|", color=style.BLACK, lw=0.9, ms=6, mew=0.9)
    style.annotate(ax, text, (x + size, y), (5.0, 0.0), "left")


def rows(points: ComplexArray) -> FloatArray:
    """Complex numbers as rows of x and y."""
    return np.column_stack([points.real, points.imag])
