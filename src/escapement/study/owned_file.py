"""A file that one process at a time may have open; its first line says which.

The open file carries the lock, which is gone when the process that holds it dies.
"""

import os
import re
import socket
import sys
import time
from pathlib import Path
from typing import BinaryIO

from escapement.errors import CannotCreate

SIGNATURE = b"escapement partial results, "
"""How the first line begins."""
OWNER = 128
"""Length of the first line [bytes]."""

_PATIENCE = 0.5  # s to wait for a process that may be about to finish
_LONG_PATIENCE = 20.0  # s to wait for a killed process, whose disk may be slow
_OWNER = re.compile(SIGNATURE + rb"(process (\d+) on (.*?)) *(?: token ([0-9a-f]{16}))?\n")
# States in /proc of a process that is dead, or that waits for a disk. A healthy process is in
# the last one for a moment only.
_ENDING = ("Z", "X", "D")
_KILLED = 1 << 8  # SIGKILL, in a mask of signals

if sys.platform == "win32":
    import msvcrt

    _FAR = 1 << 40  # Windows locks bytes, and no other process may read a locked byte

    def try_lock(descriptor: int) -> bool:
        """Lock an open file until it is closed; False where another holds it."""
        os.lseek(descriptor, _FAR, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except PermissionError:
            return False
        return True

else:
    import fcntl

    def try_lock(descriptor: int) -> bool:
        """Lock an open file until it is closed; False where another holds it.

        Raises OSError where the file system knows no locks.
        """
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True


def is_ending(process: int) -> bool:
    """Whether a process of this machine is gone, or killed and on its way.

    A process that is killed while its disk is busy keeps its files open until the disk
    has answered. Where the system has no /proc, only a process that is gone counts.
    """
    if sys.platform == "win32":
        return False  # Windows has no signal that only asks whether a process lives
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except OSError:
        return False
    try:
        text = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return False
    fields = dict(line.split(":\t", 1) for line in text.splitlines() if ":\t" in line)
    pending = int(fields.get("SigPnd", "0"), 16) | int(fields.get("ShdPnd", "0"), 16)
    return fields.get("State", "")[:1] in _ENDING or bool(pending & _KILLED)


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
    # an owner that has not written its first line was killed before it could
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
