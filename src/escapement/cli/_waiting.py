"""For how long a command has been at work, where nothing else shows its progress."""

import os
import shutil
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

_PATIENCE = 2.0  # s before anything is shown
_REDRAW = 0.5  # s between two drawings on a terminal
_LINE = 60.0  # s between two lines elsewhere

_over = threading.Event()
_drawing = threading.Lock()


@contextmanager
def shown(command: str, quiet: bool) -> Iterator[None]:
    """Show in another thread that a command is at work, until it ends or prints its results."""
    _over.clear()
    if quiet or os.environ.get("ESCAPEMENT_QUIET"):
        _over.set()
    else:
        threading.Thread(target=_watch, args=(command,), daemon=True).start()
    try:
        yield
    finally:
        end()


def clear() -> None:
    """Leave the line of the terminal empty for something else to be printed."""
    if not _over.is_set():
        with _drawing:
            _draw("")


def end() -> None:
    """Show nothing from here on."""
    clear()
    _over.set()


def _watch(command: str) -> None:
    """Show the time at work, at intervals."""
    from time import monotonic

    begun = monotonic()
    if _over.wait(_PATIENCE):
        return
    from escapement.base import progress
    from escapement.base.notice import notice

    interval = _REDRAW if _on_terminal() else _LINE - _PATIENCE
    while not _over.wait(interval):
        # compiling, and work that is counted, show themselves
        if progress.active or notice.busy:
            continue
        what = f"{command}: {progress.stage}" if progress.stage else command
        with _drawing:
            if not _over.is_set():
                _draw(f"escapement: {what}, {progress.duration(monotonic() - begun)}")
        interval = _REDRAW if _on_terminal() else _LINE


def _on_terminal() -> bool:
    with suppress(AttributeError, ValueError):  # standard error may be None, or closed
        return sys.stderr.isatty()
    return False


def _draw(text: str) -> None:
    """Replace the line on a terminal; elsewhere write a line, if there is a text."""
    with suppress(AttributeError, OSError, ValueError):
        if _on_terminal():
            columns = shutil.get_terminal_size().columns - 1
            sys.stderr.write(f"\r{text:{columns}.{columns}}\r")
        elif text:
            sys.stderr.write(text + "\n")
        sys.stderr.flush()
