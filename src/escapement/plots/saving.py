"""Figures and films as files, the same bytes for the same figure."""

import io
import os
import tempfile
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from escapement.base import files
from escapement.plots.films import write_film

# The same figure gives the same bytes only without date and random ids; text stays text.
_WRITING: Any = {"svg.hashsalt": "escapement", "pdf.fonttype": 42, "svg.fonttype": "none"}
_SETTINGS: dict[str, dict[str, Any]] = {
    ".png": {"dpi": 300, "metadata": {"Software": None}},
    ".pdf": {"dpi": 300, "metadata": {"CreationDate": None, "Creator": None, "Producer": None}},
    ".svg": {"dpi": 300, "metadata": {"Date": None, "Creator": None}},
}


def save(picture: Figure | Axes | FuncAnimation, path: str | os.PathLike[str]) -> None:
    """Write a figure or a film: complete under its name, or not at all.

    Parameters
    ----------
    picture : Figure, Axes or FuncAnimation
        What to write; for axes their whole figure. The same figure gives the same bytes, because
        the file contains no date.
    path : path
        Its suffix decides the format: .png, .pdf or .svg; a film's is .gif, or .mp4 or .webm,
        which ffmpeg writes. An existing file is replaced, unless it is read-only. Text in an
        .svg is text, to be edited and searched.

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
        if moving:
            write_film(figure, made)
        else:
            figure.savefig(made, **_SETTINGS[suffix])
        content = made.read_bytes()
    files.replace_file(path, [content])


def as_svg(figure: Figure) -> str:
    """The text of an SVG element, the same for the same figure."""
    content = io.StringIO()
    with matplotlib.rc_context(_WRITING):
        figure.savefig(content, format="svg", **_SETTINGS[".svg"])
    text = content.getvalue()
    return text[text.index("<svg") :]
