"""Finished blocks of an unfinished file: rows of a SQLite database, each with a checksum.

Row -1 identifies the study, the others are blocks by their numbers. The checksum of a row also
covers the study, so that a damaged or foreign row is never accepted.
"""

import errno
import json
import os
import sqlite3
import struct
import time
import warnings
import zlib
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import replace
from itertools import chain
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
_OLD = b"escapement partial results, "  # how the partial results of version 0.1 begin
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
    "earlier": "has partial results of an earlier version in {name}, got a run of this version; "
    "finish them with that version, or start over with force=True (--force)",
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
        When another process writes it, or it holds something else.
    OSError
        When it cannot be opened.

    Attributes
    ----------
    failed : dict of int
        Failed cases of the blocks that are here, by number.
    """

    def __init__(self, path: Path, named: Any, *, force: bool, resume: bool) -> None:
        self.path, self._named, self._force, self._resume = path, named, force, resume
        self.failed: dict[int, int] = {}
        self._begun = not path.exists()  # a new file that gets no block is removed
        self._next_sync = time.monotonic() + SYNC_EVERY
        self._open()

    def begin(self, frame: Study, numerics: str, blocks: int) -> Study:
        """Find the blocks that are there, or start again.

        Parameters
        ----------
        frame : Study
            Everything but the results.
        numerics : str
            Differs whenever a version of this package may compute other results.
        blocks : int
            How many the study has.

        Returns
        -------
        Study
            The frame with the attributes of the start.

        Raises
        ------
        CannotCreate
            When there are results of another study, or results for which the user must give
            `resume` or `force`.
        """
        attributes = dict(frame.attributes)
        fixed = {name: attributes.pop(name) for name in _FIXED_AT_START}
        study = {"attributes": attributes, "configuration": frame.configuration}
        head = json.loads(json.dumps({"study": study | {"numerics": numerics}, "fixed": fixed}))
        self._key = zlib.crc32(json.dumps(head["study"]).encode())
        rows = self._value(f"SELECT count(*) FROM {_TABLE}")
        first, sound = self._read(_HEAD), True
        if self._resume:
            there = head if first is None else json.loads(first.data)
            old, new = there["study"], head["study"]
            if text := difference(old, new):
                raise self._refusal("other", text)
            if old["numerics"] != new["numerics"]:
                versions = (
                    f"{h['fixed']['package_version']} ({h['study']['numerics']})"
                    for h in (there, head)
                )
                raise self._refusal("version", *versions)
            head = there
            found = filter(None, map(self._read, range(blocks)))
            self.failed = {block.number: block.failed for block in found}
            sound = self._value("PRAGMA quick_check(1)") == "ok"
            sound &= rows == len(self.failed) + (first is not None)
        elif rows != 0 and not self._force:
            raise self._refusal("ours")
        if not sound:
            self._warn()
        self._begun = True
        row = Block(_HEAD, 0, json.dumps(head, allow_nan=False).encode())
        if not sound or (rows != 0 and not self.failed):
            self._renew(row)
        else:
            self._put(row)
        sync_folder(self.path.parent)
        return replace(frame, attributes=frame.attributes | head["fixed"])

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
        """A stored block; raises OSError if it was damaged since."""
        block = self._read(number)
        if block is None:
            raise OSError(errno.EIO, f"block {number} of {self.path} is damaged")
        return block

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
        until = time.monotonic() + _PATIENCE
        while True:
            try:
                self._database = _connect(self.path)
                # The previous owner may have removed the file while this process waited for it.
                self._inode = self.path.stat().st_ino
                return
            except FileNotFoundError:
                self._database.close()
            except Damaged:
                self._replace_damaged()
            except BlockingIOError:
                if time.monotonic() > until:
                    raise self._refusal("busy") from None
            except OSError:
                if self._begun:
                    _remove(self.path)
                raise
            time.sleep(0.05)

    def _replace_damaged(self) -> None:
        """Remove a database that SQLite cannot open, if it is ours and may be deleted."""
        with open(self.path, "rb") as file:
            head = file.read(1 << 17)
        marked = _TABLE.encode() in head or head[68:72] == _APPLICATION.to_bytes(4, "big")
        kind = "earlier" if head.startswith(_OLD) else "ours" if marked else "foreign"
        force, resume = self._force, self._resume
        if not {"earlier": force and not resume, "ours": force or resume}.get(kind):
            raise self._refusal(kind)
        if marked:
            self._warn()
        _remove(self.path)

    def _renew(self, head: Block) -> None:
        """Copy a head and all intact rows to a new database, which replaces this one."""
        new = self.path.with_name(self.path.name + "-new")
        _remove(new)
        with closing(_connect(new)) as database, _os_errors(new):
            for block in chain([head], map(self.block, self.failed)):
                database.execute(*_insertion(block, self._key))
        self._database.close()
        # The log of the old database must not be applied to the new one.
        _remove(self.path, _ENDS[:-1])
        os.replace(new, self.path)
        self._open()

    def _execute(self, text: str, values: tuple[Any, ...] = ()) -> list[Any]:
        with _os_errors(self.path):
            return self._database.execute(text, values).fetchall()

    def _value(self, query: str) -> Any:
        """The result of a query, None if the database is damaged."""
        with suppress(Damaged):
            return self._execute(query)[0][0]
        return None

    def _put(self, block: Block) -> None:
        self._execute(*_insertion(block, self._key))

    def _read(self, number: int) -> Block | None:
        """The block of a row, None if it is missing or damaged."""
        query = f"SELECT failed, data, checksum FROM {_TABLE} WHERE number = ?"
        # a damaged row may hold values of other types, or out of range
        with suppress(Damaged, ValueError, TypeError, OverflowError, struct.error):
            for failed, data, checksum in self._execute(query, (number,)):
                block = Block(number, failed, data)
                if _checksum(block, self._key) == checksum:
                    return block
        return None

    def _warn(self) -> None:
        warnings.warn(f"{self.path.name} is damaged; what was lost is computed again", stacklevel=2)

    def _refusal(self, why: str, *got: str) -> CannotCreate:
        text = _REFUSALS[why].format(*got, name=self.path.name)
        return CannotCreate(f"output {self._named} {text}")


def _connect(path: Path) -> sqlite3.Connection:
    """An open and locked database with our table; raises `Damaged` if there is another one."""
    with _os_errors(path):
        database = sqlite3.connect(path, timeout=0.0, isolation_level=None, check_same_thread=False)
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


def _insertion(block: Block, key: int) -> tuple[str, tuple[Any, ...]]:
    row = (block.number, block.failed, _checksum(block, key), block.data)
    return f"INSERT OR REPLACE INTO {_TABLE} VALUES (?, ?, ?, ?)", row


def _checksum(block: Block, key: int) -> int:
    """Checksum of a row; that of the head does not include the study, which it identifies."""
    head = struct.pack("<qqI", block.number, block.failed, 0 if block.number == _HEAD else key)
    return zlib.crc32(block.data, zlib.crc32(head))


def _remove(path: Path, ends: tuple[str, ...] = _ENDS) -> None:
    for end in ends:
        path.with_name(path.name + end).unlink(missing_ok=True)
