"""Panels of a study's figures: lines, and contour maps with holes."""

from typing import Any, Literal

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import (
    FixedLocator,
    LogLocator,
    MaxNLocator,
    NullFormatter,
    StrMethodFormatter,
)

from escapement.model import FloatArray
from escapement.plots import style
from escapement.plots.study_table import StudyTable, parameter_label, result_scale
from escapement.plots.style import LINE, number_text
from escapement.study.result import Study

_FEW = 15  # a line of at most so many points has each of them marked
_LEVELS = 7  # a map has about so many contours
_PLAIN = (1e-3, 1e4)  # between these a number is printed without a power of ten
_DECADE = 8.0  # an axis that spans this factor in even ratios is drawn logarithmic
_MOST_TICKS = 10  # up to so many whole numbers along an axis each get a tick
_NARROW = 24  # characters of a label that fit below a third of a page
_EDGE = 0.06  # so near to the frame, as a share of the map, no number has room
_APART = 0.1  # numbers closer than this share of the map would overlap
_POWER = 8  # a power of ten beside the label takes so many of them
_STEPPED = ("rise_time", "settling_time")  # these jump by an engagement, so have no contours


def draw_lines(ax: Axes, study: Study, result: str, table: StudyTable) -> list[Line2D]:
    """A line for each value of the second axis, six at most; returns them."""
    x, joined = table.x_values, not is_whole(study, table.x)
    factor, text = result_scale(study, result, table.values)
    drawn = []
    for look, column in zip(style.LOOKS, lines_drawn(table.values.shape[1]), strict=False):
        name = "" if table.lines is None else number_text(table.line_values[column])
        drawn.append(draw_line(ax, x, table.values[:, column] * factor, look, name, joined))
    dress_axis(ax, "x", study, table.x)
    ax.set_ylabel(text)
    return drawn


def draw_line(
    ax: Axes, x: FloatArray, y: FloatArray, look: style.Look, name: str, joined: bool = True
) -> Line2D:
    """One line, its points marked where they are few or stand alone; or all, and not joined."""
    # a point between two gaps would be invisible without a marker
    finite = np.concatenate([[False], np.isfinite(y), [False]])
    alone = finite[1:-1] & ~finite[:-2] & ~finite[2:]
    marked = alone if joined and x.size > _FEW else np.ones(x.size, bool)
    (line,) = ax.plot(
        x, y, color=look.color, linestyle=look.linestyle if joined else "", lw=1.2, ms=3.5,
        mfc="white", mew=0.9, label=name or "_", marker=look.marker if marked.any() else "",
        markevery=None if marked.all() else np.flatnonzero(marked).tolist(),
    )  # fmt: skip
    return line


def legend(ax: Axes, study: Study, table: StudyTable, lines: list[Line2D], note: str = "") -> None:
    """What the lines stand for, over a panel in one column; of a single line the note alone."""
    if table.lines is None:
        ax.set_title(note, fontsize=style.SMALL_SIZE)
    else:
        title = "\n".join(text for text in (note, legend_title(study, table)) if text)
        columns = 2 if len(lines) == 4 else 3
        style.legend_above(ax, columns, title, handles=lines, handlelength=style.HANDLE)


def legend_title(study: Study, table: StudyTable) -> str:
    """What the lines are: "Driving torque (in·lbf)"; "" for a single line."""
    if table.lines is None:
        return ""
    text = parameter_label(study, table.lines)
    count = table.values.shape[1]
    shown = len(lines_drawn(count))
    return text if shown == count else f"{text}, {shown} of {count} values"


def head(figure: Figure | SubFigure, table: StudyTable) -> None:
    """Say over the figure which axes were fixed, and where."""
    if table.note:
        figure.suptitle(table.note, fontsize=style.SMALL_SIZE)


def draw_map(
    ax: Axes, study: Study, result: str, table: StudyTable, bar: Literal["right", "top"]
) -> list[Patch]:
    """Colours over both axes, named by a bar; hatched where there is no result.

    Between points there are labelled contours; but a result that jumps, and one over
    whole numbers, has a cell of one colour for each point.
    bar : where the colour bar goes; on top of maps that stand side by side.
    Returns the legend's key of the hatching, or nothing where there is none.
    """
    x, y = table.x_values, table.line_values
    factor, text = result_scale(study, result, table.values)
    # contours and cells have the first axis along the columns
    z = np.ma.masked_invalid(table.values.T * factor)
    cells = result in _STEPPED or is_whole(study, table.x) or is_whole(study, str(table.lines))
    count, darkest = (2 * _LEVELS, 0.9) if cells else (_LEVELS, 0.6)  # black can be read on 0.6
    levels = np.asarray(MaxNLocator(count).tick_values(float(z.min()), float(z.max())))
    colours = ListedColormap(matplotlib.colormaps["Blues"](np.linspace(0.02, darkest, 256)))
    hatched: dict[str, Any] = {"facecolor": "white", "edgecolor": style.GREY, "hatch": "////"}
    ax.patch.set(linewidth=0.0, **hatched)
    dress_axis(ax, "x", study, table.x, line=_NARROW if bar == "top" else LINE)
    dress_axis(ax, "y", study, str(table.lines))
    filled: ScalarMappable
    if cells:
        norm = BoundaryNorm(levels, colours.N)
        filled = ax.pcolormesh(_edges(x), _edges(y), z, cmap=colours, norm=norm, rasterized=True)
        if not is_whole(study, table.x):
            ax.set_xlim(x[0], x[-1])
        if not is_whole(study, str(table.lines)):
            ax.set_ylim(y[0], y[-1])
    else:
        filled = ax.contourf(x, y, z, levels, cmap=colours)
        inside = levels[(levels > z.min()) & (levels < z.max())]
        if inside.size:
            lines = ax.contour(x, y, z, inside, colors=style.BLACK, linewidths=0.6)
            _label_contours(ax, lines)
    every = 1 + levels.size // _LEVELS  # as many numbers as have room
    key = ax.figure.colorbar(filled, ax=ax, location=bar, ticks=levels[::every])
    key.set_label(text, size=style.TICK_SIZE)
    key.ax.tick_params(labelsize=style.SMALL_SIZE, width=0.7)
    return [Patch(linewidth=0.6, label="no result", **hatched)] if np.ma.is_masked(z) else []


def _label_contours(ax: Axes, lines: ContourSet) -> None:
    """A number on the middle of each contour's longest piece, in a halo.

    None is drawn where the frame or another number is in its way.
    """
    to_axes = ax.transData - ax.transAxes
    placed: list[tuple[float, float]] = []
    for path in lines.get_paths():
        pieces = [
            _middle(to_axes.transform(piece)) for piece in path.to_polygons(closed_only=False)
        ]
        _, (x, y) = max(pieces, key=lambda found: found[0], default=(0.0, (0.0, 0.0)))
        clear = all(np.hypot(x - x0, y - y0) > _APART for x0, y0 in placed)
        if clear and _EDGE < x < 1.0 - _EDGE and _EDGE < y < 1.0 - _EDGE:
            placed.append((x, y))
    middles = [to_axes.inverted().transform(point) for point in placed]
    for text in ax.clabel(lines, fontsize=style.SMALL_SIZE, inline=False, manual=middles) or ():
        text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])


def _middle(points: FloatArray) -> tuple[float, tuple[float, float]]:
    """Length of a polyline, and the point half-way along it."""
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    half = along[-1] / 2.0
    x, y = (float(np.interp(half, along, column)) for column in points.T)
    return float(along[-1]), (x, y)


def _edges(values: FloatArray) -> FloatArray:
    """Ends of the cells about points, half-way between them."""
    even = np.log(values) if _logarithmic(values) else values
    # the outermost cells reach as far beyond their points as towards the next
    ends = np.interp(np.arange(even.size + 1) - 0.5, np.arange(even.size), even)
    ends[0], ends[-1] = 2.0 * even[0] - ends[1], 2.0 * even[-1] - ends[-2]
    edges: FloatArray = np.exp(ends) if _logarithmic(values) else ends
    return edges


def is_whole(study: Study, name: str) -> bool:
    """Whether a parameter takes whole numbers only, with nothing between them."""
    return bool(np.issubdtype(_parameter(study, name).dtype, np.integer))


def _parameter(study: Study, name: str) -> FloatArray:
    return np.asarray(study.axes[name] if name in study.axes else study.sampled[name])


def dress_axis(
    ax: Axes, which: Literal["x", "y"], study: Study, name: str, line: int = LINE
) -> None:
    """Label, scale and ticks of an axis that a parameter runs along.

    line : characters of its label that fit below or beside it.
    """
    values = _parameter(study, name)
    first, last = float(values.min()), float(values.max())
    axis = ax.xaxis if which == "x" else ax.yaxis
    ticks = 5 if line == LINE else 3
    if not 10.0 * _PLAIN[0] < last < _PLAIN[1]:
        line -= _POWER
    axis.set_label_text(parameter_label(study, name, line))
    if is_whole(study, name):
        few = np.unique(values).size <= _MOST_TICKS
        many = MaxNLocator(2 * ticks, steps=[1, 2, 5, 10], integer=True)
        axis.set_major_locator(FixedLocator(np.unique(values).tolist()) if few else many)
    elif _logarithmic(np.sort(values.astype(float))):
        ax.set(**{f"{which}scale": "log"})
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if last < 1e2 * first else (1.0,)))
        axis.set_minor_formatter(NullFormatter())
        if first >= _PLAIN[0] and last <= _PLAIN[1]:
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    else:
        axis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 2.5, 5, 10]))
        ax.ticklabel_format(axis=which, useMathText=True, scilimits=(-3, 4))


def _logarithmic(values: FloatArray) -> bool:
    if values.size < 3 or values.min() <= 0.0 or values.max() / values.min() < _DECADE:
        return False
    steps = np.diff(np.log(values))
    return bool(np.allclose(steps, steps[0], rtol=1e-6))


def lines_drawn(count: int) -> list[int]:
    """Indices of the lines drawn, of so many: evenly spread, ends included."""
    most = len(style.LOOKS)
    if count <= most:
        return list(range(count))
    # equal steps between the lines drawn are preferred to one line more
    even = [n for n in range(most, 3, -1) if (count - 1) % (n - 1) == 0]
    chosen = np.linspace(0, count - 1, even[0] if even else most)
    return [round(i) for i in chosen.tolist()]
