"""Looking at an output's place before computing for it."""

import tempfile
from pathlib import Path

from escapement.errors import CannotCreate

PICTURES = (".png", ".pdf", ".svg")
"""What a figure's name may end in."""


def check_output(option: str, path: Path, *, force: bool = False) -> None:
    """Raise CannotCreate unless a new file can be put at `path`.

    Parameters
    ----------
    option : str
        What the user gave it with.
    path : Path
        Where the file is to be.
    force : bool
        Whether an existing file may be replaced.
    """
    try:
        _check_place(option, path)
        if path.exists() and not force:
            raise refuse(option, "the name of a new file", path, "it exists: give --force to replace it")
    except (OSError, ValueError) as error:
        if isinstance(error, CannotCreate):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise refuse(option, "in a place that can be written", path, reason.lower()) from None


def check_picture(option: str, path: Path) -> None:
    """As `check_output`; an existing picture is replaced, and nothing else is."""
    if path.suffix.lower() not in PICTURES:
        raise refuse(option, "a name ending in " + ", ".join(PICTURES), path, "change the suffix")
    check_output(option, path, force=True)


def check_folder(option: str, path: Path) -> None:
    """Create the folder `path` if it is not there; its parent must be."""
    if path.exists() and not path.is_dir():
        raise refuse(option, "a folder", path, "it is a file: give another name")
    try:
        path.mkdir(exist_ok=True)
        _try_writing(path)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise refuse(option, "a folder that can be created and written", path, reason) from None


def refuse(option: str, rule: str, path: Path, remedy: str) -> CannotCreate:
    """The error for an output that cannot be; the caller raises it."""
    return CannotCreate(f"{option} must be {rule}, got {path}; {remedy}")


def _check_place(option: str, path: Path) -> None:
    if path.is_dir():
        raise refuse(option, "a file", path, "it is a folder: add a file name")
    if not path.parent.is_dir():
        remedy = f"create {path.parent} first"
        if path.parent.exists():
            remedy = f"{path.parent} is a file"
        raise refuse(option, "in a folder that exists", path, remedy)
    _try_writing(path.parent)


def _try_writing(folder: Path) -> None:
    """A file without a name: leaves nothing behind, whatever happens."""
    with tempfile.TemporaryFile(dir=folder):
        pass
