"""Progress of long work: a bar on a terminal, a line every half minute elsewhere."""

import math
import shutil
import sys
import time
from typing import Self, TextIO

_REDRAW = 0.1  # s between two drawings of the bar
_LINE = 30.0  # s between two lines in a log
_BAR = 24  # characters


class Progress:
    """Shows how many cases are done, failed and still to come.

    Call it with the numbers as they grow. The end of its `with` block shows the last line.

    Parameters
    ----------
    stream : text file, optional
        Default: standard error; where that is closed, nothing is shown.
    quiet : bool
        Show nothing.
    before : int
        Cases that were done already; they do not count in the rate.
    what : str
        Plural of what is counted.
    """

    def __init__(
        self,
        stream: TextIO | None = None,
        *,
        quiet: bool = False,
        before: int = 0,
        what: str = "cases",
    ) -> None:
        self._stream = sys.stderr if stream is None else stream
        # sys.stderr is None where standard error was closed before Python started
        closed = getattr(self._stream, "closed", self._stream is None)
        self._terminal = not closed and self._stream.isatty()
        self._quiet, self._before, self._what = quiet or closed, before, what
        self._start = time.monotonic()
        self._shown = -math.inf if self._terminal else self._start
        self._counts = (0, 0, 0)

    def __call__(self, done: int, total: int, failed: int) -> None:
        """Note the cases done, their total and those failed; show them if it is time."""
        self._counts = (done, total, failed)
        interval = _REDRAW if self._terminal else _LINE
        if done < total and time.monotonic() - self._shown >= interval:
            self._shown = time.monotonic()
            self._show("")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._show("\n")

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
        elapsed = time.monotonic() - self._start
        rate = (done - self._before) / elapsed if elapsed > 0.0 else 0.0
        told = f"{duration((total - done) / rate)} left" if rate > 0.0 else "starting"
        if done >= total:
            told = f"took {duration(elapsed)}"
        failures = f", {failed} failed" if failed else ""
        share = f"{100 * done // total:3d} % {done} of {total} {self._what}"
        return f"{share}, {rate:.3g}/s, {told}{failures}"


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
