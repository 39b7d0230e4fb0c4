"""A file that one process at a time may have open; its first line says which.

The file is its own lock.
"""

import os
import re
import socket
import time
from pathlib import Path
from typing import BinaryIO

from escapement.errors import CannotCreate
from escapement.study.lock import is_ending, try_lock

SIGNATURE = b"escapement partial results, "
"""How the first line begins."""
OWNER = 128
"""Length of the first line."""

_PATIENCE = 0.5  # s for which a lock may be held by someone who is about to let go
_LONG_PATIENCE = 20.0  # s for a killed process: as long as a disk may take


_OWNER = re.compile(SIGNATURE + rb"(process (\d+) on (.*?)) *(?: token ([0-9a-f]{16}))?\n")


def owner_line(token: str) -> bytes:
    """First line of a file of this process, with the token of its temporary file."""
    end = f" token {token}\n".encode()
    line = SIGNATURE + f"process {os.getpid()} on {socket.gethostname()}".encode()
    return line[: OWNER - len(end)].ljust(OWNER - len(end)) + end


def token_of(line: bytes) -> str | None:
    """The token in a first line, None where it has none."""
    owner = _OWNER.fullmatch(line)
    return None if owner is None or owner[4] is None else owner[4].decode()


def open_owned(path: Path) -> BinaryIO:
    """The file under `path`, created where there is none, for this process alone.

    Raises
    ------
    CannotCreate
        When another process has it.
    OSError
        When it cannot be opened or locked.
    """
    begin = time.monotonic()
    while True:
        file = open(os.open(path, os.O_RDWR | os.O_CREAT, 0o666), "r+b", buffering=0)  # noqa: SIM115
        try:
            if not try_lock(file.fileno()):
                _wait_for(file, path, time.monotonic() - begin)
            elif is_named(file.fileno(), path):
                return file  # else its last owner has just finished and removed it
        except BaseException:
            file.close()
            raise
        file.close()


def _wait_for(file: BinaryIO, path: Path, waited: float) -> None:
    """Wait a little for the owner of the lock; raises CannotCreate where that is no use."""
    line = file.read(OWNER)
    owner = _OWNER.match(line)
    here = owner is not None and owner[3].decode(errors="replace") == socket.gethostname()
    # who has not even said its name was killed before it could
    ending = not line or (owner is not None and here and is_ending(int(owner[2])))
    if waited > (_LONG_PATIENCE if ending else _PATIENCE):
        name = "another process" if owner is None else owner[1].decode(errors="replace")
        raise CannotCreate(
            f"output {path.with_suffix('')} must not be in use, and {name} is writing it; "
            "wait, or name another output"
        )
    time.sleep(0.05)


def is_named(descriptor: int, path: Path) -> bool:
    """Whether `path` still names the open file."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False
