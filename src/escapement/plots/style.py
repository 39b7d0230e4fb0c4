"""House style of every figure: colours, sizes, legends, names and units as printed.

Colours are the Okabe-Ito palette, which colour-blind readers can distinguish (Okabe and Ito,
"Color universal design", 2008). Each has its own line style and marker, so nothing is lost in
grey print. Sizes and fonts are for a printed column and stay readable at half size. Only figure
objects are used: nothing here touches pyplot's global state or opens a window. A notebook shows
them nevertheless, because they have a picture representation.

Data carry units in the spelling of UDUNITS ("rad s-1", "in lbf s2"); a figure
prints "rad/s" and "in-lbf-s²", and picks a prefix that keeps numbers short.
"""

import io
import math
import textwrap
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.spoken import spoken
from escapement.base.units import factor, spelt, unit_name

BLACK, GREY, LIGHT_GREY = "#000000", "#5f5f5f", "#b8b8b8"
BLUE, VERMILLION, GREEN = "#0072B2", "#D55E00", "#009E73"
PURPLE, ORANGE, SKY = "#CC79A7", "#E69F00", "#56B4E9"

ONE_COLUMN = 3.5
"""Width of a figure in one column [in], 89 mm."""
TWO_COLUMN = 7.2
"""Width of a figure across two columns [in], 183 mm."""
LABEL_SIZE, TICK_SIZE, SMALL_SIZE = 10.0, 9.0, 8.0
"""Font sizes [pt]; the smallest is 4 pt at half size."""

_MOST_DRAWN = 200  # more slots or lobes could not be distinguished
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PREFIXED = {"s": ("s", "ms", "µs", "ns"), "N m": ("N m", "mN m", "µN m", "nN m")}

LINE = 34
"""Characters of a label that fit beside one panel."""

HANDLE = 4.2
"""Length of a handle, in font sizes, that shows two dashes of any of `LOOKS` without marker."""


class Look(NamedTuple):
    """Colour, line style and marker of one line among several."""

    color: str
    linestyle: Any
    marker: str


LOOKS = (
    Look(BLUE, "-", "o"),
    Look(VERMILLION, (0, (5, 1.6)), "s"),
    Look(GREEN, (0, (5, 1.4, 1.2, 1.4)), "^"),
    Look(PURPLE, (0, (1.4, 1.2)), "D"),
    Look(ORANGE, (0, (8, 1.6)), "v"),
    Look(BLACK, (0, (5, 1.4, 1.2, 1.4, 1.2, 1.4)), "P"),
)

Point = tuple[float, float]
Named = tuple[str, str]
"""Name and unit of an axis."""
BOX: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.8}
"""Box that keeps a number on a curve readable."""
ZERO: dict[str, Any] = {"color": BLACK, "lw": 0.6}
"""Style of the zero line."""
SHADE: dict[str, Any] = {"color": SKY, "alpha": 0.3, "lw": 0}
"""Style of a shaded area."""
BROKEN: dict[str, Any] = {"color": VERMILLION, "ls": LOOKS[1].linestyle}
"""Style of a second curve beside a blue one."""
REVERSAL: dict[str, Any] = {"mfc": "white", "mec": BLACK, "mew": 0.8, "label": "pin reversal"}
"""Marker of a pin reversal."""


def check_drawn(name: str, count: int) -> None:
    """Refuse a drawing whose parts could not be distinguished."""
    if count > _MOST_DRAWN:
        raise validate.fail(name, f"at most {_MOST_DRAWN} in a drawing", count, "leave it undrawn")


class Picture(Figure):
    """A figure that a notebook shows if it is the last value of a cell."""

    def _repr_png_(self) -> tuple[bytes, dict[str, float]]:
        """Twice as fine as a screen, with the size in pixels to show it at."""
        content = io.BytesIO()
        self.savefig(content, format="png", dpi=2.0 * self.dpi)
        width, height = self.bbox.width, self.bbox.height
        return content.getvalue(), {"width": round(width), "height": round(height)}


class PictureAxes(Axes):
    """The only axes of a picture: as the last value of a cell they show the whole picture."""

    def _repr_png_(self) -> Any:
        return self.figure._repr_png_()  # type: ignore[union-attr]


def new_figure(width: float = ONE_COLUMN, height: float | None = None) -> Figure:
    """An empty figure with automatic layout, of a size in inches."""
    return Picture(figsize=(width, height or 0.72 * width), layout="constrained")


def new_axes(width: float = ONE_COLUMN, height: float | None = None) -> Axes:
    """The only axes of a new figure of a size in inches."""
    return dress(new_figure(width, height).add_subplot(axes_class=PictureAxes))


def new_panels(
    figure: Figure | SubFigure, rows: int, columns: int = 1, **options: Any
) -> list[Axes]:
    """Panels in house style, row by row; stacked ones share the abscissa."""
    axes = figure.subplots(rows, columns, sharex="col", squeeze=False, **options)
    return [dress(ax) for ax in axes.ravel()]


def dress(ax: Axes) -> Axes:
    """Give axes of our own the house's fonts, ticks and frame."""
    ax.tick_params(
        which="both", direction="in", labelsize=TICK_SIZE, width=0.7, pad=5, top=True, right=True
    )
    for axis in (ax.xaxis, ax.yaxis):
        axis.label.set_fontsize(LABEL_SIZE)
        axis.get_offset_text().set_fontsize(TICK_SIZE)
    ax.spines[:].set_linewidth(0.7)
    ax.title.set_fontsize(LABEL_SIZE)
    return ax


def legend_above(ax: Axes, columns: int, title: str | None = None, **options: Any) -> None:
    """A legend above the axes, where it covers no data, or inside if there is no space above."""
    location: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0)}
    location["borderaxespad"] = 0.3
    if ax.figure.get_layout_engine() is None:
        # a figure of the user has no space above its axes
        columns, location = 1, {"loc": "best", "frameon": True}
    space = {"columnspacing": 1.2, "handlelength": 2.6}
    add_legend(ax, columns, title, **{**location, **space, **options})


def finished(
    ax: Axes, x: Named, y: Named, columns: int, title: str | None = None, *, legend: bool = True
) -> Axes:
    """The same axes with labels, and a legend above if wanted."""
    ax.set(xlabel=label(*x), ylabel=label(*y))
    if legend:
        legend_above(ax, columns, title)
    return ax


def add_legend(
    where: Axes | Figure | SubFigure, columns: int, title: str | None = None, **options: Any
) -> None:
    """A legend in house style, with fewer columns if all of them are wider than the figure."""
    whole = where.figure if isinstance(where, Axes) else where
    while True:
        legend = where.legend(ncols=columns, fontsize=SMALL_SIZE, **{"frameon": False, **options})
        if columns == 1 or legend.get_window_extent().width <= whole.bbox.width:
            break
        legend.remove()
        # one row more, with its entries spread evenly
        entries = len(legend.get_texts())
        columns = math.ceil(entries / (math.ceil(entries / columns) + 1))
    # the title does not count for the width, because it may have several lines
    legend.set_title(title or "")
    legend.get_title().set(fontsize=SMALL_SIZE, multialignment="center")


def annotate(
    ax: Axes, text: str, point: Point, offset: Point = (0.0, 0.0), side: str = "center"
) -> None:
    """Text beside a point of the data, in a box; the offset is in points."""
    ax.annotate(
        text, point, offset, textcoords="offset points", ha=side, va="center", zorder=6,
        fontsize=SMALL_SIZE, annotation_clip=False, bbox=BOX,
    )  # fmt: skip


def grid(ax: Axes) -> None:
    """Grid lines for reading values."""
    ax.grid(which="major", color=LIGHT_GREY, lw=0.5)
    ax.grid(which="minor", color=LIGHT_GREY, lw=0.25)
    ax.set_axisbelow(True)


def label(name: str, unit: str = "", line: int = LINE) -> str:
    """Text of an axis: name with a capital, its printed unit in brackets.

    line : characters after which a new line begins.
    """
    whole = unit.replace(" ", "~")
    text = name[:1].upper() + name[1:] + (f" ({whole})" if unit else "")
    return textwrap.fill(text, line).replace("~", " ")


def scaled(unit: str, values: ArrayLike) -> tuple[float, str]:
    """Factor and printed unit that make times and moments readable numbers.

    Parameters
    ----------
    unit : str
        UDUNITS spelling; seconds and N m get a prefix, the rest stays.
    values : array_like
        What will be plotted; NaN are ignored.

    Returns
    -------
    float, str
        Multiply by the factor to get values in the printed unit.
    """
    sizes = np.abs(np.asarray(values, dtype=float))
    largest = sizes[np.isfinite(sizes)].max(initial=0.0)
    names = _PREFIXED.get(unit)
    if names is None or largest == 0.0:
        return 1.0, spelt(unit)
    steps = min(max(math.ceil(-math.log10(largest) / 3.0), 0), len(names) - 1)
    return 1000.0**steps, names[steps]


def readable(kind: str, values: ArrayLike) -> tuple[float, str]:
    """As `scaled`, for values in SI of a kind of unit, in the system that the user chose."""
    numbers, system = np.asarray(values, dtype=float), spoken()
    unit = factor(kind, system)
    prefix, name = scaled(unit_name(kind, system), numbers / unit)
    return prefix / unit, name


def superscript(power: int) -> str:
    """A whole number as an exponent."""
    return str(power).translate(_SUPERSCRIPTS)


def number_text(value: float) -> str:
    """A number to four figures, its power of ten written out."""
    mantissa, _, power = f"{value:.4g}".partition("e")
    return f"{mantissa}×10{superscript(int(power))}" if power else mantissa


def round_below(value: float) -> float:
    """The greatest of .., 1, 2, 5, 10, 20, .. that is no more than a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-12))
