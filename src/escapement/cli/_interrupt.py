"""Ctrl-C that ends the program wherever it strikes.

Python raises KeyboardInterrupt between any two instructions: also in a function called by
foreign code, which drops it, or while a library is being loaded, which makes an ImportError
of it.
"""

import signal
import sys
import threading
from types import FrameType
from typing import Any

_AGAIN = 0.05  # s after which an interrupt that was dropped comes again
_struck = threading.Event()


def watch() -> None:
    """Let no interrupt of this process be dropped, or end in a traceback."""
    # who started it may want it to ignore Ctrl-C, as a shell does in the background
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _strike)
    sys.unraisablehook, sys.excepthook = _raise_later, _show


def has_struck() -> bool:
    """Whether an error may be what became of an interrupt."""
    return _struck.is_set()


def _strike(number: int, frame: FrameType | None) -> None:
    _struck.set()
    raise KeyboardInterrupt


def _raise_later(dropped: Any) -> None:
    """What foreign code dropped: an interrupt is sent once more, all else is told."""
    if not isinstance(dropped.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(dropped)
        return
    again = threading.Timer(_AGAIN, signal.raise_signal, [signal.SIGINT])
    again.daemon = True
    again.start()


def _show(kind: type[BaseException], error: BaseException, trace: Any) -> None:
    """Errors of the package itself with their trace; an interrupt needs none."""
    if not issubclass(kind, KeyboardInterrupt):
        sys.__excepthook__(kind, error, trace)
