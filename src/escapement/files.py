"""Files on disk: checks of names, output that appears complete, a file object for HDF5.

An output goes to a temporary file beside its target, is made durable with fsync and gets its
name by a rename, which the file system does in one step.
"""

import errno
import io
import os
import stat
from collections.abc import Iterable
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import BinaryIO, cast

from escapement.errors import (
    CannotCreate,
    EscapementError,
    InputFileError,
    InvalidValue,
    MissingInput,
    StorageError,
)

FORMATS = (".png", ".pdf", ".svg")
"""Suffixes of figures; they are known here so that a name is checked before Matplotlib loads."""
FILMS = (".gif",)
"""Suffixes of films."""

# A disk tells that it is full, or failing, by one of these.
_DEVICE_ERRORS = {errno.ENOSPC, errno.EIO, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}


def check_input(path: str | PathLike[str], what: str) -> None:
    """Raise MissingInput or InputFileError unless `path` is an ordinary file.

    `what` names the kind of file in the message. A pipe is refused as well, because
    reading it would wait for its writer without end.
    """
    file = Path(path)
    if not file.exists():
        raise MissingInput(f"{what} {path} does not exist; check its name")
    if not file.is_file():
        raise InputFileError(f"{what} {path} must be an ordinary file; name a file, not a folder")


def picture_format(path: str | PathLike[str], formats: tuple[str, ...] = FORMATS) -> str:
    """The suffix of a figure's name, one of `formats`; raises InvalidValue for another."""
    suffix = Path(path).suffix
    if suffix.lower() not in formats:
        raise InvalidValue(
            f"output {path} must end in {', '.join(formats)}, got {suffix!r}; change the suffix"
        )
    return suffix.lower()


def check_target(path: str | PathLike[str], force: bool = False) -> Path:
    """The path an output will have, after checks that it may be created.

    Parameters
    ----------
    path : path
        What the user named. A link is followed, so that the rename replaces the file
        that it points to and not the link.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    CannotCreate
        When the folder is missing, something stands in the way, or a file
        exists and `force` is not given.
    """
    try:
        # this fails where the working directory was removed
        target = Path(os.path.realpath(path))
    except (OSError, ValueError) as error:
        raise cannot_create(path, error) from None
    try:
        kind = target.lstat().st_mode
    except FileNotFoundError:
        if not target.parent.is_dir():
            raise CannotCreate(
                f"output {path} must be in an existing folder, got {target.parent}; create it first"
            ) from None
        return target
    except OSError as error:
        raise cannot_create(path, error) from None
    if stat.S_ISDIR(kind):
        raise CannotCreate(f"output {path} must be a file, got a directory; name a file in it")
    if not stat.S_ISREG(kind):
        raise CannotCreate(f"output {path} must be an ordinary file; name another")
    if not force:
        raise CannotCreate(
            f"output {path} must not exist yet, got an existing file; "
            "choose another name, or give force=True (--force) to replace it"
        )
    return target


def check_replaceable(path: str | PathLike[str]) -> Path:
    """`check_target` for a file that is replaced without asking, unless it is read-only."""
    target = check_target(path, force=True)
    if target.exists() and not os.access(target, os.W_OK):
        raise CannotCreate(
            f"output {path} must be a file that may be replaced, got a read-only one; name another"
        )
    return target


class PendingFile:
    """A temporary file beside its target, put in place when it is complete.

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

    def __init__(
        self, path: str | PathLike[str], force: bool = False, temporary: Path | None = None
    ) -> None:
        self._named, self._force = path, force
        self._target = check_target(path, force)
        self._temporary = temporary or temporary_path(self._target, os.urandom(8).hex())
        try:
            file = open(self._temporary, "x+b", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise creation_error(path, error) from None
        self.handle: BinaryIO = cast(BinaryIO, file)

    def place(self) -> None:
        """Make the file durable and give it its name, in that order."""
        try:
            os.fsync(self.handle.fileno())
            self.handle.close()
            check_target(self._named, self._force)
            os.replace(self._temporary, self._target)
            sync_folder(self._target.parent)
        except EscapementError:
            raise
        except OSError as error:
            raise storage_error(self._named, error) from None
        finally:
            self.discard()

    def discard(self) -> None:
        """Remove the temporary file, if it is still there; the target stays as it was."""
        # Closing may report a full disk late, and the file may have its final name already.
        with suppress(OSError):
            self.handle.close()
        with suppress(OSError):
            self._temporary.unlink()


def temporary_path(target: Path, word: str) -> Path:
    """Path of a temporary file in which `target` is made."""
    return target.with_name(f".escapement-{word}.partial")


def write_file(path: str | PathLike[str], parts: Iterable[bytes], force: bool = False) -> None:
    """Write a file that consists of these parts, one after the other.

    Parameters
    ----------
    path, force :
        As for `check_target`.
    parts : iterable of bytes
        Its content. If the iterable raises an error, no file is left behind.

    Raises
    ------
    CannotCreate, StorageError
        As `PendingFile`.
    """
    pending = PendingFile(path, force)
    try:
        for part in parts:
            write_all(pending.handle, part)
        pending.place()
    except EscapementError:
        raise
    except OSError as error:
        raise storage_error(path, error) from None
    finally:
        pending.discard()


def write_all(handle: BinaryIO, data: bytes | memoryview) -> None:
    """Write all of `data`: a signal or a full disk makes a write shorter than asked for."""
    view = memoryview(data).cast("B")
    while view:
        view = view[handle.write(view) :]


def replace_file(path: str | PathLike[str], parts: Iterable[bytes]) -> None:
    """`write_file` that replaces an existing file, unless that is read-only."""
    check_replaceable(path)
    write_file(path, parts, force=True)


class DeferredErrorFile:
    """A file object for HDF5 that never raises and keeps its first error.

    HDF5 does not survive a write that fails while it closes a file: the handle stays open
    and the process crashes at exit. After the first error all writes are therefore dropped,
    so that HDF5 can close, and the caller raises the kept error after that.
    """

    def __init__(self, handle: BinaryIO) -> None:
        self._handle = handle
        self._position = self._end = 0
        self.error: OSError | None = None

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move; HDF5 asks for the length by moving to the end."""
        self._position = offset + (self._end if whence == io.SEEK_END else 0)
        return self._position

    def write(self, data: memoryview) -> int:
        """Write all of `data`, unless there was an error before."""
        size = memoryview(data).nbytes
        if self.error is None:
            try:
                self._handle.seek(self._position)
                write_all(self._handle, data)
            except OSError as error:
                self.error = error
        self._end = max(self._end, self._position + size)
        return size

    def tell(self) -> int:
        """Position of the next access."""
        return self._position

    def read(self, size: int) -> bytes:
        """Bytes from the current position; those that were never written are zeros."""
        data = b""
        try:
            self._handle.seek(self._position)
            data = self._handle.read(size)
        except OSError as error:
            self.error = self.error or error
        return data.ljust(size, b"\0")

    def readinto(self, buffer: memoryview) -> int:
        """Fill `buffer` as `read` does."""
        view = memoryview(buffer).cast("B")
        view[:] = self.read(len(view))
        return len(view)

    def truncate(self, size: int) -> None:
        """Set the length."""
        try:
            if self.error is None:
                self._handle.truncate(size)
        except OSError as error:
            self.error = error
        self._end = size

    def flush(self) -> None:
        """Do nothing: the file below is unbuffered and holds nothing back."""


def storage_error(path: str | PathLike[str], error: BaseException) -> StorageError:
    """The error for a write to `path` that failed after it had begun."""
    reason = getattr(error, "strerror", None) or error
    return StorageError(
        f"writing {path} failed: {reason}; nothing was left behind, free space or name another disk"
    )


def cannot_create(path: str | PathLike[str], error: Exception) -> CannotCreate:
    """The error for an output that may not be created at `path`."""
    reason = getattr(error, "strerror", None) or error
    return CannotCreate(f"output {path} cannot be created: {reason}; choose another folder or name")


def creation_error(path: str | PathLike[str], error: OSError) -> EscapementError:
    """The error for an output file that could not be opened."""
    if isinstance(error, EscapementError):
        return error
    make = storage_error if error.errno in _DEVICE_ERRORS else cannot_create
    return make(path, error)


def sync_folder(folder: Path) -> None:
    """Make a new name in `folder` durable, on systems that can open a folder."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
