"""A file object for HDF5 that never fails.

HDF5 does not survive a write that fails while it closes a file: the handle
stays open and the process crashes at exit. Here the first error is kept and all
later writes are dropped, so HDF5 always closes in peace and the error is told
by whoever asks for it.
"""

import io
from typing import BinaryIO


class SteadyFile:
    """What h5py's "fileobj" driver needs, over an ordinary file.

    error : the first failure, None so far.
    """

    def __init__(self, handle: BinaryIO) -> None:
        self._handle = handle
        self._position = 0
        self._end = 0
        self.error: OSError | None = None

    def _keep(self, error: Exception) -> None:
        if self.error is None:
            self.error = error if isinstance(error, OSError) else OSError(str(error))

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move; HDF5 asks for the length by moving to the end."""
        origin = {io.SEEK_SET: 0, io.SEEK_CUR: self._position, io.SEEK_END: self._end}[whence]
        self._position = origin + offset
        return self._position

    def tell(self) -> int:
        """Where the next access is."""
        return self._position

    def write(self, data: bytes | memoryview) -> int:
        """Write all of `data`, or keep the error and drop it."""
        view = memoryview(data).cast("B")
        if self.error is None:
            try:
                self._write_all(view)
            except Exception as error:
                self._keep(error)
        self._position += len(view)
        self._end = max(self._end, self._position)
        return len(view)

    def _write_all(self, view: memoryview) -> None:
        self._handle.seek(self._position)
        while view:
            view = view[self._handle.write(view) :]  # a signal or a full disk writes a part

    def readinto(self, buffer: memoryview) -> int:
        """Fill `buffer`; what was never written reads as zeros."""
        view = memoryview(buffer).cast("B")
        count = 0
        try:
            self._handle.seek(self._position)
            while count < len(view) and (step := self._handle.readinto(view[count:])):  # type: ignore[attr-defined]
                count += step
        except Exception as error:
            self._keep(error)
        view[count:] = bytes(len(view) - count)
        self._position += len(view)
        return len(view)

    def read(self, size: int = -1) -> bytes:
        """Bytes from here; HDF5 itself uses `readinto`."""
        data = bytearray(self._end - self._position if size < 0 else size)
        self.readinto(memoryview(data))
        return bytes(data)

    def truncate(self, size: int) -> int:
        """Set the length."""
        if self.error is None:
            try:
                self._handle.truncate(size)
            except Exception as error:
                self._keep(error)
        self._end = size
        return size

    def flush(self) -> None:
        """Nothing is held back here: the file below is unbuffered."""
