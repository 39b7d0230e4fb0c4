"""Evaluating the cases of a plan in blocks, in order, on some threads."""

import time
from collections import deque
from collections.abc import Generator
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np

from escapement.configuration import StudyPlan
from escapement.sweeping._evaluate import Columns, evaluate

_BLOCK_TIME = 0.25  # s: Ctrl-C and progress wait no longer than this, if a case does not
_LARGEST_BLOCK = 1 << 18


def evaluate_blocks(plan: StudyPlan, workers: int) -> Generator[Columns, None, None]:
    """Results of all cases in order, in blocks of about equal time.

    Closing the generator ends the threads. The results do not depend on the
    number of workers.
    """
    size, start = 1, 0
    running: deque[Future[tuple[Columns, float]]] = deque()
    pool = ThreadPoolExecutor(workers, thread_name_prefix="escapement-sweep")
    try:
        while start < plan.cases or running:
            while start < plan.cases and len(running) <= workers:
                stop = min(start + size, plan.cases)
                running.append(pool.submit(_timed, plan, start, stop))
                start = stop
            block, seconds = running.popleft().result()
            yield block
            pace = _BLOCK_TIME * len(block["status"]) / max(seconds, 1e-9)
            size = int(np.clip(pace, 1, min(8 * len(block["status"]), _LARGEST_BLOCK)))
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _timed(plan: StudyPlan, start: int, stop: int) -> tuple[Columns, float]:
    begin = time.perf_counter()
    return evaluate(plan, start, stop), time.perf_counter() - begin
