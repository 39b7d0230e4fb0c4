"""For how long a command has been at work, where nothing else shows its progress."""

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

_PATIENCE = 2.0  # s before anything is shown on a terminal
_AGAIN = 30.0  # s between two lines, and before the first one in a log

_over = threading.Event()


@contextmanager
def shown(command: str, quiet: bool) -> Iterator[None]:
    """Show in another thread that a command is at work, until it ends or prints its results."""
    _over.clear()
    if not (quiet or os.environ.get("ESCAPEMENT_QUIET")):
        threading.Thread(target=_watch, args=(command,), daemon=True).start()
    try:
        yield
    finally:
        end()


def end() -> None:
    """Show nothing from here on."""
    _over.set()


def _watch(command: str) -> None:
    """Show the time at work, a line at a time."""
    from time import monotonic

    begun, wait = monotonic(), _PATIENCE if os.isatty(2) else _AGAIN
    while not _over.wait(wait):
        from escapement.base import progress
        from escapement.base.notice import notice

        wait = _AGAIN
        # compiling, and work that is counted, show themselves
        if not (progress.active or notice.busy):
            # the studies that compiling runs are no stages of its own
            staged = progress.stage and command != "compile"
            what = f"{command}: {progress.stage}" if staged else command
            with suppress(AttributeError, OSError, ValueError):  # there may be no standard error
                sys.stderr.write(f"escapement: {what}, {progress.duration(monotonic() - begun)}\n")
