"""The notice that kernels are being compiled."""

import contextlib
import gc
import os
import shutil
import sys
import time


class Notice:
    """Explains the wait on first use: one line, which a terminal updates as kernels are compiled.

    A terminal removes the line when compiling ends, so that it does not disturb a progress bar.
    Numba compiles under a lock, so calls never overlap. The garbage collector rests meanwhile: it
    would look through all objects of the compiler again and again.

    silent : whether it says nothing; the environment variable ESCAPEMENT_QUIET asks for that.
    lost : the folder in which compiled code cannot be kept, and why; shown once.
    done, spent : functions compiled so far, and the time that it took [s].
    """

    def __init__(self) -> None:
        self.silent = bool(os.environ.get("ESCAPEMENT_QUIET"))
        self._depth = self.done = 0
        self._start = self.spent = 0.0
        self._shown_once = self._python_shown = self._collects = False
        self.lost = ""

    @property
    def busy(self) -> bool:
        """Whether a kernel is being compiled."""
        return self._depth > 0

    def interpret(self) -> None:
        """The answer comes from Python source, since nothing is compiled yet."""
        from multiprocessing import parent_process

        if self.silent or self._python_shown or parent_process() is not None:
            return
        self._python_shown = True
        with contextlib.suppress(AttributeError, OSError, ValueError):
            print(
                "escapement: not compiled yet, so that short work runs as plain Python; "
                + (
                    f"compiled code cannot be kept in {self.lost}: set NUMBA_CACHE_DIR to a folder "
                    "that can be written"
                    if self.lost
                    else "'escapement compile' compiles all, once"
                ),
                file=sys.stderr,
            )

    def begin(self) -> None:
        """A kernel has to be compiled, and perhaps others for it."""
        if self._depth == 0:
            self._start = time.monotonic() - self.spent
            self._collects = gc.isenabled()
            gc.disable()
        self._depth += 1
        self._show()

    def end(self) -> None:
        """It is compiled."""
        self._depth, self.done = self._depth - 1, self.done + 1
        self.spent = time.monotonic() - self._start
        if self._depth == 0 and self._collects:
            gc.enable()
        self._show()

    def _show(self) -> None:
        from multiprocessing import parent_process

        text = "escapement: compiling for this machine" + ", once" * (not self.lost)
        # standard error may be None, or closed
        with contextlib.suppress(AttributeError, OSError, ValueError):
            # each worker of a cluster on this machine would print the same
            if self.silent or parent_process() is not None:
                return
            if self.lost and not self._shown_once:
                print(
                    f"escapement: compiled code cannot be kept in {self.lost}, so that each run "
                    "compiles; set NUMBA_CACHE_DIR to a folder that can be written",
                    file=sys.stderr,
                )
            if sys.stderr.isatty():
                self._shown_once = True
                columns = shutil.get_terminal_size().columns - 1
                text += f": {self.done} functions, {time.monotonic() - self._start:.0f} s"
                sys.stderr.write(f"\r{text * (self._depth > 0):{columns}.{columns}}\r")
                sys.stderr.flush()
            elif not self._shown_once:
                self._shown_once = True
                print(f"{text}; it takes a minute or two", file=sys.stderr)


notice = Notice()
"""That of this process."""
