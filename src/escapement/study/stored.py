"""Result files, opened, and their columns, which are read when they are needed."""

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement.base.errors import EscapementError, InputFileError
from escapement.base.files import AnyPath, check_input
from escapement.base.status import Status

SCHEMA_VERSION = 2
"""Version of the file layout: raised when an older reader would misread a newer file."""
LAYOUT = {"schema_version": SCHEMA_VERSION, "Conventions": "CF-1.11"}
"""Root attributes that tell how to read a file."""
_UNLOCKED = "set the environment variable HDF5_USE_FILE_LOCKING=FALSE"
DAMAGE = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError)
"""Errors that h5py and NumPy raise for a damaged file."""


@contextmanager
def open_hdf5(path: AnyPath) -> Iterator[Any]:
    """An HDF5 file, open for reading; InputFileError where a lock is in the way."""
    import h5py

    try:
        with h5py.File(path, "r") as hdf5:
            yield hdf5
    except OSError as error:
        if isinstance(error, BlockingIOError) or "already open" in str(error):
            # a program that was killed may leave this mark, so there may be nothing to close
            raise InputFileError(
                f"file {path} must not be open for writing in another program, such as a notebook "
                f"or a viewer, and is; close it there, or {_UNLOCKED} to read it as it is"
            ) from None
        if "unable to lock" in str(error):
            raise InputFileError(
                f"file {path} must be on a file system with locks, and is not; {_UNLOCKED}"
            ) from None
        raise


@contextmanager
def opened(
    path: AnyPath, what: str, command: str, needed: Iterable[str], version: int
) -> Iterator[Any]:
    """The open file of a result; every fault of the file raises one error.

    what, command : content of the file, and the command that writes such a file.
    needed : names of datasets or root attributes that it must have.
    version : the newest layout that can be read.
    """
    import h5py

    check_input(path, what)
    remedy = f"name an HDF5 file that escapement {command} wrote"
    try:
        with open_hdf5(path) as hdf5:
            layout = hdf5.attrs.get("schema_version")
            missing = [name for name in needed if name not in hdf5 and name not in hdf5.attrs]
            if missing or not isinstance(layout, np.integer | int):
                lacks = ", ".join(missing) or "schema_version"
                raise InputFileError(
                    f"{what} {path} must hold a {what}, and lacks {lacks}; {remedy}"
                )
            if layout > version:
                raise InputFileError(
                    f"{what} {path} must have schema_version {version} or less, got {layout}; "
                    "install a newer geneva-escapement to read it"
                )
            yield hdf5
    except PermissionError:
        raise InputFileError(f"{what} {path} must be readable; check its permissions") from None
    except EscapementError:
        raise
    except DAMAGE as error:
        if h5py.is_hdf5(path):
            raise damaged(what, path, error) from None
        raise InputFileError(
            f"{what} {path} must be an HDF5 file, and is not or is cut short; {remedy}"
        ) from None


def damaged(what: str, path: AnyPath, error: Exception) -> InputFileError:
    """The error for a file that cannot be read in full."""
    reason = " ".join(str(error).split())
    return InputFileError(
        f"{what} {path} must be whole, and cannot be read in full: {reason}; restore a copy of it, "
        "or compute it again under another name"
    )


def check_values(name: str, values: Any, finite: bool = False) -> None:
    """Raise ValueError unless `values` are possible in a study; a status must be a known one."""
    # only the extremes are checked: a set would take ten times the memory of the file
    if name == "status" and values.size and not 0 <= values.min() <= values.max() <= max(Status):
        raise ValueError("status must hold known values")
    if finite and not np.isfinite(values).all():
        raise ValueError(f"{name} must be finite numbers")


@dataclass(frozen=True, eq=False)
class StoredColumns(Mapping[str, NDArray[Any]]):
    """Columns of a study file by name: arrays, each read when it is first asked for.

    The file is open only while it is read.

    path : absolute path of the file.
    names : of the columns.
    finite : whether their numbers must be finite.
    stamp : `stamp_of` the file when it was opened first.
    part : the part of each column that is read.
    """

    path: str
    names: Sequence[str]
    finite: bool
    stamp: tuple[int, int, int]
    part: tuple[slice, ...] = ()
    _read: dict[str, NDArray[Any]] = field(default_factory=dict, init=False)

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self.names:
            raise KeyError(name)
        if name not in self._read:
            with opened(self.path, "study", "sweep", ("status",), SCHEMA_VERSION) as hdf5:
                if stamp_of(self.path) != self.stamp:
                    raise InputFileError(
                        f"study {self.path} must be the file that was read first, and was replaced "
                        "since; read it again"
                    )
                found = hdf5[name][self.part]
                check_values(name, found, self.finite)
            self._read[name] = found
        return self._read[name]

    def __contains__(self, name: object) -> bool:
        return name in self.names  # the base class would read the column

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


def part_of(
    columns: Mapping[str, NDArray[Any]], part: tuple[slice, ...]
) -> Mapping[str, NDArray[Any]]:
    """A part of each column; no more of a file is read."""
    if isinstance(columns, StoredColumns) and not columns.part:
        return replace(columns, part=part)
    return {name: values[part] for name, values in columns.items()}


def stamp_of(path: str) -> tuple[int, int, int]:
    """What tells whether the file at a path is another one, or was changed."""
    found = os.stat(path)
    return found.st_ino, found.st_size, found.st_mtime_ns
