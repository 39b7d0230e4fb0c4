"""The notice that kernels are being compiled."""

import contextlib
import gc
import os
import sys
import time

_AGAIN = 10.0
"""Time between two lines on the progress of compiling [s]."""


class Notice:
    """Explains the wait on first use, with a line of progress now and then.

    Numba compiles under a lock, so calls never overlap. The garbage collector rests meanwhile: it
    would look through all objects of the compiler again and again.

    silent : whether it says nothing; the environment variable ESCAPEMENT_QUIET asks for that.
    lost : the folder in which compiled code cannot be kept, and why.
    done, spent : functions compiled so far, and the time that it took [s].
    """

    def __init__(self) -> None:
        self.silent = bool(os.environ.get("ESCAPEMENT_QUIET"))
        self._depth = self.done = 0
        self._start = self.spent = self._shown = 0.0
        self._collects = False
        self._said: set[str] = set()
        self.lost = ""

    @property
    def busy(self) -> bool:
        """Whether a kernel is being compiled."""
        return self._depth > 0

    def interpret(self) -> None:
        """The answer comes from Python source, since nothing is compiled yet."""
        remedy = self._not_kept or "'escapement compile' compiles all, once"
        self._say(f"not compiled yet, so that short work runs as plain Python; {remedy}")

    def begin(self) -> None:
        """A kernel has to be compiled, and perhaps others for it."""
        if self._depth == 0:
            self._start = time.monotonic() - self.spent
            self._collects = gc.isenabled()
            gc.disable()
        self._depth += 1
        often = f", at each run: {self._not_kept}" if self.lost else ", once"
        self._say(f"compiling for this machine{often}; it takes a minute or two")

    def end(self) -> None:
        """It is compiled."""
        self._depth, self.done = self._depth - 1, self.done + 1
        self.spent = time.monotonic() - self._start
        if self.spent > self._shown + _AGAIN:
            self._shown = self.spent
            self._say(f"compiled {self.done} functions in {self.spent:.0f} s")
        if self._depth == 0 and self._collects:
            gc.enable()

    @property
    def _not_kept(self) -> str:
        """Why compiled code cannot be kept, and what to do; "" if it can."""
        remedy = "set NUMBA_CACHE_DIR to a folder that can be written"
        return self.lost and f"compiled code cannot be kept in {self.lost}; {remedy}"

    def _say(self, text: str) -> None:
        """A line on standard error, once in this process."""
        from multiprocessing import parent_process

        # each worker of a cluster on this machine would print the same
        if self.silent or text in self._said or parent_process() is not None:
            return
        self._said.add(text)
        # standard error may be None, or closed
        with contextlib.suppress(AttributeError, OSError, ValueError):
            sys.stderr.write(f"escapement: {text}\n")


notice = Notice()
"""That of this process."""
