"""Progress of long work: a bar on a terminal, a line every half minute elsewhere."""

import math
import shutil
import sys
import time
from collections.abc import Callable
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
    clock : callable
        A clock in seconds that never goes back.
    """

    def __init__(
        self,
        stream: TextIO | None = None,
        *,
        quiet: bool = False,
        before: int = 0,
        what: str = "cases",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._stream = sys.stderr if stream is None else stream
        # sys.stderr is None where standard error was closed before Python started
        closed = getattr(self._stream, "closed", self._stream is None)
        self._terminal = not closed and self._stream.isatty()
        self._quiet, self._before = quiet or closed, before
        self._what, self._clock = what, clock
        self._start = clock()
        self._shown = -math.inf if self._terminal else self._start
        self._counts = (0, 0, 0)
        self._width = 0

    def __call__(self, done: int, total: int, failed: int) -> None:
        """Note the cases done, their total and those failed; show them if it is time."""
        self._counts = (done, total, failed)
        interval = _REDRAW if self._terminal else _LINE
        now = self._clock()
        if done < total and now - self._shown >= interval:
            self._shown = now
            self._show(last=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._show(last=True)

    def _show(self, *, last: bool) -> None:
        done, total, failed = self._counts
        if self._quiet or total == 0:
            return
        elapsed = self._clock() - self._start
        text = describe(done, total, failed, elapsed, self._before, self._what)
        if not self._terminal:
            self._write(text + "\n")
            return
        filled = _BAR * done // total
        line = f"[{'#' * filled}{'.' * (_BAR - filled)}] {text}"
        line = line[: shutil.get_terminal_size().columns - 1]
        self._write("\r" + line.ljust(self._width) + ("\n" if last else ""))
        self._width = len(line)

    def _write(self, text: str) -> None:
        try:
            self._stream.write(text)
            self._stream.flush()
        except (OSError, ValueError):
            # the stream was closed; the work goes on without showing its progress
            self._quiet = True


def describe(
    done: int, total: int, failed: int, elapsed: float, before: int = 0, what: str = "cases"
) -> str:
    """One line with the share done, counts, rate, time left or taken, and failures."""
    rate = (done - before) / elapsed if elapsed > 0.0 else 0.0
    if done >= total:
        time_text = f"took {duration(elapsed)}"
    elif rate > 0.0:
        time_text = f"{duration((total - done) / rate)} left"
    else:
        time_text = "starting"
    share = math.floor(100 * done / total)
    failures = f", {failed} failed" if failed else ""
    return f"{share:3d} % {done} of {total} {what}, {rate:.3g}/s, {time_text}{failures}"


def duration(seconds: float) -> str:
    """A time for people to read: 8.3 s, 4 min 05 s, 2 h 10 min."""
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
