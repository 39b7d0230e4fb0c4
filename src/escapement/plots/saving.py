"""The one way to write a figure or a film to a file."""

import io
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import matplotlib
from matplotlib.figure import Figure

from escapement.errors import InvalidValue
from escapement.files import check_replaceable, picture_format, replace_file, storage_error

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

_METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    ".svg": {"Date": None, "Creator": None},
}


def save(figure: "Figure | FuncAnimation", path: str | os.PathLike[str]) -> None:
    """Write a figure or a film: complete under its name, or not at all.

    Parameters
    ----------
    figure : Figure or FuncAnimation
        What to write. The same figure gives the same bytes: nothing in the
        file tells the time.
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
    suffix = picture_format(path) if isinstance(figure, Figure) else _film_format(path)
    check_replaceable(path)
    if not isinstance(figure, Figure):
        try:
            film = _film(figure)
        except OSError as error:
            raise storage_error(path, error) from None
        replace_file(path, [film])
        return
    image = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "escapement", "pdf.fonttype": 42}):
        figure.savefig(image, format=suffix[1:], dpi=300, metadata=_METADATA[suffix])
    replace_file(path, [image.getvalue()])


def _film_format(path: str | os.PathLike[str]) -> str:
    suffix = Path(path).suffix
    if suffix.lower() != ".gif":
        raise InvalidValue(f"output {path} of a film must end in .gif, got {suffix!r}; change it")
    return suffix.lower()


def _film(film: "FuncAnimation") -> bytes:
    """A film as Pillow writes it, which wants a file of its own."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.gif"
        film.save(path, writer="pillow")
        return path.read_bytes()


def save_axes(axes: "Axes", path: Path) -> None:
    """Write the figure of axes that have one to themselves."""
    save(cast("Figure", axes.figure), path)
