"""Evaluating consecutive cases of a plan, on some threads: a bad case never ends the study."""

import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from itertools import islice
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from escapement import simulation
from escapement.errors import InvalidValue
from escapement.model import ratio_in_range
from escapement.status import Status
from escapement.study.plan import StudyPlan
from escapement.study.result import RESULTS
from escapement.study.scenes import shared_scenes, solve_scenes

Columns = dict[str, NDArray[Any]]
"""One array per result, over consecutive cases."""

_SPEEDS = ("velocity_max", "velocity_min", "velocity_mean")
_TIMES = ("period", "rise_time", "settling_time")
_AHEAD = 8  # results that may wait while the disk is slow

T = TypeVar("T")


class Evaluator:
    """Solves the cases of one plan, in any blocks, from any threads of a process.

    What blocks have in common is solved once; results are the same bits for any
    blocks, order and number of threads.
    """

    def __init__(self, plan: StudyPlan) -> None:
        self._plan = plan
        self._shared = shared_scenes(plan) if plan.solver.engine == "energy" else None
        self._stopped = threading.Event()

    def stop(self) -> None:
        """Make every block that is being solved raise CancelledError before its next case."""
        self._stopped.set()

    def __call__(self, start: int, stop: int) -> Columns:
        """Results of the cases start <= case < stop."""
        if self._plan.solver.engine == "energy":
            return self._in_one_batch(np.arange(start, stop))
        block = {
            name: np.full(stop - start, np.nan if name != "status" else 0, result.dtype)
            for name, result in RESULTS.items()
        }
        for row, case in enumerate(range(start, stop)):
            if self._stopped.is_set():
                raise CancelledError
            _fill(block, row, self._plan, case)
        return block

    def _in_one_batch(self, cases: NDArray[np.int64]) -> Columns:
        """Scenes of the cases, each case put on its own clock."""
        figures, status = (
            solve_scenes(self._plan, cases) if self._shared is None else self._shared.of(cases)
        )
        values = self._plan.fixed_si | self._plan.columns(cases)
        with np.errstate(all="ignore"):
            square = np.divide(values["follower_inertia"], values["torque"])
        bad = np.broadcast_to(~ratio_in_range(square), cases.shape)
        if bad.any():
            figures[:, bad], status[bad] = np.nan, Status.INVALID
            square = np.where(bad, 1.0, square)
        clock = np.sqrt(square)
        columns = {name: line / clock for name, line in zip(_SPEEDS, figures[:3], strict=True)}
        columns |= {name: line * clock for name, line in zip(_TIMES, figures[3:], strict=True)}
        return columns | {"status": status}


def _fill(block: Columns, row: int, plan: StudyPlan, case: int) -> None:
    try:
        figures = simulation.terminal(
            plan.escapement(case),
            initial_speed=plan.values(case)["initial_speed"],
            **plan.solver.given,
        )
    except InvalidValue:
        block["status"][row] = Status.INVALID
        return
    except (ArithmeticError, ValueError, RuntimeError):
        block["status"][row] = Status.NOT_CONVERGED
        return
    for name, column in block.items():
        column[row] = getattr(figures, name)


def in_threads(
    work: Callable[[int], T], numbers: Iterable[int], workers: int, stop: Callable[[], None]
) -> Generator[T, None, None]:
    """`work` of every number in order.

    Closing the generator does not wait: work that has not begun is cancelled, and `stop`
    is called so that work that has begun can end early.
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
