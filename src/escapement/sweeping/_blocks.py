"""Working on the blocks of a plan, in order, on some threads."""

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
from typing import TypeVar

T = TypeVar("T")

_AHEAD = 8  # results that may wait while the disk is slow


def in_threads(
    work: Callable[[int], T], numbers: Iterable[int], workers: int
) -> Generator[T, None, None]:
    """`work` of every number in order; closing the generator ends the threads."""
    waiting: Iterator[int] = iter(numbers)
    running: deque[Future[T]] = deque()
    pool = ThreadPoolExecutor(workers, thread_name_prefix="escapement-sweep")
    try:
        while True:
            for number in islice(waiting, workers + _AHEAD - len(running)):
                running.append(pool.submit(work, number))
            if not running:
                return
            yield running.popleft().result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
