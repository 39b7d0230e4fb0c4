"""House style of every figure, and the one way to write it to a file.

Colours are the Okabe-Ito palette, which colour-blind readers can tell apart
(Okabe and Ito, "Color universal design", 2008). Each goes with a line style and a
marker of its own, so nothing is lost in grey print. Sizes and fonts are for a
printed column and stay readable at half size. Only figure objects are used:
nothing here touches pyplot's global state or opens a window.
"""

import contextlib
import errno
import io
import os
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.errors import CannotCreate, StorageError

BLACK, GREY, LIGHT_GREY = "#000000", "#5f5f5f", "#b8b8b8"
BLUE, VERMILLION, GREEN = "#0072B2", "#D55E00", "#009E73"
PURPLE, ORANGE, SKY = "#CC79A7", "#E69F00", "#56B4E9"

ONE_COLUMN = 3.5
"""Width of a figure in one column [in], 89 mm."""
TWO_COLUMN = 7.2
"""Width of a figure across two columns [in], 183 mm."""
LABEL_SIZE, TICK_SIZE, SMALL_SIZE = 10.0, 9.0, 8.0
"""Font sizes [pt]; the smallest is 4 pt at half size."""

_HALF_WAY = (errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EFBIG)
_FORMATS: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    "svg": {"Date": None, "Creator": None},
}


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


def new_figure(width: float = ONE_COLUMN, height: float | None = None) -> Figure:
    """An empty figure, laid out on its own, of a size in inches."""
    return Figure(figsize=(width, height or 0.72 * width), layout="constrained")


def new_axes(width: float = ONE_COLUMN, height: float | None = None) -> Axes:
    """The only axes of a new figure of a size in inches."""
    return dress(new_figure(width, height).add_subplot())


def dress(ax: Axes) -> Axes:
    """Give axes of our own the house's fonts, ticks and frame."""
    ax.tick_params(
        which="both", direction="in", labelsize=TICK_SIZE, width=0.7, pad=5, top=True, right=True
    )
    for axis in (ax.xaxis, ax.yaxis):
        axis.label.set_fontsize(LABEL_SIZE)
        axis.get_offset_text().set_fontsize(TICK_SIZE)
    for spine in ax.spines.values():
        spine.set_linewidth(0.7)
    ax.title.set_fontsize(LABEL_SIZE)
    return ax


def legend_above(ax: Axes, columns: int, title: str | None = None, **options: Any) -> None:
    """A legend over the axes, where it can cover no data."""
    legend = ax.legend(
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=columns,
        title=title,
        fontsize=SMALL_SIZE,
        title_fontsize=SMALL_SIZE,
        frameon=False,
        handlelength=2.6,
        columnspacing=1.2,
        borderaxespad=0.3,
        **options,
    )
    legend.get_title().set_multialignment("center")


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure: complete under its name, or not at all.

    Parameters
    ----------
    figure : Figure
        What to write. The same figure gives the same bytes: nothing in the
        file tells the time.
    path : path
        Its suffix decides the format: .png, .pdf or .svg.

    Raises
    ------
    CannotCreate
        When the suffix or the place is wrong.
    StorageError
        When writing fails half-way, for example on a full disk.
    """
    target = Path(path)
    kind = _checked_format(target)
    image = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "escapement", "pdf.fonttype": 42}):
        figure.savefig(image, format=kind, dpi=300, metadata=_FORMATS[kind])
    try:
        _replace(target, image.getvalue())
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        if getattr(error, "errno", None) in _HALF_WAY:
            raise StorageError(
                f"output {target} could not be written: {reason}; "
                "free some space or give another path"
            ) from None
        rule = f"in a place that can be written ({reason})"
        raise _refused(target, rule, "give another path") from None


def _replace(target: Path, content: bytes) -> None:
    """Put a complete file in place of what was there."""
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        with open(partial, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(partial, target)
    finally:
        with contextlib.suppress(OSError, ValueError):
            partial.unlink()


def _checked_format(target: Path) -> str:
    kind = target.suffix.lower().lstrip(".")
    if kind not in _FORMATS:
        raise _refused(target, "a name ending in .png, .pdf or .svg", "change the suffix")
    if os.path.isdir(target):
        raise _refused(target, "a file, and this is a directory", "add a file name")
    if not os.path.exists(target.parent):
        raise _refused(target, "in a folder that exists", f"create {target.parent} first")
    if not os.path.isdir(target.parent):
        raise _refused(target, "in a folder", f"{target.parent} is a file; give another path")
    if os.path.exists(target) and not os.access(target, os.W_OK):
        raise _refused(target, "a file that may be replaced", "it is read-only; give another path")
    return kind


def _refused(target: Path, rule: str, remedy: str) -> CannotCreate:
    return CannotCreate(f"output must be {rule}, got {target}; {remedy}")
