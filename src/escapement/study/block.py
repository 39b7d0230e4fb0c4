"""A block of a study: the unit that is computed, kept, sent and written as a whole.

A block is one HDF5 chunk of every result, already encoded as HDF5's filters would encode it.
It holds a fixed range of cases, so that neither its bytes nor those of the file depend on the
process that computed it. Other threads can work while a chunk is encoded here, which they could
not if HDF5 encoded it: that would double the time of a study of ten million cases that share
scenes (`benchmarks/crash_cost.py`). An encoded chunk is a plain string of bytes with its checksum.
"""

import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from escapement.study.result import Study, count_failed

CELLS = 65536
"""Values per chunk of an axis: 512 KiB, half of HDF5's default chunk cache."""
_CASES = {
    "energy": (1024, 16384),
    "index": (256, 2048),
    "ivp": (4, 4),
    "contact": (4, 4),
    "two_bodies": (16, 256),
}
"""Fewest and most cases of a block: `energy` takes up to 0.25 s for one, the others about 2 s.

A block costs a call and a chunk, which take as long as tens of fast cases; with smaller blocks
this cost would matter.
"""
_BLOCKS = 64  # blocks of a large study, so that up to 64 cores have work


@dataclass(frozen=True)
class Tiling:
    """A grid divided so that every chunk holds consecutive cases in C order.

    shape : shape of the grid.
    tile : shape of a chunk; 1 before the axis that is divided, whole after it.
    row : number of cases along that axis and those after it, which are divided into chunks.
    """

    shape: tuple[int, ...]
    tile: tuple[int, ...]
    row: int

    @property
    def cells(self) -> int:
        """Cases a full chunk holds."""
        return math.prod(self.tile)

    def __len__(self) -> int:
        return math.prod(self.shape) // self.row * -(-self.row // self.cells)

    def span(self, chunk: int) -> tuple[int, int]:
        """First case of a chunk, and the one after its last."""
        row, piece = divmod(chunk, -(-self.row // self.cells))
        start = row * self.row + piece * self.cells
        return start, min(start + self.cells, (row + 1) * self.row)

    def offset(self, chunk: int) -> tuple[int, ...]:
        """Grid index of a chunk's first case."""
        return tuple(int(i) for i in np.unravel_index(self.span(chunk)[0], self.shape))


def tiling(shape: tuple[int, ...], cells: int) -> Tiling:
    """Cut a grid into chunks of about `cells` cases, at most twice as many."""
    row, tile = 1, [1] * len(shape)
    for axis in reversed(range(len(shape))):
        row *= shape[axis]
        pieces = -(-row // cells)
        tile[axis] = -(-shape[axis] // pieces)
        if pieces > 1:
            break
    return Tiling(shape, tuple(tile), row)


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
    # Shuffled doubles consist of runs of equal bytes and noise: matching only runs takes a third
    # of the time of a full search.
    deflate = zlib.compressobj(1, zlib.DEFLATED, 15, 9, zlib.Z_RLE)
    data = deflate.compress(planes.tobytes()) + deflate.flush()
    return data + fletcher32(data).to_bytes(4, "little")


def decode(data: bytes, dtype: DTypeLike) -> NDArray[Any]:
    """The values of a chunk that `encode` made, the zeros at its end included."""
    planes = np.frombuffer(zlib.decompress(data[:-4]), np.uint8)
    rows = planes.reshape(np.dtype(dtype).itemsize, -1).T
    return np.ascontiguousarray(rows).view(dtype)[:, 0]


def fletcher32(data: bytes) -> int:
    """Checksum of HDF5's fletcher32 filter: sums of big-endian words mod 65535."""
    # Modulo 65535 a swap of bytes is a factor of 256, so little-endian words can be used.
    words = np.frombuffer(data + bytes(-len(data) % 512), "<u2").astype(np.uint32)
    # The second sum has the weights size, size - 1, ..., 1. The word in row i and column j has
    # the weight (size - 256 i) - j, so the sums of rows and columns, which fit 32 bits, suffice.
    table = words.reshape(-1, 256)
    rows = table.sum(axis=1, dtype=np.uint32).astype(np.int64)
    columns = table.sum(axis=0, dtype=np.uint32).astype(np.int64)
    size = (len(data) + 1) // 2
    first = int(rows.sum())
    second = int(rows @ (size - 256 * np.arange(rows.size)) - columns @ np.arange(256))
    return _fold(256 * second) << 16 | _fold(256 * first)


def _fold(total: int) -> int:
    """End-around carry: 65535 stands for a multiple of 65535, 0 for nothing at all."""
    return (total - 1) % 65535 + 1 if total else 0


class Block(NamedTuple):
    """The results of one chunk of cases.

    number : index among the chunks.
    failed : number of its cases that could not be computed.
    data : for a file the number and sizes of the encoded results, followed by these results in
        the order of the file; for memory an array of each result.
    """

    number: int
    failed: int
    data: Any

    @property
    def chunks(self) -> tuple[bytes, ...]:
        """The encoded results."""
        data = BytesIO(self.data)
        (count,) = np.frombuffer(data.read(4), "<u4").tolist()
        return tuple(map(data.read, np.frombuffer(data.read(4 * count), "<u4").tolist()))


def blocks_of(frame: Study) -> Tiling:
    """How the cases of a study are cut into blocks."""
    least, most = _CASES[frame.attributes["engine"]]
    return tiling(frame.shape, min(most, max(least, math.prod(frame.shape) // _BLOCKS)))


def encode_block(cut: Tiling, number: int, columns: Mapping[str, NDArray[Any]]) -> Block:
    """A block made from its results in the order of the file, shape (n,) each."""
    chunks = [encode(values, cut.cells) for values in columns.values()]
    sizes = np.array([len(chunks), *map(len, chunks)], "<u4")
    data = b"".join((sizes.tobytes(), *chunks))
    return Block(number, count_failed(columns["status"]), data)
