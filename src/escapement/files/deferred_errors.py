"""A file object for HDF5 that reports its errors afterwards.

HDF5 does not survive a write that fails while it closes a file: the handle
stays open and the process crashes at exit. This file object therefore never
raises. It keeps the first error and drops all later writes, so that HDF5 can
always close, and the caller raises the kept error after that.
"""

import io
from collections.abc import Callable
from typing import Any, BinaryIO


class DeferredErrorFile:
    """What h5py's "fileobj" driver needs, on top of an ordinary file.

    error : the first failure, or None.
    """

    def __init__(self, handle: BinaryIO) -> None:
        self._handle: Any = handle  # `readinto` is no part of BinaryIO
        self._position = 0
        self._end = 0
        self.error: OSError | None = None

    def _try(self, action: Callable[..., None], *arguments: Any) -> None:
        """Call `action`, and keep its error if it is the first."""
        try:
            action(*arguments)
        except Exception as error:
            if self.error is None:
                self.error = error if isinstance(error, OSError) else OSError(str(error))

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move; HDF5 asks for the length by moving to the end."""
        origin = {io.SEEK_SET: 0, io.SEEK_CUR: self._position, io.SEEK_END: self._end}[whence]
        self._position = origin + offset
        return self._position

    def tell(self) -> int:
        """Position of the next access."""
        return self._position

    def write(self, data: bytes | memoryview) -> int:
        """Write all of `data`; after an error nothing is written any more."""
        view = memoryview(data).cast("B")
        if self.error is None:
            self._try(self._write_all, view)
        self._position += len(view)
        self._end = max(self._end, self._position)
        return len(view)

    def _write_all(self, view: memoryview) -> None:
        self._handle.seek(self._position)
        while view:
            # a signal or a full disk makes a write shorter than asked for
            view = view[self._handle.write(view) :]

    def readinto(self, buffer: memoryview) -> int:
        """Fill `buffer`; bytes that were never written read as zeros."""
        view = memoryview(buffer).cast("B")
        view[:] = bytes(len(view))
        self._try(self._read_all, view)
        self._position += len(view)
        return len(view)

    def _read_all(self, view: memoryview) -> None:
        self._handle.seek(self._position)
        while view and (count := self._handle.readinto(view)):
            view = view[count:]

    def read(self, size: int = -1) -> bytes:
        """Bytes from the current position; HDF5 itself calls `readinto`."""
        data = bytearray(self._end - self._position if size < 0 else size)
        self.readinto(memoryview(data))
        return bytes(data)

    def truncate(self, size: int) -> int:
        """Set the length."""
        if self.error is None:
            self._try(self._handle.truncate, size)
        self._end = size
        return size

    def flush(self) -> None:
        """Do nothing: the file below is unbuffered and holds nothing back."""
