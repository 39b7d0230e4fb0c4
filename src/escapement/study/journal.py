"""Finished blocks of an unfinished file: rows of a SQLite database, each with a checksum.

Row -1 identifies the study, the others are blocks by their numbers. The checksum of a row also
covers the study, so that a damaged or foreign row is never accepted. SQLite keeps every finished
row through a kill or a power failure. A database that is damaged all the same is refused.
"""

import errno
import json
import os
import sqlite3
import struct
import time
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from escapement.base.errors import CannotCreate
from escapement.base.files import sync_folder
from escapement.study.block import Block
from escapement.study.configuration import difference
from escapement.study.result import Study

SYNC_EVERY = 1.0
"""Seconds of work that a crash of the machine may cost; one of the process costs none."""

_PATIENCE = 2.0  # s to wait for a killed process whose files are not closed yet
_TABLE = "escapement_partial_results"
_COLUMNS = "number INTEGER PRIMARY KEY, failed INTEGER, checksum INTEGER, data BLOB"
_SCHEMA = f"CREATE TABLE {_TABLE} ({_COLUMNS})"
_APPLICATION = 0x45534370  # at byte 68 of our databases
_HEAD = -1  # number of the row that says which study this is
_PRAGMAS = ("journal_mode = WAL", "synchronous = NORMAL", "wal_autocheckpoint = 0")
# A page of 16384 bytes is twice as fast for large rows as the 4096 of SQLite.
_NEW = ("page_size = 16384", *_PRAGMAS, f"application_id = {_APPLICATION}")
# Errors of the machine. All others mean damage: a wrong byte can cause almost any error of
# SQLite.
_MACHINE = "BUSY", "FULL", "IOERR", "CANTOPEN", "NOMEM", "READONLY"
_ENDS = ("-wal", "-journal", "")
"""Of the names of the log, the journal of SQLite, and the database itself."""
_FIXED_AT_START = ("created", "package_version")
"""Attributes that a resumed study takes over, so that its file is that of one run."""
_REFUSALS = {
    "busy": "must not be in use, and another process is writing it; wait, or name another output",
    "damaged": "must be resumed from whole partial results, and {name} is damaged; start over with "
    "force=True (--force) and without resume",
    "ours": "must not have partial results yet, got {name}; continue with resume=True (--resume) "
    "or start over with force=True (--force)",
    "other": "must be resumed with the configuration it was begun with, got another: {}; use that "
    "one, name another output, or start over with force=True (--force)",
    "version": "must be resumed by the version that began it, {}, got {}, whose results may "
    "differ; install that one, or start over with force=True",
    "foreign": "must have {name} to itself, got a file that is no partial result; move it away",
}


class Damaged(OSError):
    """The database is damaged; this is not an error of the machine."""


class Journal:
    """The partial results at `path`, locked for this process; created if there are none.

    Parameters
    ----------
    path : Path
        Path of the database.
    named : path
        The output as the user named it, for messages.
    force, resume : bool
        As for `study_writer`.

    Raises
    ------
    CannotCreate
        When another process writes it, it is damaged, or it holds something else.
    OSError
        When it cannot be opened.

    Attributes
    ----------
    failed : dict of int
        Failed cases of the blocks that are here, by number.
    """

    def __init__(self, path: Path, named: Any, *, force: bool, resume: bool) -> None:
        self.path, self._named = path, named
        self._over, self._resume = force and not resume, resume
        self.failed: dict[int, int] = {}
        self._begun = not path.exists()  # a new file that gets no block is removed
        self._next_sync = time.monotonic() + SYNC_EVERY
        self._open()

    def begin(self, frame: Study, numerics: str) -> Study:
        """Find the blocks that are there, or start again.

        Parameters
        ----------
        frame : Study
            Everything but the results.
        numerics : str
            Differs whenever a version of this package may compute other results.

        Returns
        -------
        Study
            The frame with the attributes of the start.

        Raises
        ------
        CannotCreate
            When there are results of another study, damaged ones, or results for which the user
            must give `resume` or `force`.
        """
        attributes = dict(frame.attributes)
        fixed = {name: attributes.pop(name) for name in _FIXED_AT_START}
        study = {"attributes": attributes, "configuration": frame.configuration}
        head = json.loads(json.dumps({"study": study | {"numerics": numerics}, "fixed": fixed}))
        self._key = zlib.crc32(json.dumps(head["study"]).encode())
        try:
            there = self._found(head)
        except Damaged:
            raise self._refusal("damaged" if self._resume else "ours") from None
        self._begun = True
        if there is None:
            self._put(Block(_HEAD, 0, json.dumps(head, allow_nan=False).encode()))
        sync_folder(self.path.parent)
        return replace(frame, attributes=frame.attributes | (there or head)["fixed"])

    def _found(self, head: dict[str, Any]) -> dict[str, Any] | None:
        """The head that is there, None in a new database; raises `Damaged`, and as `begin`."""
        numbers = {number for (number,) in self._execute(f"SELECT number FROM {_TABLE}")}
        if numbers and not self._resume:
            raise self._refusal("ours")
        if self._execute("PRAGMA quick_check(1)") != [("ok",)]:
            raise Damaged(errno.EIO, "SQLite found damage")
        if not numbers:
            return None
        there: dict[str, Any] = json.loads(self.block(_HEAD).data)
        if text := difference(there["study"], head["study"]):
            raise self._refusal("other", text)
        if there["study"]["numerics"] != head["study"]["numerics"]:
            versions = (
                f"{h['fixed']['package_version']} ({h['study']['numerics']})" for h in (there, head)
            )
            raise self._refusal("version", *versions)
        self.failed = {number: self.block(number).failed for number in numbers - {_HEAD}}
        return there

    def append(self, block: Block) -> None:
        """Keep a finished block; after an error the other blocks are unchanged."""
        self._put(block)
        self.failed[block.number] = block.failed
        if time.monotonic() >= self._next_sync:
            self._execute("PRAGMA wal_checkpoint")  # these rows now survive a crash
            self.check()
            self._next_sync = time.monotonic() + SYNC_EVERY

    def check(self) -> None:
        """Raise FileNotFoundError where the folder or the file has vanished."""
        if not self.path.exists() or self.path.stat().st_ino != self._inode:
            message = "the partial results were removed"
            raise FileNotFoundError(errno.ENOENT, message, str(self.path))

    def block(self, number: int) -> Block:
        """A stored block; raises `Damaged` if it is not the one that was stored."""
        query = f"SELECT failed, data, checksum FROM {_TABLE} WHERE number = ?"
        # a damaged row may hold values of other types
        with suppress(TypeError, struct.error):
            for failed, data, checksum in self._execute(query, (number,)):
                block = Block(number, failed, data)
                if _checksum(block, self._key) == checksum:
                    return block
        raise Damaged(errno.EIO, f"row {number} of {self.path.name} is damaged")

    def close(self) -> None:
        """Release it for other processes; a new one without a block is deleted."""
        self._database.close()
        if self._begun and not self.failed:
            self.remove()

    def remove(self) -> None:
        """Delete it."""
        # If the files can be deleted first, SQLite does not write its log into the database
        # needlessly.
        # The database is deleted last, because another process may start once its name is free.
        with suppress(OSError):
            _remove(self.path)
        self._database.close()
        if os.name == "nt":  # Windows does not remove an open file
            with suppress(OSError):
                _remove(self.path)

    def _open(self) -> None:
        try:
            try:
                self._database = _connect(self.path)
                if self._over and not self._begun:
                    self.remove()
            except Damaged:
                self._refuse_damaged()
                _remove(self.path)
            if not self.path.exists():
                self._begun = True
                self._database = _connect(self.path)
            self._inode = self.path.stat().st_ino
        except BlockingIOError:
            raise self._refusal("busy") from None
        except OSError:
            if self._begun:
                _remove(self.path)
            raise

    def _refuse_damaged(self) -> None:
        """Refuse a file that SQLite cannot open, unless it is ours and may be deleted."""
        with open(self.path, "rb") as file:
            head = file.read(1 << 17)
        ours = _TABLE.encode() in head or head[68:72] == _APPLICATION.to_bytes(4, "big")
        if not (ours and self._over):
            raise self._refusal(("damaged" if self._resume else "ours") if ours else "foreign")

    def _execute(self, text: str, values: tuple[Any, ...] = ()) -> list[Any]:
        with _os_errors(self.path):
            return self._database.execute(text, values).fetchall()

    def _put(self, block: Block) -> None:
        row = (block.number, block.failed, _checksum(block, self._key), block.data)
        self._execute(f"INSERT OR REPLACE INTO {_TABLE} VALUES (?, ?, ?, ?)", row)

    def _refusal(self, why: str, *got: str) -> CannotCreate:
        text = _REFUSALS[why].format(*got, name=self.path.name)
        return CannotCreate(f"output {self._named} {text}")


def _connect(path: Path) -> sqlite3.Connection:
    """An open and locked database with our table; raises `Damaged` if there is another one."""
    with _os_errors(path):
        database = sqlite3.connect(
            path, timeout=_PATIENCE, isolation_level=None, check_same_thread=False
        )
        try:
            # The order matters: if the lock is held before the log is opened, no shared memory is
            # needed, so the log works on network mounts too.
            database.execute("PRAGMA locking_mode = EXCLUSIVE").fetchone()
            database.execute("BEGIN EXCLUSIVE")
            tables = dict(database.execute("SELECT name, sql FROM sqlite_master").fetchall())
            database.execute("ROLLBACK")
            if tables not in ({}, {_TABLE: _SCHEMA}):
                raise sqlite3.DatabaseError("the table is damaged")
            for pragma in _PRAGMAS if tables else _NEW:
                database.execute(f"PRAGMA {pragma}").fetchall()
            if not tables:
                database.execute(_SCHEMA)
        except BaseException:
            database.close()
            raise
    return database


@contextmanager
def _os_errors(path: Path) -> Iterator[None]:
    """Turn errors of SQLite into OSError, which `Damaged` is a kind of."""
    try:
        yield
    except UnicodeDecodeError:  # the message of SQLite contains a damaged schema
        raise Damaged(errno.EIO, "the table is damaged") from None
    except sqlite3.Error as error:
        code = getattr(error, "sqlite_errorcode", 0) & 0xFF
        name = next((name for name in _MACHINE if getattr(sqlite3, f"SQLITE_{name}") == code), "")
        # A damaged number of the format makes a file that may be written read-only.
        if not name or (name == "READONLY" and os.access(path, os.W_OK)):
            raise Damaged(errno.EIO, str(error)) from None
        number = {"FULL": errno.ENOSPC, "BUSY": errno.EAGAIN}.get(name, errno.EIO)
        raise OSError(number, str(error)) from None


def _checksum(block: Block, key: int) -> int:
    """Checksum of a row; that of the head does not include the study, which it identifies."""
    head = struct.pack("<qqI", block.number, block.failed, 0 if block.number == _HEAD else key)
    return zlib.crc32(block.data, zlib.crc32(head))


def _remove(path: Path) -> None:
    for end in _ENDS:
        path.with_name(path.name + end).unlink(missing_ok=True)
