"""The one way to write a figure to a file."""

import io
import os
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from escapement._pictures import picture_format
from escapement._whole_file import check_target, write_whole
from escapement.errors import CannotCreate

_METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    ".svg": {"Date": None, "Creator": None},
}


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure: complete under its name, or not at all.

    Parameters
    ----------
    figure : Figure
        What to write. The same figure gives the same bytes: nothing in the
        file tells the time.
    path : path
        Its suffix decides the format: .png, .pdf or .svg. An existing file is
        replaced, unless it is read-only.

    Raises
    ------
    InvalidValue
        When the suffix is none of these.
    CannotCreate
        When there can be no file at that place.
    StorageError
        When writing fails half-way, for example on a full disk.
    """
    suffix = picture_format(path)
    target = check_target(path, force=True)
    if target.exists() and not os.access(target, os.W_OK):
        raise CannotCreate(
            f"output {path} must be a file that may be replaced, got a read-only one; name another"
        )
    image = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "escapement", "pdf.fonttype": 42}):
        figure.savefig(image, format=suffix[1:], dpi=300, metadata=_METADATA[suffix])
    write_whole(path, [image.getvalue()], force=True)
