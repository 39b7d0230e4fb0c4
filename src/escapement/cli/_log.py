"""Events of a command as JSON lines in the file of --log, for job scripts."""

import json
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TextIO

from escapement import __version__
from escapement.base.errors import CannotCreate
from escapement.base.files import check_target, creating

_BEGIN = '{"time":'

_file: TextIO | None = None
_begun = 0.0


def start(path: Path, arguments: Sequence[str]) -> None:
    """Begin to record into a file, at its end where it exists.

    Raises
    ------
    CannotCreate
        When the file cannot be written, or is not a log that --log began.
    """
    global _file, _begun
    check_target(path, force=True, writable=True)
    with creating(path):
        file = open(path, "a+", encoding="utf-8", errors="replace")  # noqa: SIM115
    file.seek(0)
    if file.read(len(_BEGIN)) not in ("", _BEGIN):
        file.close()
        raise CannotCreate(f"log {path} must be new or a log, got another file; name another")
    _file, _begun = file, time.monotonic()
    record("start", arguments=[*arguments], version=__version__)


def end(code: int) -> None:
    """Record the exit code and close the file."""
    global _file
    record("end", exit_code=code, seconds=round(time.monotonic() - _begun, 3))
    if _file is not None:
        _file.close()
        _file = None


def record(event: str, **fields: Any) -> None:
    """Add a line, if there is a log."""
    global _file
    if _file is None:
        return
    now = datetime.now(UTC).isoformat(timespec="milliseconds")
    try:
        _file.write(json.dumps({"time": now, "event": event} | fields) + "\n")
        _file.flush()
    except OSError as error:
        # the work must go on without its log; closing the log may fail in the same way
        with suppress(OSError):
            _file.close()
        _file = None
        print(f"escapement: warning: the log ends here: {error.strerror}", file=sys.stderr)


def progress(done: int, total: int, failed: int, rate: float) -> None:
    """Add a line of progress; the rate is in cases a second."""
    record("progress", done=done, total=total, failed=failed, rate=round(rate, 3))
