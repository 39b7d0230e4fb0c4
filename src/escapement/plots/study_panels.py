"""Panels of a study's figures: lines, and contour maps with holes."""

from typing import Any, Literal

import matplotlib
import numpy as np
from matplotlib import ticker
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from escapement.mechanisms.protocol import FloatArray
from escapement.plots import style
from escapement.plots.study_table import STEPPED, Parameter, StudyTable, check_number
from escapement.plots.style import LINE, number_text

_FEW = 15  # a line with at most this many points has a marker on each
_LEVELS = 7  # approximate number of contours of a map
_SMALL, _GREAT = 1e-3, 1e4  # between these a number is printed without a power of ten
_MOST_TICKS = 10  # up to this many whole numbers along an axis each get a tick
NARROW = 24
"""Characters of a label that fit below a third of a page."""
TALL = 28
"""Characters of a label that fit beside a panel."""
_WIDE = 3.0  # from this ratio of the greatest result to the least, contours are in even ratios
_STEPS = (
    (1.0,), (1.0, 3.0), (1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 5.0, 7.0),
    (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0),
)  # fmt: skip
"""Round numbers within a decade, in ratios that are about equal."""
_EDGE = 0.04  # closer to the frame than this share of the map a number does not fit


def draw_lines(ax: Axes, table: StudyTable, line: int = LINE) -> list[Line2D]:
    """A line for each value of the second parameter, six at most; returns them.

    Points are marked if they are few or isolated. Over whole numbers each is marked, and none is
    joined to the next. With quantiles the second and third are the ends of a band.
    line : characters of a label that fit below the panel.
    """
    check_number(table.results, table.first_values)
    x, drawn = table.x, list[Line2D]()
    for look, column in zip(style.LOOKS, columns_drawn(table), strict=False):
        value = table.lines.values[column].item()
        name = value if isinstance(value, str) else number_text(value)
        y, *sides = table.values[:, :, column]
        # a point between two gaps would be invisible without a marker
        finite = np.pad(np.isfinite(y), 1)
        marked = finite[1:-1] & ~finite[:-2] & ~finite[2:] | (x.whole or x.values.size <= _FEW)
        drawn += ax.plot(
            x.values, y, color=look.color, ls="" if x.whole else look.linestyle, lw=1.2, ms=3.5,
            mfc="white", mew=0.9, label=name, marker=look.marker if marked.any() else "",
            markevery=None if marked.all() else np.flatnonzero(marked).tolist(),
        )  # fmt: skip
        band: dict[str, Any] = {"color": look.color, "alpha": 0.2}
        if sides and x.whole:
            ax.vlines(x.values, *sides, lw=4.0, **band)
        elif sides:
            ax.fill_between(x.values, *sides, lw=0.0, **band)
    dress_axis(ax, "x", x, line)
    ax.set_ylabel(style.label(table.name, table.unit, TALL))
    return drawn


def draw_map(ax: Axes, table: StudyTable, bar: Literal["right", "top"]) -> list[Artist]:
    """Colours over both axes, named by a bar; hatched where there is no result.

    Between points there are labelled contours; but a result that jumps, and one over
    whole numbers, has a cell of one colour for each point.
    bar : place of the colour bar; on top of maps that are side by side.
    Returns what a legend should have: the hatching, if there is some.
    """
    check_number(table.results, table.values)
    x, y = table.x, table.lines
    # contours and cells have the first axis along the columns
    z = np.ma.masked_invalid(table.first_values.T)
    cells = table.first in STEPPED or x.whole or y.whole
    count, darkest = (2 * _LEVELS, 0.95) if cells else (_LEVELS, 0.7)  # black can be read on 0.7
    levels = _levels(float(z.min()), float(z.max()), count)
    colours = ListedColormap(matplotlib.colormaps["Blues"](np.linspace(0.05, darkest, 256)))
    norm = BoundaryNorm(levels, colours.N)  # one colour for each interval of levels
    hatched: dict[str, Any] = {"facecolor": "white", "edgecolor": style.GREY, "hatch": "////"}
    ax.patch.set(linewidth=0.0, **hatched)
    dress_axis(ax, "x", x, NARROW if bar == "top" else LINE)
    dress_axis(ax, "y", y)
    if cells:
        filled: Any = ax.pcolormesh(_edges(x), _edges(y), z, cmap=colours, norm=norm)
        filled.set_rasterized(True)
        # a cell of a whole number is shown to its ends
        across, along = ((_edges(it) if it.whole else it.values)[[0, -1]] for it in (x, y))
        ax.set(xlim=across, ylim=along)
    else:
        filled = ax.contourf(x.values, y.values, z, levels, cmap=colours, norm=norm)
        inside = levels[(levels > z.min()) & (levels < z.max())]
        if inside.size:
            look: dict[str, Any] = {"colors": style.BLACK, "linewidths": 0.6}
            lines = ax.contour(x.values, y.values, z, inside, **look)
            for number in ax.clabel(lines, fontsize=style.SMALL_SIZE, inline=False):
                at = (ax.transData - ax.transAxes).transform(number.get_position())
                room = 0.5 - np.abs(at - 0.5).max()
                number.set(bbox=style.BOX, visible=room > _EDGE)
    every = 1 + levels.size // _LEVELS  # only as many labels as there is room for
    key = ax.figure.colorbar(filled, ax=ax, location=bar, ticks=levels[::every])
    key.set_label(style.label(table.name, table.unit), size=style.TICK_SIZE)
    key.ax.tick_params(labelsize=style.SMALL_SIZE, width=0.7)
    lost = Patch(linewidth=0.6, label="no result", **hatched)
    return [lost] if np.ma.is_masked(z) else []


def _levels(low: float, high: float, count: int) -> FloatArray:
    """About this many round numbers, from `low` or below it to `high` or above it.

    Over a wide range their ratios are about equal. Results are often proportional to a power of a
    parameter, and equal steps would crowd into one corner of the map.
    """
    if not 0.0 < _WIDE * low < high:
        return np.asarray(ticker.MaxNLocator(count).tick_values(low, high))
    decades = np.log10(high / low)
    steps = min(_STEPS, key=lambda numbers: abs(len(numbers) * decades - count))
    # the locator's own ends may lie within those of the results
    locator = ticker.LogLocator(subs=steps, numticks=99)
    found = np.asarray(locator.tick_values(0.1 * low, 10.0 * high))
    return found[np.searchsorted(found, low, "right") - 1 : np.searchsorted(found, high) + 1]


def _edges(along: Parameter) -> FloatArray:
    """Ends of the cells about points, half-way between them."""
    even = np.log(along.values) if along.logarithmic else along.values
    # the outermost cells reach as far beyond their points as towards the next
    beyond = np.pad(even, 1, mode="reflect", reflect_type="odd")
    edges: FloatArray = 0.5 * (beyond[1:] + beyond[:-1])
    return np.exp(edges) if along.logarithmic else edges


def dress_axis(ax: Axes, which: Literal["x", "y"], along: Parameter, line: int = LINE) -> None:
    """Label, scale and ticks of an axis that a parameter runs along.

    line : characters of its label that fit below or beside it.
    """
    axis: Axis = getattr(ax, f"{which}axis")
    first, last = float(along.values.min()), float(along.values.max())
    ticks, unit = 5 if line == LINE else 3, along.unit
    locator: ticker.Locator = ticker.MaxNLocator(ticks, steps=[1, 2, 2.5, 5, 10])
    if along.whole:
        locator = ticker.MaxNLocator(2 * ticks, steps=[1, 2, 5, 10], integer=True)
        if (few := np.unique(along.values)).size <= _MOST_TICKS:
            locator = ticker.FixedLocator(few.tolist())
    elif along.logarithmic:
        ax.set(**{f"{which}scale": "log"})
        locator = ticker.LogLocator(subs=(1.0, 2.0, 5.0) if last < 1e2 * first else (1.0,))
        axis.set_minor_formatter(ticker.NullFormatter())
        if first >= _SMALL and last <= _GREAT:
            axis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    elif (most := max(-first, last)) > 0.0 and not 10.0 * _SMALL < most < _GREAT:
        # at the end of the axis a power of ten would overlap the label
        power = 3 * int(np.floor(np.log10(most) / 3.0))
        axis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")
        unit = f"10{style.superscript(power)} {unit}".strip()
    axis.set_major_locator(locator)
    axis.set_label_text(style.label(along.name, unit, line))


def columns_drawn(table: StudyTable) -> list[int]:
    """Indices of the lines drawn: evenly spread, ends included."""
    count = table.lines.values.size
    most = min(count, len(style.LOOKS))
    # equal steps between the drawn lines are better than one more line
    shown = next((n for n in range(most, 3, -1) if (count - 1) % (n - 1) == 0), most)
    return [round(i) for i in np.linspace(0, count - 1, shown).tolist()]
