"""Finished blocks beside the file to come: appended once, checked, never rewritten.

Layout: a line that says who is writing, a head that says which study this is, then one
record for each block in the order of their completion. A record carries a checksum over
itself and the study it belongs to, so that a torn, damaged or foreign one is never
taken for good and costs only itself.
"""

import errno
import json
import os
import struct
import threading
import time
import zlib
from collections.abc import Mapping
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from escapement.files.atomic import new_token, sync_folder, temporary_path
from escapement.study.block import Block, Tiling
from escapement.study.owned_file import OWNER, SIGNATURE, is_named, open_owned, owner_line, token_of
from escapement.study.result import RESULTS

SYNC_EVERY = 1.0
"""Seconds of finished work that a crash of the machine may cost; of the process, none."""

_RECENT = 16  # blocks that are kept in memory for the file to come: 10 MB
_MARK = b"\x89ESCblk\n"
_HEAD_MARK = b"\x89EShead\n"
_HEAD = struct.Struct("<8sII")
_RECORD = struct.Struct(f"<8sIqII{len(RESULTS)}I")
_SEARCH = 1 << 20


class Journal:
    """The journal at `path`, locked; created where there is none.

    Raises
    ------
    CannotCreate
        When another process is writing it.
    OSError
        When it cannot be opened or locked.

    Attributes
    ----------
    head : dict or None
        What `start` wrote; None where there is none or it is damaged.
    ours : bool
        Whether the file is new or begins like a journal.
    temporary : Path
        Where its owners make the file to come: what a killed one left, the next removes.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._access = threading.Lock()  # one place in the file, two threads
        self._file = open_owned(path)
        try:
            self._size = os.fstat(self._file.fileno()).st_size
            line = self._read(0, OWNER)
            self.ours = self._size == 0 or line.startswith(SIGNATURE)
            self._token = token_of(line) or new_token()
            self.head, self._first = self._read_head()
        except BaseException:
            self._file.close()
            raise
        # a copy of this journal has the same token and another name
        unique = f"{self._token}-{zlib.crc32(os.fsencode(path.name)):08x}"
        self.temporary = temporary_path(path.parent, unique)
        self._key = self._end = 0
        self._places = self._failed = np.empty(0, dtype=np.int64)
        self._recent: dict[int, Block] = {}
        self._next_sync, self._dropped = 0.0, 0

    def sign(self) -> None:
        """Say who is writing it, for whoever comes second; clean up after who was first."""
        if self.ours:
            self.temporary.unlink(missing_ok=True)
            self._write(0, owner_line(self._token))

    def start(self, head: Mapping[str, Any], cut: Tiling) -> None:
        """Begin anew, whatever was there."""
        text = json.dumps(head, allow_nan=False).encode()
        self._file.truncate(0)
        self._size = 0
        lead = _HEAD.pack(_HEAD_MARK, len(text), zlib.crc32(text))
        self._write(0, owner_line(self._token) + lead + text)
        self._prepare(head, cut, OWNER + _HEAD.size + len(text))
        self.sync()
        sync_folder(self.path.parent)

    def find(self, head: Mapping[str, Any], cut: Tiling) -> None:
        """Find every block of the study that is whole."""
        self._prepare(head, cut, self._first)
        position = self._end
        while position < self._size:
            block = self._block_at(position)
            if block is None:
                position = self._search(position + 1)
                continue
            self._note(block, position)
            position = self._end = position + _record_size(block)

    def carry_on(self) -> None:
        """Continue after the last block found."""
        self._file.truncate(self._end)
        self.sync()

    def _prepare(self, head: Mapping[str, Any], cut: Tiling, end: int) -> None:
        self._key = zlib.crc32(json.dumps(head["study"], allow_nan=False).encode())
        self._cut, self._end = cut, end
        self._places = np.full(len(cut), -1, dtype=np.int64)
        self._failed = np.zeros(len(cut), dtype=np.int64)

    def append(self, block: Block) -> None:
        """Keep a finished block; on an error the journal is as before."""
        sizes = [len(chunk) for chunk in block.chunks]
        check = self._checksum(block.number, block.cases, block.failed, sizes, *block.chunks)
        head = (_MARK, check, block.number, block.cases, block.failed, *sizes)
        try:
            self._write(self._end, _RECORD.pack(*head), *block.chunks)
        except OSError:
            with suppress(OSError):
                self._file.truncate(self._end)
            raise
        self._remember(block)
        self._note(block, self._end)
        self._end += _record_size(block)
        if time.monotonic() >= self._next_sync:
            self.sync()

    def sync(self) -> None:
        """Make what was appended outlast the machine; notice a vanished folder."""
        os.fsync(self._file.fileno())
        self._leave_memory()
        if not is_named(self._file.fileno(), self.path):
            raise FileNotFoundError(
                errno.ENOENT, "the partial results were removed", str(self.path)
            )
        self._next_sync = time.monotonic() + SYNC_EVERY

    def _leave_memory(self) -> None:
        """Give the system its memory back: what is on disk is hardly ever read again.

        Writing the same pages of memory again and again takes a third of the time.
        """
        if hasattr(os, "posix_fadvise"):
            begin, self._dropped = min(self._dropped, self._end), self._end
            with suppress(OSError):  # nothing depends on it
                os.posix_fadvise(
                    self._file.fileno(), begin, self._end - begin, os.POSIX_FADV_DONTNEED
                )

    @property
    def missing(self) -> np.ndarray:
        """Numbers of the blocks that are not here."""
        return np.nonzero(self._places < 0)[0]

    @property
    def blocks(self) -> int:
        """How many are here."""
        return int((self._places >= 0).sum())

    @property
    def failed(self) -> int:
        """Cases without an answer in the blocks that are here."""
        return int(self._failed.sum())

    def block(self, number: int) -> Block | None:
        """A block, None where it is not here; raises OSError where it was damaged since."""
        with self._access:
            recent = self._recent.pop(number, None)
        if recent is not None:
            return recent
        place = int(self._places[number])
        if place < 0:
            return None
        block = self._block_at(place)
        if block is None or block.number != number:
            raise OSError(errno.EIO, f"block {number} of {self.path} is damaged")
        return block

    @property
    def holds_blocks(self) -> bool:
        """Whether there is anything that starting anew would lose."""
        return self._search(self._first) < self._size

    def close(self) -> None:
        """Let others have it; one that never got a block goes."""
        if self._file.closed:
            return
        if self._size == 0 and not self.blocks:
            self.remove()
        self._file.close()

    def remove(self) -> None:
        """Delete it: locked to the end, so that nobody can have begun to use it."""
        try:
            self.path.unlink()
        except OSError:  # where an open file cannot be deleted
            self._file.close()
            with suppress(OSError):
                self.path.unlink()
        self._file.close()

    def _remember(self, block: Block) -> None:
        """Spare whoever asks for it soon to read it back."""
        with self._access:
            self._recent[block.number] = block
            if len(self._recent) > _RECENT:
                del self._recent[next(iter(self._recent))]

    def _note(self, block: Block, position: int) -> None:
        self._places[block.number] = position
        self._failed[block.number] = block.failed

    def _read_head(self) -> tuple[dict[str, Any] | None, int]:
        """The head, and where records begin; they are searched for where it is damaged."""
        lead = self._read(OWNER, _HEAD.size)
        if len(lead) == _HEAD.size:
            mark, size, check = _HEAD.unpack(lead)
            start = OWNER + _HEAD.size
            if mark == _HEAD_MARK and size <= self._size - start:
                text = self._read(start, size)
                if zlib.crc32(text) == check:
                    return json.loads(text), start + size
        return None, min(OWNER, self._size)

    def _block_at(self, position: int) -> Block | None:
        """The block whose record starts here, None where there is no whole one."""
        lead = self._read(position, _RECORD.size)
        if len(lead) < _RECORD.size or not lead.startswith(_MARK):
            return None
        _, check, number, cases, failed, *sizes = _RECORD.unpack(lead)
        # nonsense that begins with the mark must not fill the memory
        if not 0 <= number < len(self._places) or sum(sizes) > 64 * (self._cut.cells + 1000):
            return None
        body = self._read(position + _RECORD.size, sum(sizes))
        if check != self._checksum(number, cases, failed, sizes, body):
            return None
        ends = np.cumsum([0, *sizes]).tolist()
        chunks = tuple(body[a:b] for a, b in pairwise(ends))
        return Block(number, cases, failed, chunks)

    def _checksum(
        self, number: int, cases: int, failed: int, sizes: list[int], *parts: bytes
    ) -> int:
        check = zlib.crc32(_RECORD.pack(_MARK, self._key, number, cases, failed, *sizes))
        for part in parts:
            check = zlib.crc32(part, check)
        return check

    def _search(self, position: int) -> int:
        """Where the next record may start, from `position` on; else the end."""
        while position < self._size:
            window = self._read(position, _SEARCH)
            found = window.find(_MARK)
            if found >= 0:
                return position + found
            position += max(len(window) - len(_MARK) + 1, len(_MARK))
        return self._size

    def _read(self, position: int, size: int) -> bytes:
        """Up to `size` bytes: fewer at the end of the file."""
        parts = []
        with self._access:
            self._file.seek(position)
            while size > 0 and (part := self._file.read(size)):
                parts.append(part)
                size -= len(part)
        return parts[0] if len(parts) == 1 else b"".join(parts)

    def _write(self, position: int, *parts: bytes) -> None:
        with self._access:
            self._file.seek(position)
            for part in parts:
                view = memoryview(part)
                while view:
                    view = view[self._file.write(view) :]


def _record_size(block: Block) -> int:
    return _RECORD.size + sum(len(chunk) for chunk in block.chunks)
