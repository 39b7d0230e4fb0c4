"""Progress of long work: a bar on a terminal, a line a minute elsewhere."""

import math
import shutil
import sys
import time
from collections.abc import Callable
from typing import Self, TextIO

from escapement.base.notice import notice

_REDRAW = 0.1  # s between two drawings of the bar
_LINE = 60.0  # s between two lines in a log
_FIRST = 2.0  # s of solving after which a log gets its first line
_LOG = 1.0  # s between two lines of a log for programs
_BAR = 24  # characters

active: list["Progress"] = []
"""Those that are being shown."""
stage = ""
"""What is being computed, for work of which nobody counts the cases."""


def set_stage(text: str) -> None:
    """Note what is being computed from here on."""
    global stage
    stage = text


class Progress:
    """Shows how many cases are done, failed and still to come.

    Call it with the numbers as they grow. The end of its `with` block shows the last line.

    Parameters
    ----------
    stream : text file, optional
        Default: standard error; where that is closed, nothing is shown.
    quiet : bool
        Show nothing.
    what : str
        Plural of what is counted.
    log : callable, optional
        Gets the numbers and the rate [1/s] as well, once a second at most and at the end.

    Attributes
    ----------
    before : int
        Cases that were done already; they do not count in the rate.
    """

    before = 0

    def __init__(
        self,
        stream: TextIO | None = None,
        *,
        quiet: bool = False,
        what: str = "cases",
        log: Callable[[int, int, int, float], object] | None = None,
    ) -> None:
        self._stream = sys.stderr if stream is None else stream
        # sys.stderr is None where standard error was closed before Python started
        closed = getattr(self._stream, "closed", self._stream is None)
        self._terminal = not closed and self._stream.isatty()
        self._quiet, self._log = quiet or closed, log
        self._begun, self._compiled_before = time.monotonic(), notice.spent
        self._logged, self._cases = -math.inf, what
        self.count(what)

    def count(self, what: str) -> None:
        """Begin to count something else, the plural of which is `what`; it is not logged."""
        self._what, self._counts = what, (0, 0, 0)
        self._start, self._compiled = time.monotonic(), notice.spent
        # the first line of a log comes early, as an estimate of the whole time
        self._shown = -math.inf if self._terminal else self._start + _FIRST - _LINE

    def __call__(self, done: int, total: int, failed: int) -> None:
        """Note the cases done, their total and those failed; show them if it is time."""
        self._counts, now = (done, total, failed), time.monotonic()
        if done >= total:
            return  # the end is shown once
        solved = now - (notice.spent - self._compiled)
        if solved - self._shown >= (_REDRAW if self._terminal else _LINE):
            self._shown = solved
            self._show("")
        if self._log is not None and now - self._logged >= _LOG and self._what == self._cases:
            self._logged = now
            self._log(*self._counts, self._rate)

    def __enter__(self) -> Self:
        if not self._quiet:
            active.append(self)
        return self

    def __exit__(self, *error: object) -> None:
        if self in active:
            active.remove(self)
        self._show("\n")
        if self._log is not None:
            self._log(*self._counts, self._rate)

    @property
    def _rate(self) -> float:
        """Cases done in a second, in which nothing was compiled."""
        solving = time.monotonic() - self._start - (notice.spent - self._compiled)
        before = self.before if self._what == self._cases else 0
        return (self._counts[0] - before) / solving if solving > 0.0 else 0.0

    def _show(self, end: str) -> None:
        done, total, _ = self._counts
        if self._quiet or total == 0:
            return
        line, columns = self._text(), shutil.get_terminal_size().columns - 1
        if self._terminal:
            bar = "#" * (_BAR * done // total)
            line = f"\r{f'[{bar:.<{_BAR}}] {line}'[:columns]:{columns}}"
        try:
            self._stream.write(line + (end if self._terminal else "\n"))
            self._stream.flush()
        except (OSError, ValueError):
            # the stream was closed; the work goes on without showing its progress
            self._quiet = True

    def _text(self) -> str:
        """The share done, counts, rate, time left or taken, and failures."""
        done, total, failed = self._counts
        rate = self._rate
        note = f"{duration((total - done) / rate)} left" if rate > 0.0 else "starting"
        if done >= total:
            compiled = notice.spent - self._compiled_before
            note = f"took {duration(time.monotonic() - self._begun - compiled)}"
            if compiled >= 0.05:
                note += f", and compiling {duration(compiled)}"
        failures = f", {failed} failed" if failed else ""
        share = f"{100 * done // total:3d} % {done} of {total} {self._what}"
        return f"{share}, {rate:.3g}/s, {note}{failures}"


def duration(seconds: float) -> str:
    """A time for people to read: 8.3 s, 4 min 05 s, 2 h 10 min."""
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 1:
        return f"{rest} s"
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"
