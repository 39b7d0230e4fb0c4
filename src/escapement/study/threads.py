"""Working on the blocks of a plan, in order, on some threads."""

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
from typing import TypeVar

T = TypeVar("T")

_AHEAD = 8  # results that may wait while the disk is slow


def in_threads(
    work: Callable[[int], T], numbers: Iterable[int], workers: int, stop: Callable[[], None]
) -> Generator[T, None, None]:
    """`work` of every number in order.

    Closing the generator waits for nothing: work that is not begun never is, and `stop`
    tells what has begun that nobody wants it any more.
    """
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
        stop()
        pool.shutdown(wait=False, cancel_futures=True)
