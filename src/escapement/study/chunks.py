"""Cutting a grid into HDF5 chunks, and encoding a chunk as HDF5's filters would.

Encoding here instead of in HDF5 lets other threads work meanwhile, and makes a
finished chunk a plain string of bytes that carries its own checksum.
"""

import math
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CELLS = 65536
"""Values per chunk of an axis: 512 KiB, half of HDF5's default chunk cache."""


@dataclass(frozen=True)
class Tiling:
    """A grid cut so that every chunk holds consecutive cases in C order.

    shape : of the grid. tile : of a chunk; 1 before the axis that is cut, whole
    after it.
    """

    shape: tuple[int, ...]
    tile: tuple[int, ...]

    @property
    def cells(self) -> int:
        """Cases a full chunk holds."""
        return math.prod(self.tile)

    @property
    def _cut(self) -> int:
        """The axis that is cut: the first whose tile is not 1, else the last."""
        return next((i for i, n in enumerate(self.tile) if n > 1), len(self.tile) - 1)

    @property
    def _pieces(self) -> int:
        return -(-self.shape[self._cut] // self.tile[self._cut])

    def __len__(self) -> int:
        return math.prod(self.shape[: self._cut]) * self._pieces

    def span(self, chunk: int) -> tuple[int, int]:
        """First case of a chunk, and the one after its last."""
        row, piece = divmod(chunk, self._pieces)
        length, step = self.shape[self._cut], self.tile[self._cut]
        tail = math.prod(self.shape[self._cut + 1 :])
        start = row * length + piece * step
        stop = row * length + min((piece + 1) * step, length)
        return start * tail, stop * tail

    def offset(self, chunk: int) -> tuple[int, ...]:
        """Grid index of a chunk's first case."""
        return tuple(int(i) for i in np.unravel_index(self.span(chunk)[0], self.shape))


def tiling(shape: tuple[int, ...], cells: int) -> Tiling:
    """Cut a grid into chunks of about `cells` cases, at most twice as many."""
    tail = 1
    tile = [1] * len(shape)
    for axis in reversed(range(len(shape))):
        pieces = -(-shape[axis] * tail // cells)
        tile[axis] = -(-shape[axis] // pieces)
        if pieces > 1:
            break
        tail *= shape[axis]
    return Tiling(shape, tuple(tile))


def encode(values: NDArray[np.generic], cells: int) -> bytes:
    """Shuffle, deflate and checksum one chunk of values.

    Parameters
    ----------
    values : ndarray, shape (n,), n <= cells
        Consecutive cases in the byte order of the file.
    cells : int
        Length a full chunk has; the rest becomes zeros, which no reader sees.

    Returns
    -------
    bytes
        What the filters shuffle, gzip and fletcher32 make of the chunk.
    """
    padded = np.zeros(cells, values.dtype)
    padded[: values.size] = values
    planes = padded.view(np.uint8).reshape(cells, values.dtype.itemsize).T
    # Shuffled doubles are runs and noise: matching runs alone takes a third of
    # the time of a full search.
    deflate = zlib.compressobj(1, zlib.DEFLATED, 15, 9, zlib.Z_RLE)
    data = deflate.compress(planes.tobytes()) + deflate.flush()
    return data + fletcher32(data).to_bytes(4, "little")


def fletcher32(data: bytes) -> int:
    """Checksum of HDF5's fletcher32 filter: sums of big-endian words mod 65535."""
    even = len(data) // 2
    words = np.frombuffer(data, ">u2", even).astype(np.int64)
    if len(data) % 2:
        words = np.append(words, data[-1] << 8)
    first = int(words.sum())
    second = int(words @ np.arange(words.size, 0, -1))
    return _fold(second) << 16 | _fold(first)


def _fold(total: int) -> int:
    """End-around carry: 65535 stands for a multiple of 65535, 0 for nothing at all."""
    return (total - 1) % 65535 + 1 if total else 0
