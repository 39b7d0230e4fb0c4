"""Timing calls that take microseconds or seconds on a machine that others use too.

A disturbance only ever makes a run longer, so the shortest of many says most about the
code. Contestants take turns: what disturbs one for a while disturbs all. What runs on one
core is timed by the processor time it used, in all threads: on an idle machine that is the
time on the wall, and on a busy one a long run is not charged for its interruptions.
"""

import gc
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

Call = Callable[[], Any]
Clock = Callable[[], float]

processor, wall = time.process_time, time.perf_counter

_SAMPLE = 5e-3  # s: long against the clock's grain, short against most disturbances


def timed(call: Call, clock: Clock = processor) -> tuple[float, Any]:
    """Time of one call [s], and what it returned."""
    begin = clock()
    result = call()
    return clock() - begin, result


def shortest(calls: Sequence[Call], rounds: int, clock: Clock = processor) -> list[float]:
    """Shortest time of each call [s] over rounds in which each takes its turn.

    A quick call is repeated within a turn until the sample is long enough, and the
    sample's mean counts.
    """
    repeats = [_repeats(call) for call in calls]
    best = [float("inf")] * len(calls)
    with _without_collector():
        for _ in range(rounds):
            for place, (call, count) in enumerate(zip(calls, repeats, strict=True)):
                begin = clock()
                for _ in range(count):
                    call()
                best[place] = min(best[place], (clock() - begin) / count)
    return best


def _repeats(call: Call) -> int:
    """How many calls fill a sample."""
    # the first call of all loads what it needs
    once = min(timed(call)[0], timed(call)[0])
    if once < _SAMPLE:
        once = min(once, timed(call)[0])
    return max(1, round(_SAMPLE / max(once, 1e-7)))


@contextmanager
def _without_collector() -> Iterator[None]:
    """Garbage collection off, as in `timeit`."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
