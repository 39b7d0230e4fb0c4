"""Making a study's file beside the caller, of blocks as they become available."""

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from os import PathLike
from pathlib import Path

from escapement.study.block import Block
from escapement.study.image import write_blocks
from escapement.study.result import Study


class Assembly:
    """A thread that writes blocks in order, each as soon as it is there.

    Parameters
    ----------
    frame, path, force, temporary :
        As for `write_blocks`.
    count : int
        Blocks of the study.
    fetch : callable
        A block by its number, None where it is not there yet.
    """

    def __init__(
        self,
        frame: Study,
        path: str | PathLike[str],
        force: bool,
        temporary: Path | None,
        count: int,
        fetch: Callable[[int], Block | None],
    ) -> None:
        self._count, self._fetch = count, fetch
        self._stop, self._news = threading.Event(), threading.Condition()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="escapement-store")
        self._work = self._thread.submit(
            write_blocks, frame, path, self._in_order(), force, self._stop, temporary
        )

    def look(self) -> None:
        """Tell that another block is there; raises what stopped the thread, if it did."""
        with self._news:
            self._news.notify()
        if self._work.done():
            self._work.result()

    def finish(self) -> None:
        """Wait for the file to be in place; all blocks must be there."""
        self.look()
        self._work.result()

    def close(self) -> None:
        """End the thread, wherever it is: what is not in place by now never will be."""
        self._stop.set()
        with self._news:
            self._news.notify()
        self._thread.shutdown(wait=True)

    def _in_order(self) -> Iterator[Block]:
        for number in range(self._count):
            with self._news:
                while (block := self._fetch(number)) is None and not self._stop.is_set():
                    self._news.wait()
            if block is None:
                return
            yield block
