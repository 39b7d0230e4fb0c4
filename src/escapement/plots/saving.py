"""The one way to write a figure or a film to a file."""

import io
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
from matplotlib.axes import Axes

from escapement.files import (
    FILMS,
    check_replaceable,
    picture_format,
    replace_file,
    storage_error,
)

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.figure import Figure

# The same figure gives the same bytes only without the date and without random ids.
_METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    ".svg": {"Date": None, "Creator": None},
}


def save(picture: "Figure | Axes | FuncAnimation", path: str | os.PathLike[str]) -> None:
    """Write a figure or a film: complete under its name, or not at all.

    Parameters
    ----------
    picture : Figure, Axes or FuncAnimation
        What to write; of axes their whole figure. The same figure gives the same bytes:
        nothing in the file tells the time.
    path : path
        Its suffix decides the format: .png, .pdf or .svg; a film's is .gif. An existing
        file is replaced, unless it is read-only.

    Raises
    ------
    InvalidValue
        When the suffix is none of these.
    CannotCreate
        When there can be no file at that place.
    StorageError
        When writing fails half-way, for example on a full disk.
    """
    figure: Any = picture.figure if isinstance(picture, Axes) else picture
    moving = not hasattr(figure, "savefig")
    suffix = picture_format(path, FILMS) if moving else picture_format(path)
    check_replaceable(path)
    try:
        content = _film(figure) if moving else _image(figure, suffix)
    except OSError as error:
        raise storage_error(path, error) from None
    replace_file(path, [content])


def _image(figure: "Figure", suffix: str) -> bytes:
    image = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "escapement", "pdf.fonttype": 42}):
        figure.savefig(image, format=suffix[1:], dpi=300, metadata=_METADATA[suffix])
    return image.getvalue()


def _film(film: "FuncAnimation") -> bytes:
    """A film as Pillow writes it, which wants a file of its own."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.gif"
        film.save(path, writer="pillow")
        return path.read_bytes()
