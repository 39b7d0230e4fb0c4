"""Finished blocks beside the file to come: rows of a SQLite database, each with a checksum.

Row -1 says which study this is, the others are blocks by their numbers. The checksum of a row
also covers the study, so that a damaged or foreign row is never taken for good.
"""

import errno
import json
import os
import sqlite3
import struct
import time
import warnings
import zlib
from collections.abc import Callable
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

from escapement.errors import CannotCreate
from escapement.files import sync_folder
from escapement.study.block import Block, Tiling
from escapement.study.identity import check_same
from escapement.study.result import RESULTS

SYNC_EVERY = 1.0
"""Seconds of finished work that a crash of the machine may cost; of the process, none."""

_PATIENCE = 2.0  # s to wait for a killed process whose files are not closed yet
_OLD = b"escapement partial results, "  # how the partial results of version 0.1 begin
_TABLE = "escapement_partial_results"
_APPLICATION = 0x45534370  # at byte 68 of our databases
_PAGE = 16384  # bytes; twice as fast for large rows as the 4096 of SQLite
_HEAD = -1  # number of the row that says which study this is
_SIZES = struct.Struct(f"<{len(RESULTS)}I")
_COLUMNS = "number INTEGER PRIMARY KEY, failed INTEGER, checksum INTEGER, data BLOB"
# Errors of the machine. All others mean damage: a wrong byte can make SQLite say almost anything.
_MACHINE = (
    *(sqlite3.SQLITE_BUSY, sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_CANTOPEN),
    *(sqlite3.SQLITE_NOMEM, sqlite3.SQLITE_READONLY),
)

T = TypeVar("T")


class Journal:
    """The partial results at `path`, for this process alone; created where there are none.

    Parameters
    ----------
    path : Path
        Of the database.
    named : path
        The output as the user named it, for messages.
    force, resume : bool
        As for `StudyWriter`.

    Raises
    ------
    CannotCreate
        When another process writes it, or it holds something else.
    OSError
        When it cannot be opened.
    """

    def __init__(self, path: Path, named: Any, *, force: bool, resume: bool) -> None:
        self.path, self._named, self._force, self._resume = path, named, force, resume
        self.failed: dict[int, int] = {}
        self._begun = not path.exists()  # what is new, and gets no block, does not stay
        self._next_sync = time.monotonic() + SYNC_EVERY
        self._open()

    def begin(self, head: dict[str, Any], cut: Tiling) -> dict[str, Any]:
        """Find the blocks that are here, or start anew; returns the attributes of the start.

        Raises
        ------
        CannotCreate
            When there are results of another study, or the user has to say what becomes
            of those that are here.
        """
        self._cut, self._key = cut, zlib.crc32(json.dumps(head["study"]).encode())
        there = self._read_head()
        if self._resume:
            if there is not None:
                check_same(self._named, there, head)
            self._find()
            head = there or head
        elif not self._force and self._tried(self._any_rows) is not False:
            raise self._exists()
        self._begun = True
        if not self.failed:
            self._start_anew()
        if there is None or not self.failed:
            text = json.dumps(head, allow_nan=False).encode()
            _guarded(lambda: self._put(_HEAD, 0, text, 0))
        sync_folder(self.path.parent)
        fixed: dict[str, Any] = head["fixed"]
        return fixed

    def append(self, block: Block) -> None:
        """Keep a finished block; on an error the others are as before."""
        data = b"".join((_SIZES.pack(*map(len, block.chunks)), *block.chunks))
        _guarded(lambda: self._put(block.number, block.failed, data, self._key))
        self.failed[block.number] = block.failed
        if time.monotonic() >= self._next_sync:
            self.sync()

    def sync(self) -> None:
        """Make what was appended outlast the machine."""
        _guarded(lambda: self._database.execute("PRAGMA wal_checkpoint").fetchall())
        self.check()
        self._next_sync = time.monotonic() + SYNC_EVERY

    def check(self) -> None:
        """Raise FileNotFoundError where the folder or the file has vanished."""
        if not self.path.exists() or self.path.stat().st_ino != self._inode:
            message = "the partial results were removed"
            raise FileNotFoundError(errno.ENOENT, message, str(self.path))

    def block(self, number: int) -> Block:
        """A block that is here; raises OSError where it was damaged since."""
        block = _guarded(lambda: self._block(number))
        if block is None:
            raise OSError(errno.EIO, f"block {number} of {self.path} is damaged")
        return block

    @property
    def missing(self) -> list[int]:
        """Numbers of the blocks that are not here."""
        return [number for number in range(len(self._cut)) if number not in self.failed]

    def close(self) -> None:
        """Let others have it; one that never got a block goes."""
        self._database.close()
        if self._begun and not self.failed:
            self.remove()

    def remove(self) -> None:
        """Delete it."""
        # Where the files can go first, SQLite does not write its log into the database in vain.
        # The database goes last, because another process may begin once its name is free.
        with suppress(OSError):
            _remove_files(self.path)
        self._database.close()
        if os.name == "nt":  # where an open file stays
            with suppress(OSError):
                _remove_files(self.path)

    def _open(self) -> None:
        until = time.monotonic() + _PATIENCE
        while True:
            try:
                self._database = _connect(self.path, self._foreign)
                # The owner before may have removed the file while this process waited for it.
                self._inode = self.path.stat().st_ino
                return
            except FileNotFoundError:
                self._database.close()
            except sqlite3.Error as error:
                code = getattr(error, "sqlite_errorcode", 0) & 0xFF
                # A damaged number of the format makes a file that may be written read-only.
                odd = code == sqlite3.SQLITE_READONLY and os.access(self.path, os.W_OK)
                if code not in _MACHINE or odd:
                    self._replace_damaged()
                elif code != sqlite3.SQLITE_BUSY:
                    if self._begun:
                        _remove_files(self.path)
                    raise _os_error(error) from None
                elif time.monotonic() > until:
                    raise CannotCreate(
                        f"output {self._named} must not be in use, and another process is writing "
                        "it; wait, or name another output"
                    ) from None
            time.sleep(0.05)

    def _replace_damaged(self) -> None:
        """Remove a database that SQLite cannot open, where it is ours and may go."""
        with open(self.path, "rb") as file:
            head = file.read(1 << 17)
        if head.startswith(_OLD):
            if not self._force or self._resume:
                raise CannotCreate(
                    f"output {self._named} has partial results of an earlier version in "
                    f"{self.path.name}, got a run of this version; finish them with that version, "
                    "or start over with force=True (--force)"
                )
        elif _TABLE.encode() not in head and head[68:72] != _APPLICATION.to_bytes(4, "big"):
            raise self._foreign()
        elif not (self._force or self._resume):
            raise self._exists()
        else:
            self._warn()
        _remove_files(self.path)

    def _start_anew(self) -> None:
        """Nothing of what was there is kept, nor is space for it."""
        if self._tried(self._any_rows) is False:
            return
        self._database.close()
        _remove_files(self.path)
        self._open()

    def _find(self) -> None:
        """Find every block of the study that is whole, and leave a damaged database behind."""

        def check() -> bool:
            return bool(self._database.execute("PRAGMA quick_check(1)").fetchone()[0] == "ok")

        count, sound = 0, self._tried(check) is True
        for number in range(_HEAD, len(self._cut)):
            row = self._tried(lambda number=number: self._row(number))  # type: ignore[misc]
            count += row is not None
            if number != _HEAD and (block := self._tried(lambda row=row: self._decoded(row))):  # type: ignore[misc]
                self.failed[number] = block.failed
        if not sound or count > len(self.failed) + 1:
            self._warn()
            self._rescue()

    def _rescue(self) -> None:
        """Copy the blocks that are whole to a new database, which takes the place of this one."""
        head = self._tried(self._read_head)
        new = self.path.with_name(self.path.name + "-new")
        _guarded(lambda: self._copy(new, head))
        self._database.close()
        # What waits in the log of the damaged database must not go into the new one.
        for path in _files(self.path)[:-1]:
            path.unlink(missing_ok=True)
        os.replace(new, self.path)
        self._open()

    def _copy(self, new: Path, head: dict[str, Any] | None) -> None:
        _remove_files(new)
        database = _connect(new, self._foreign)
        try:
            wanted = [*([_HEAD] if head is not None else []), *self.failed]
            for number in wanted:
                _insert(database, self._row(number) or ())
        finally:
            database.close()

    def _tried(self, read: Callable[[], T]) -> T | None:
        """What `read` gives, None where the database is damaged."""
        try:
            return read()
        except sqlite3.Error as error:
            if getattr(error, "sqlite_errorcode", 0) & 0xFF in _MACHINE:
                raise _os_error(error) from None
        except (ValueError, TypeError, OverflowError, struct.error):
            pass  # a row whose values are of other types, or out of range
        return None

    def _any_rows(self) -> bool:
        return self._database.execute(f"SELECT 1 FROM {_TABLE} LIMIT 1").fetchone() is not None

    def _row(self, number: int) -> tuple[Any, ...] | None:
        text = f"SELECT number, failed, checksum, data FROM {_TABLE} WHERE number = ?"
        row: tuple[Any, ...] | None = self._database.execute(text, (number,)).fetchone()
        return row

    def _put(self, number: int, failed: int, data: bytes, key: int) -> None:
        _insert(self._database, (number, failed, _checksum(number, failed, data, key), data))

    def _read_head(self) -> dict[str, Any] | None:
        row = self._tried(lambda: self._row(_HEAD))
        if row is None:
            return None
        number, failed, checksum, data = row
        if self._tried(lambda: _checksum(number, failed, data, 0)) != checksum:
            return None
        head: dict[str, Any] = json.loads(data)
        return head

    def _block(self, number: int) -> Block | None:
        return self._tried(lambda: self._decoded(self._row(number)))

    def _decoded(self, row: tuple[Any, ...] | None) -> Block | None:
        """The block of a row, None where it is damaged."""
        if row is None:
            return None
        number, failed, checksum, data = row
        if _checksum(number, failed, data, self._key) != checksum:
            return None
        sizes = _SIZES.unpack_from(data)
        ends = [_SIZES.size]
        for size in sizes:
            ends.append(ends[-1] + size)
        start, stop = self._cut.span(number)
        return Block(number, stop - start, failed, tuple(data[a:b] for a, b in pairwise(ends)))

    def _warn(self) -> None:
        warnings.warn(f"{self.path.name} is damaged; what was lost is computed again", stacklevel=2)

    def _exists(self) -> CannotCreate:
        return CannotCreate(
            f"output {self._named} must not have partial results yet, got {self.path.name}; "
            "continue with resume=True (--resume) or start over with force=True (--force)"
        )

    def _foreign(self) -> CannotCreate:
        return CannotCreate(
            f"output {self._named} must have {self.path.name} to itself, got a file that "
            "is no partial result; move it away"
        )


def _connect(path: Path, foreign: Callable[[], CannotCreate]) -> sqlite3.Connection:
    """An open and locked database with our table; `foreign` makes the error for another one."""
    database = sqlite3.connect(path, timeout=0.0, isolation_level=None, check_same_thread=False)
    try:
        # The order counts: a lock held before the log is opened needs no shared memory, so that
        # the log works on network mounts too.
        database.execute("PRAGMA locking_mode = EXCLUSIVE").fetchone()
        database.execute("BEGIN EXCLUSIVE")
        tables = dict(database.execute("SELECT name, sql FROM sqlite_master").fetchall())
        mark = database.execute("PRAGMA application_id").fetchone()[0]
        database.execute("ROLLBACK")
        if tables and _TABLE not in tables and mark != _APPLICATION:
            raise foreign()
        if tables and tables != {_TABLE: f"CREATE TABLE {_TABLE} ({_COLUMNS})"}:
            raise sqlite3.DatabaseError("the table is damaged")
        if not tables:
            database.execute(f"PRAGMA page_size = {_PAGE}")
        database.execute("PRAGMA journal_mode = WAL").fetchone()
        database.execute("PRAGMA synchronous = NORMAL")
        database.execute("PRAGMA wal_autocheckpoint = 0").fetchone()
        if not tables:
            database.execute(f"PRAGMA application_id = {_APPLICATION}")
        database.execute(f"CREATE TABLE IF NOT EXISTS {_TABLE} ({_COLUMNS})")
    except UnicodeDecodeError:  # SQLite complains in the words of a damaged schema
        database.close()
        raise sqlite3.DatabaseError("the table is damaged") from None
    except BaseException:
        database.close()
        raise
    return database


def _insert(database: sqlite3.Connection, row: tuple[Any, ...]) -> None:
    database.execute(f"INSERT OR REPLACE INTO {_TABLE} VALUES (?, ?, ?, ?)", row)


def _checksum(number: int, failed: int, data: bytes, key: int) -> int:
    return zlib.crc32(data, zlib.crc32(struct.pack("<qqI", number, failed, key)))


def _files(path: Path) -> list[Path]:
    """The log, the journal of SQLite, and the database itself."""
    return [path.with_name(path.name + end) for end in ("-wal", "-journal", "")]


def _remove_files(path: Path) -> None:
    for file in _files(path):
        file.unlink(missing_ok=True)


def _guarded(use: Callable[[], T]) -> T:
    """What `use` of the database gives, its errors as OSError."""
    try:
        return use()
    except sqlite3.Error as error:
        raise _os_error(error) from None


def _os_error(error: sqlite3.Error) -> OSError:
    full = getattr(error, "sqlite_errorcode", 0) & 0xFF == sqlite3.SQLITE_FULL
    return OSError(errno.ENOSPC if full else errno.EIO, str(error))
