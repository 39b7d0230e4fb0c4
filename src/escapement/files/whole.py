"""An output file that appears complete or not at all."""

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
    """Where an output will go, once it is clear that it may go there.

    Parameters
    ----------
    path : path
        What the user named; a link is followed, so that it stays a link.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    CannotCreate
        When the folder is missing, something stands in the way, or a file
        exists and `force` is not given.
    """
    try:
        target = Path(os.path.realpath(path))  # fails where the working directory was removed
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
            "choose another name or give force=True to replace it"
        )
    return target


def check_replaceable(path: str | PathLike[str]) -> Path:
    """As `check_target` for a file that is replaced unasked, unless it is read-only."""
    target = check_target(path, force=True)
    if target.exists() and not os.access(target, os.W_OK):
        raise CannotCreate(
            f"output {path} must be a file that may be replaced, got a read-only one; name another"
        )
    return target


def new_token() -> str:
    """A word that no other temporary file has in its name."""
    return os.urandom(8).hex()


def temporary_path(folder: Path, token: str) -> Path:
    """Where a file is made until it is complete."""
    return folder / f".escapement-{token}.partial"


class PendingFile:
    """A temporary file beside its target, put in place when it is complete.

    Parameters
    ----------
    path, force :
        As for `check_target`.
    temporary : Path, optional
        Name of the temporary file, which must be free, for a caller that cleans up
        after a killed process. Default: a new name each time.

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
        except OSError as error:
            self.discard()
            if isinstance(error, EscapementError):
                raise
            raise storage_error(self._named, error) from None

    def discard(self) -> None:
        """Leave nothing behind; the target stays as it was."""
        with suppress(OSError):  # a full disk may only show now, and the file goes anyway
            self.handle.close()
        with suppress(OSError):  # the folder itself may be gone
            self._temporary.unlink()


def write_whole(path: str | PathLike[str], parts: Iterable[bytes], force: bool = False) -> None:
    """Write a file of these parts, one after the other.

    Parameters
    ----------
    path, force :
        As for `check_target`.
    parts : iterable of bytes
        Its content; an error that they raise leaves nothing behind.

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
    except OSError as error:
        if isinstance(error, EscapementError):
            raise
        raise storage_error(path, error) from None
    finally:
        pending.discard()


def replace_whole(path: str | PathLike[str], parts: Iterable[bytes]) -> None:
    """`write_whole` of what is made anew at each call; an older file goes if it may."""
    check_replaceable(path)
    write_whole(path, parts, force=True)


def storage_error(path: str | PathLike[str], error: BaseException) -> StorageError:
    """The error for a write to `path` that failed half-way."""
    reason = getattr(error, "strerror", None) or error
    return StorageError(
        f"writing {path} failed: {reason}; nothing was left behind, free space or name another disk"
    )


def cannot_create(path: str | PathLike[str], error: Exception) -> CannotCreate:
    """The error for an output that may not be begun where it was asked for."""
    reason = getattr(error, "strerror", None) or error
    return CannotCreate(f"output {path} cannot be created: {reason}; choose another folder or name")


def creation_error(path: str | PathLike[str], error: OSError) -> EscapementError:
    """The error for an output that could not be begun."""
    if error.errno in _DEVICE_ERRORS:
        return storage_error(path, error)
    return cannot_create(path, error)


def sync_folder(folder: Path) -> None:
    """Make the new name durable, where the system can."""
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError:
        return
    with suppress(OSError):
        os.fsync(descriptor)
    os.close(descriptor)
