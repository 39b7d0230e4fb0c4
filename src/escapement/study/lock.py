"""A lock on an open file: held by one process at a time, and gone when that one dies."""

import os
import sys
from pathlib import Path

_ENDING = ("Z", "X", "D")  # dead, and waiting for a disk: a sound process soon is no longer
_KILLED = 1 << 8  # SIGKILL, in a mask of signals

if sys.platform == "win32":
    import msvcrt

    _FAR = 1 << 40  # Windows locks bytes, and nobody may read a locked one

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

    One that is killed while its disk is busy holds its files until the disk has
    answered. Where the system does not tell, only one that is gone counts.
    """
    if sys.platform == "win32":
        return False  # it has no signal that merely asks
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
