"""Atomic output: a file appears under its name complete, or not at all.

The content goes to a temporary file beside the target, is made durable with fsync
and gets its name by a rename, which the file system does in one step.
"""

import errno
import os
import stat
from collections.abc import Iterable
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import BinaryIO, cast

from escapement.errors import CannotCreate, EscapementError, StorageError

_DEVICE_ERRORS = {errno.ENOSPC, errno.EIO, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}


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


def new_token() -> str:
    """A random word, so that no two temporary files have the same name."""
    return os.urandom(8).hex()


def temporary_path(folder: Path, token: str) -> Path:
    """Path of the temporary file in which an output is made."""
    return folder / f".escapement-{token}.partial"


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
        self._temporary = temporary or temporary_path(self._target.parent, new_token())
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
            self.discard()
            raise
        except OSError as error:
            self.discard()
            raise storage_error(self._named, error) from None

    def discard(self) -> None:
        """Remove the temporary file, if it is still there; the target stays as it was."""
        # closing may report a full disk late, but the file is removed anyway
        with suppress(OSError):
            self.handle.close()
        # the file may have its final name already, or its folder may have been removed
        with suppress(OSError):
            self._temporary.unlink()


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
            view = memoryview(part)
            while view:
                view = view[pending.handle.write(view) :]
        pending.place()
    except EscapementError:
        raise
    except OSError as error:
        raise storage_error(path, error) from None
    finally:
        pending.discard()


def replace_file(path: str | PathLike[str], parts: Iterable[bytes]) -> None:
    """`write_file` that replaces an existing file, unless that is read-only."""
    check_replaceable(path)
    write_file(path, parts, force=True)


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
    if error.errno in _DEVICE_ERRORS:
        return storage_error(path, error)
    return cannot_create(path, error)


def sync_folder(folder: Path) -> None:
    """Make a new name in `folder` durable, on systems that can open a folder."""
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError:
        return
    with suppress(OSError):
        os.fsync(descriptor)
    os.close(descriptor)
