"""Artists of drawings to scale: bodies, arrows that tell a sense, and a bar of known length."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Patch, PathPatch
from matplotlib.path import Path

from escapement.model import FloatArray
from escapement.outlines.body import Body, ComplexArray, Disc
from escapement.plots import style


def draw_body(ax: Axes, body: Body | Disc, **look: Any) -> Patch:
    """A body as a patch whose id is the body's name."""
    patch: Patch
    if isinstance(body, Disc):
        patch = Circle((body.centre.real, body.centre.imag), body.radius, gid=body.name, **look)
    else:
        patch = PathPatch(closed_path(*body.edges), gid=body.name, **look)
    ax.add_patch(patch)
    return patch


def closed_path(*edges: ComplexArray) -> Path:
    """Closed curves as one path."""
    return Path.make_compound_path(*(Path(rows(edge), closed=True) for edge in edges))


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
