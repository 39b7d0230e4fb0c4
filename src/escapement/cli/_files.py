"""Looking at the places of outputs before computing for them."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, cast

from escapement.errors import CannotCreate, EscapementError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PICTURES = (".png", ".pdf", ".svg")
"""What a figure's name may end in."""


def check_output(path: Path, *, force: bool = False, beside: Path | None = None) -> None:
    """Raise CannotCreate unless a file can be put at `path`.

    Parameters
    ----------
    path : Path
        Where the file is to be.
    force : bool
        Whether an existing file may be replaced.
    beside : Path, optional
        An input or another output, which it must not be.
    """
    from escapement.store import check_target

    if beside is not None and path.resolve() == beside.resolve():
        raise CannotCreate(f"output {path} must not be {beside} too; give it a name of its own")
    _try_writing(path, check_target(path, force).parent)


def check_picture(path: Path, *, beside: Path | None = None) -> None:
    """As `check_output`. Pictures are made from data: an existing one is replaced."""
    if path.suffix.lower() not in PICTURES:
        raise CannotCreate(
            f"output {path} must end in {', '.join(PICTURES)}, got {path.suffix!r}; "
            "change the suffix"
        )
    check_output(path, force=True, beside=beside)


def make_folder(path: Path) -> None:
    """Create the folder `path` where it is not there; its parent must be."""
    try:
        path.mkdir(exist_ok=True)
    except FileExistsError:
        raise CannotCreate(f"output {path} must be a folder, got a file; name another") from None
    except (OSError, ValueError) as error:
        raise _refused(path, error) from None
    _try_writing(path, path)


def save_axes(axes: "Axes", path: Path) -> None:
    """Write the figure of axes that have one to themselves."""
    from escapement.plots import save

    save(cast("Figure", axes.figure), path)


def write_text(path: Path, text: str) -> None:
    """A text file, complete under its name or not at all; an older one is replaced."""
    from escapement.store._target import PendingFile, storage_error

    pending = PendingFile(path, force=True)
    try:
        data = memoryview(text.encode())
        while data:
            data = data[pending.handle.write(data) :]
        pending.place()
    except OSError as error:
        raise storage_error(path, error) from None
    finally:
        pending.discard()


def _try_writing(path: Path, folder: Path) -> None:
    """A file without a name in `folder`: leaves nothing behind, whatever happens."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise _refused(path, error) from None


def _refused(path: Path, error: Exception) -> EscapementError:
    reason = getattr(error, "strerror", None) or error
    return CannotCreate(f"output {path} cannot be created: {reason}; choose another folder or name")
