"""Artists of drawings to scale: bodies, arrows that tell a sense, and a bar of known length."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Patch, PathPatch
from matplotlib.path import Path

from escapement.model import FloatArray
from escapement.outlines import Body, ComplexArray, Disc
from escapement.plots import style


def draw_bodies(
    ax: Axes, bodies: Iterable[Body | Disc], looks: Mapping[str, Mapping[str, Any]], **look: Any
) -> dict[str, Patch]:
    """Bodies as patches whose ids are their names.

    Parameters
    ----------
    bodies : iterable of Body or Disc
        What to draw; bodies without a look are passed over.
    looks : mapping
        Properties of the patch by the body's name, for "pin-k" by "pin".
    **look
        Properties of all that do not have their own.
    """
    drawn: dict[str, Patch] = {}
    for body in bodies:
        own = looks.get(body.name.rstrip("-0123456789"))
        if own is None:
            continue
        given: dict[str, Any] = {"gid": body.name, **look, **own}
        if isinstance(body, Disc):
            patch: Patch = Circle((body.centre.real, body.centre.imag), body.radius, **given)
        else:
            curves = (Path(rows(edge), closed=True) for edge in body.edges)
            patch = PathPatch(Path.make_compound_path(*curves), **given)
        drawn[body.name] = ax.add_patch(patch)
    return drawn


def dress_scene(ax: Axes | None, box: tuple[float, float, float, float]) -> Axes:
    """Axes to scale without frame, of left, right, bottom and top; new ones by default."""
    left, right, bottom, top = box
    if ax is None:
        ax = style.new_axes(style.ONE_COLUMN, style.ONE_COLUMN * (top - bottom) / (right - left))
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    ax.set_axis_off()
    return ax


def draw_arrow(ax: Axes, arc: ComplexArray) -> None:
    """An arrow along an arc, which tells the sense in which something turns."""
    arrow = FancyArrowPatch(path=Path(rows(arc)), arrowstyle="-|>", mutation_scale=8)
    ax.add_patch(arrow)
    arrow.set(color=style.BLACK, linewidth=0.8, zorder=5, fill=True)


def draw_length(ax: Axes, place: tuple[float, float], length: float, text: str) -> None:
    """A bar of a length, with its name to the right."""
    x, y = place
    ax.plot([x, x + length], [y, y], "-|", color=style.BLACK, lw=0.9, ms=6, mew=0.9)
    ax.annotate(
        text, (x + length, y), (5, 0), textcoords="offset points", va="center",
        fontsize=style.SMALL_SIZE,
    )  # fmt: skip


def rows(points: ComplexArray) -> FloatArray:
    """Complex numbers as rows of x and y."""
    return np.column_stack([points.real, points.imag])
