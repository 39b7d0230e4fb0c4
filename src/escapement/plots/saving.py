"""Figures and films as files, the same bytes for the same figure."""

import io
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

from escapement.base import files
from escapement.plots.films import write_film
from escapement.plots.style import HALO

# The same figure gives the same bytes only without date and random ids; text stays text.
_WRITING: Any = {"svg.hashsalt": "escapement", "pdf.fonttype": 42, "svg.fonttype": "none"}
_SETTINGS: dict[str, dict[str, Any]] = {
    ".png": {"dpi": 300, "metadata": {"Software": None}},
    ".pdf": {"dpi": 300, "metadata": {"CreationDate": None, "Creator": None, "Producer": None}},
    ".svg": {"dpi": 300, "metadata": {"Date": None, "Creator": None}},
}
_BOX: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.8}


def save(picture: Figure | Axes | FuncAnimation, path: str | os.PathLike[str]) -> None:
    """Write a figure or a film: complete under its name, or not at all.

    Parameters
    ----------
    picture : Figure, Axes or FuncAnimation
        What to write; for axes their whole figure. The same figure gives the same bytes, because
        the file contains no date.
    path : path
        Its suffix decides the format: .png, .pdf or .svg; a film's is .gif, .html (a page
        that plays it and needs no other file), or .mp4 or .webm, which ffmpeg writes. An
        existing file is replaced, unless it is read-only. Text in an .svg is text, to be
        edited and searched.

    Raises
    ------
    InvalidValue
        When the suffix is none of these.
    CannotCreate
        When there can be no file at that place, or no ffmpeg is installed to write it.
    StorageError
        When writing fails half-way, for example on a full disk.
    """
    figure: Any = picture.figure if isinstance(picture, Axes) else picture
    moving = isinstance(picture, FuncAnimation)
    suffix = files.file_format(path, files.FILMS if moving else files.FORMATS)
    files.check_target(path, force=True, writable=True)
    # Pillow and ffmpeg write films to files alone
    with (
        files.storing(path),
        matplotlib.rc_context(_WRITING),
        tempfile.TemporaryDirectory() as folder,
    ):
        made = Path(folder) / f"picture{suffix}"
        with _as_letters([figure] if suffix == ".svg" else []):
            if moving:
                write_film(figure, made)
            else:
                figure.savefig(made, **_SETTINGS[suffix])
        content = made.read_bytes()
    files.replace_file(path, [content])


def as_svg(figure: Figure) -> str:
    """The text of an SVG element, the same for the same figure."""
    content = io.StringIO()
    with matplotlib.rc_context(_WRITING), _as_letters([figure]):
        figure.savefig(content, format="svg", **_SETTINGS[".svg"])
    text = content.getvalue()
    return text[text.index("<svg") :]


@contextmanager
def _as_letters(figures: list[Figure]) -> Iterator[None]:
    """Boxes instead of halos for a while: a halo turns the letters in it into curves."""
    found = [it for figure in figures for it in figure.findobj(Text) if it.get_path_effects()]
    for text in found:
        text.set(path_effects=None, bbox=_BOX)
    try:
        yield
    finally:
        for text in found:
            text.set(path_effects=HALO, bbox=None)
