"""Result files, opened, and arrays in them that are read when they are needed."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
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


class Stored(NDArrayOperatorsMixin):
    """An array of a study file, which behaves like an array in memory.

    `stored[3]` and slices read only their own part; any other use reads the whole array, once.
    The file is open only while it is read.

    Parameters
    ----------
    path : str
        Absolute path of the file.
    dataset : h5py.Dataset
        The array.
    finite : bool
        Whether its numbers must be finite.
    """

    def __init__(self, path: str, dataset: Any, finite: bool) -> None:
        self.shape, self.dtype = dataset.shape, dataset.dtype
        self.ndim, self.size = dataset.ndim, dataset.size
        self._path, self._name, self._finite = path, dataset.name.lstrip("/"), finite
        self._stamp = _stamp(path)
        if self.dtype.kind not in "fiu":
            raise ValueError(f"{self._name} must be numbers, got {self.dtype}")

    @cached_property
    def values(self) -> NDArray[Any]:
        """The whole array."""
        whole: NDArray[Any] = self._read(())
        return whole

    def _read(self, key: Any) -> Any:
        with opened(self._path, "study", "sweep", ("status",), SCHEMA_VERSION) as hdf5:
            if _stamp(self._path) != self._stamp:
                raise InputFileError(
                    f"study {self._path} must be the file that was read first, and was replaced "
                    "since; read it again"
                )
            found = hdf5[self._name][key]
            check_values(self._name, found, self._finite)
            return found

    def __getitem__(self, key: Any) -> Any:
        keys = key if isinstance(key, tuple) else (key,)
        # HDF5 supports fewer kinds of indices than NumPy
        simple = all(
            isinstance(k, int | np.integer) or (isinstance(k, slice) and k.step in (None, 1))
            for k in keys
        )
        if not simple or "values" in vars(self):
            return self.values[key]
        _ = np.broadcast_to(np.empty(()), self.shape)[key]  # NumPy's errors for an index outside
        return self._read(key)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.values, dtype, copy=copy)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        plain = [x.values if isinstance(x, Stored) else x for x in inputs]
        if "out" in options:
            options["out"] = tuple(x.values if isinstance(x, Stored) else x for x in options["out"])
        return getattr(ufunc, method)(*plain, **options)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # protocols and copying look for such names
            raise AttributeError(name)
        return getattr(self.values, name)

    def __len__(self) -> int:
        return len(self.values) if not self.shape else int(self.shape[0])

    def __iter__(self) -> Iterator[Any]:
        return iter(self.values)

    def __repr__(self) -> str:
        return repr(self.values)

    def __str__(self) -> str:
        return str(self.values)


def _stamp(path: str) -> tuple[int, int, int]:
    found = os.stat(path)
    return found.st_ino, found.st_size, found.st_mtime_ns
