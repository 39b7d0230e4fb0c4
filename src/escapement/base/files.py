"""Files on disk: checks of names, output that appears complete, a file object for HDF5.

An output goes to a temporary file beside its target, is made durable with fsync and gets its
name by a rename, which the file system does in one step.
"""

import errno
import io
import os
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO, cast

from escapement.base import errors
from escapement.base.errors import CannotCreate, EscapementError, InvalidValue, StorageError

AnyPath = str | PathLike[str]
FORMATS = (".png", ".pdf", ".svg")
"""Suffixes of figures; they are known here so that a name is checked before Matplotlib loads."""
FILMS = (".gif", ".mp4", ".webm")
"""Suffixes of films."""
_BY_FFMPEG = (".mp4", ".webm")
PAGES = (".html",)
"""Suffix of a page: a report, the explorer, or a motion that is played."""
CUTS = (".dxf", ".svg", ".stl")
"""Suffixes of files of parts, for cutting and printing."""
HDF5 = (".h5", ".hdf5", ".nc")
"""Suffixes of HDF5 files."""
STUDIES = (*HDF5, ".csv", ".parquet")
"""Suffixes of files of studies."""
MOTIONS = (*HDF5, ".csv")
"""Suffixes of files of motions."""

# A disk tells that it is full, or failing, by one of these.
_DEVICE_ERRORS = {errno.ENOSPC, errno.EIO, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}


def check_input(path: AnyPath, what: str) -> None:
    """Raise MissingInput or InputFileError unless `path` is an ordinary file.

    `what` names the kind of file in the message. A pipe is refused as well, because
    reading it would wait for its writer without end.
    """
    file = Path(path)
    if not file.exists():
        raise errors.MissingInput(f"{what} {path} does not exist; check its name")
    if not file.is_file():
        raise errors.InputFileError(
            f"{what} {path} must be an ordinary file; name a file, not a folder"
        )


def file_format(path: AnyPath, formats: tuple[str, ...] = FORMATS) -> str:
    """The suffix of an output's name, one of `formats`.

    Raises InvalidValue for another, and CannotCreate where the program that writes it is lacking.
    """
    suffix = Path(path).suffix
    if suffix.lower() not in formats:
        raise InvalidValue(
            f"output {path} must end in {', '.join(formats)}, got {suffix!r}; change the suffix"
        )
    if suffix.lower() in _BY_FFMPEG and shutil.which("ffmpeg") is None:
        raise CannotCreate(
            f"output {path} must have ffmpeg to write it, which was not found; install ffmpeg, "
            "or end the name in .gif, which needs nothing"
        )
    return suffix.lower()


def check_target(path: AnyPath, force: bool = False, writable: bool = False) -> Path:
    """The path an output will have, after checks that it may be created.

    Parameters
    ----------
    path : path
        What the user named. A link is followed, so that the rename replaces the file
        that it points to and not the link.
    force : bool
        Whether an existing file may be replaced.
    writable : bool
        Whether that file must not be read-only.

    Raises
    ------
    CannotCreate
        When the folder is missing, something stands in the way, or a file
        exists and `force` is not given.
    """
    kind = 0
    with creating(path):
        # this fails where the working directory was removed
        target = Path(os.path.realpath(path))
        with suppress(FileNotFoundError):
            kind = target.lstat().st_mode
    there, folder = kind != 0, target.parent
    refusals = {
        f"be in an existing folder, got {folder}; create it first": not folder.is_dir(),
        "be a file, got a directory; name a file in it": stat.S_ISDIR(kind),
        "be an ordinary file; name another": there and not stat.S_ISREG(kind),
        "not exist yet, got an existing file; choose another name, or give force=True (--force) "
        "to replace it": there and not force,
        "be a file that may be replaced, got a read-only one; name another": there
        and writable
        and not os.access(target, os.W_OK),
    }
    for rule, broken in refusals.items():
        if broken:
            raise CannotCreate(f"output {path} must {rule}")
    return target


@contextmanager
def pending_file(
    path: AnyPath, force: bool = False, temporary: Path | None = None
) -> Iterator[BinaryIO]:
    """A temporary file beside its target, put in place where the `with` block ends well.

    After an error it is removed, and the target stays as it was.

    Parameters
    ----------
    path, force :
        As for `check_target`.
    temporary : Path, optional
        Name of the temporary file, which must not exist, for a caller that removes it
        after a killed process. Default: a random name.

    Raises
    ------
    CannotCreate
        When the target may not be created.
    StorageError
        When the disk is full or fails.
    """
    target = check_target(path, force)
    temporary = temporary or temporary_path(target, os.urandom(8).hex())
    with creating(path):
        handle = cast(BinaryIO, open(temporary, "x+b", buffering=0))  # noqa: SIM115
    try:
        with storing(path):
            yield handle
            # the data must be durable before the file gets its name
            os.fsync(handle.fileno())
            handle.close()
            check_target(path, force)
            os.replace(temporary, target)
            sync_folder(target.parent)
    finally:
        # Closing may report a full disk late, and the file may have its final name already.
        with suppress(OSError):
            handle.close()
        with suppress(OSError):
            temporary.unlink()


@contextmanager
def pending_hdf5(
    path: AnyPath, force: bool = False, temporary: Path | None = None
) -> Iterator[tuple[Any, "DeferredErrorFile"]]:
    """A new HDF5 file, open for writing, and its file object; otherwise like `pending_file`."""
    import h5py

    with pending_file(path, force, temporary) as handle:
        target = DeferredErrorFile(handle)
        try:
            with h5py.File(target, "w") as hdf5:
                yield hdf5, target
        except RuntimeError as error:  # HDF5 raises it when a device fails
            raise target.error or OSError(errno.EIO, str(error)) from None
        if target.error is not None:
            raise target.error


def temporary_path(target: Path, word: str) -> Path:
    """Path of a temporary file in which `target` is made."""
    return target.with_name(f".escapement-{word}.partial")


def write_file(
    path: AnyPath, parts: Iterable[bytes], force: bool = False, temporary: Path | None = None
) -> None:
    """Write a file that consists of these parts, one after the other.

    Parameters
    ----------
    path, force, temporary :
        As for `pending_file`.
    parts : iterable of bytes
        Its content. If the iterable raises an error, no file is left behind.

    Raises
    ------
    CannotCreate, StorageError
        As `pending_file`.
    """
    with pending_file(path, force, temporary) as handle:
        for part in parts:
            write_all(handle, part)


def write_all(handle: BinaryIO, data: bytes | memoryview) -> None:
    """Write all of `data`: a signal or a full disk makes a write shorter than asked for."""
    view = memoryview(data).cast("B")
    while view:
        view = view[handle.write(view) :]


def replace_file(path: AnyPath, parts: Iterable[bytes]) -> None:
    """`write_file` that replaces an existing file, unless that is read-only."""
    check_target(path, force=True, writable=True)
    write_file(path, parts, force=True)


class DeferredErrorFile:
    """A file object for HDF5 and Parquet that never raises and keeps its first error.

    HDF5 does not survive a write that fails while it closes a file: the handle stays open
    and the process crashes at exit. After the first error all writes are therefore dropped,
    so that HDF5 can close, and the caller raises the kept error after that.
    """

    closed = False

    def __init__(self, handle: BinaryIO) -> None:
        self._handle = handle
        self._position = self._end = 0
        self.error: OSError | None = None

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move; HDF5 asks for the length by moving to the end."""
        self._position = offset + (self._end if whence == io.SEEK_END else 0)
        return self._position

    def tell(self) -> int:
        """Position of the next access."""
        return self._position

    def write(self, data: memoryview) -> int:
        """Write all of `data`, unless there was an error before."""
        size = memoryview(data).nbytes
        if self.error is None:
            self._tried(partial(write_all, self._handle), data)
        self._position += size
        self._end = max(self._end, self._position)
        return size

    def truncate(self, size: int) -> None:
        """Set the length, unless there was an error before."""
        if self.error is None:
            self._tried(self._handle.truncate, size)
        self._end = size

    def read(self, size: int) -> bytes:
        """Bytes from the current position; those that were never written are zeros."""
        return (self._tried(self._handle.read, size) or b"").ljust(size, b"\0")

    def flush(self) -> None:
        """Do nothing: the file below is unbuffered and holds nothing back."""

    def _tried(self, use: Callable[[Any], Any], argument: Any) -> Any:
        try:
            self._handle.seek(self._position)
            return use(argument)
        except OSError as error:
            self.error = self.error or error
            return None


@contextmanager
def creating(path: AnyPath) -> Iterator[None]:
    """The error for an output that cannot be created, from the error of the system."""
    try:
        yield
    except EscapementError:
        raise
    except (OSError, ValueError) as error:
        if getattr(error, "errno", None) in _DEVICE_ERRORS:
            raise _storage_error(path, error) from None
        reason = getattr(error, "strerror", None) or error
        raise CannotCreate(
            f"output {path} cannot be created: {reason}; choose another folder or name"
        ) from None


@contextmanager
def storing(path: AnyPath, kept: Callable[[], str] = str) -> Iterator[None]:
    """The error for a write that failed after it had begun, from the error of the system.

    kept : gives the name of the partial results that are left, if any.
    """
    try:
        yield
    except CannotCreate:
        raise
    except OSError as error:
        raise _storage_error(path, error, kept()) from None


def _storage_error(path: AnyPath, error: Exception, kept: str = "") -> StorageError:
    reason = getattr(error, "strerror", None) or str(error)
    end = "nothing was left behind, free space or name another disk"
    if kept:
        end = (
            f"finished cases are kept in {kept}: free space, then continue with resume=True "
            "(--resume)"
        )
    made = StorageError(f"writing {path} failed: {reason}; {end}")
    made.strerror = reason
    return made


def sync_folder(folder: Path) -> None:
    """Make a new name in `folder` durable, on systems that can open a folder."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
