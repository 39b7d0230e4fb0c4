"""A block of a study: the unit that is computed, kept, sent and written as a whole.

A block is one HDF5 chunk of every result, already encoded. It holds a fixed range of
cases, so that neither its bytes nor those of the file depend on who computed it.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.study.chunks import Tiling, encode, tiling
from escapement.study.result import RESULTS, Study, count_failed

_CASES = {"energy": (1024, 16384), "ivp": (4, 4)}
"""Cases of a block, at least and at most: `energy` takes up to 0.25 s, `ivp` about 2 s.

Fewer would cost more than a call and a chunk do, which is as much as tens of fast cases.
"""
_BLOCKS = 64  # of any study that is large enough: as many cores have work


class Block(NamedTuple):
    """One chunk of every result.

    number : place among the chunks. cases, failed : held, and those without an answer.
    chunks : encoded, in the order of `RESULTS`.
    """

    number: int
    cases: int
    failed: int
    chunks: tuple[bytes, ...]


def blocks_of(frame: Study) -> Tiling:
    """How the cases of a study are cut into blocks."""
    least, most = _CASES[frame.attributes["engine"]]
    return tiling(frame.shape, min(most, max(least, math.prod(frame.shape) // _BLOCKS)))


def encode_block(cut: Tiling, number: int, columns: Mapping[str, NDArray[Any]]) -> Block:
    """A block of its results, shape (n,) each."""
    chunks = (
        encode(columns[name].astype(result.dtype, copy=False), cut.cells)
        for name, result in RESULTS.items()
    )
    status = np.asarray(columns["status"])
    return Block(number, status.size, count_failed(status), tuple(chunks))
