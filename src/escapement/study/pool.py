"""Where the tasks of a study run: threads of this process, or workers of a Dask cluster."""

import logging
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent import futures
from contextlib import ExitStack, contextmanager
from itertools import islice
from typing import Any, NamedTuple, TypeVar

from escapement.base import validate
from escapement.base.errors import InvalidValue, StorageError

LOCAL = "local"
_LOCAL_CLUSTER = {"threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": None}
_PATIENCE = 15.0  # s to find a scheduler
_TICK = 1.0  # s between two checks whether the scheduler is still there
_CONNECTED = "running"  # status of a client

T = TypeVar("T")


class Pool(NamedTuple):
    """Threads or a cluster; by default nothing but the thread that asks.

    executor : where tasks are submitted.
    in_advance : greatest number of tasks that are submitted and not finished.
    share : makes a value available to all tasks, and returns the object to submit in its place.
    alive : whether any worker or thread is there.
    """

    executor: futures.Executor | None = None
    in_advance: Callable[[], int] = lambda: 0
    share: Callable[[Any], Any] = lambda value: value
    alive: Callable[[], bool] = lambda: True

    def completed(
        self, task: Callable[[Any, Any], T], common: Any, items: Iterable[Any]
    ) -> Iterator[T]:
        """`task(common, item)` of every item, in the order of their completion."""
        if self.executor is None:
            yield from (task(common, item) for item in items)
            return
        shared, waiting = self.share(common), iter(items)
        running: set[futures.Future[T]] = set()
        try:
            while True:
                for item in islice(waiting, max(self.in_advance() - len(running), 0)):
                    running.add(self.executor.submit(task, shared, item))
                if not running:
                    return
                done, running = futures.wait(running, _TICK, futures.FIRST_COMPLETED)
                if not self.alive():
                    raise futures.CancelledError
                # Finished results come first: an error ends the study and would lose them.
                for future in sorted(done, key=lambda f: f.cancelled() or bool(f.exception())):
                    yield future.result()
        finally:
            for future in running:
                future.cancel()


@contextmanager
def in_threads(workers: int) -> Iterator[Pool]:
    """Threads of this process. Leaving does not wait for blocks that are being solved."""
    executor = futures.ThreadPoolExecutor(workers, thread_name_prefix="escapement-sweep")
    try:
        yield Pool(executor, lambda: workers + 8)  # some blocks may wait while the disk is slow
    finally:
        executor.shutdown(wait=False, cancel_futures=True)


@contextmanager
def in_cluster(scheduler: Any, workers: int) -> Iterator[Pool]:
    """Workers of a Dask cluster. Tasks of a lost worker are solved again by others.

    Raises
    ------
    InvalidValue, StorageError
        As `_connected`.
    StorageError
        When the same block costs several workers, or the scheduler is lost.
    """
    with _connected(scheduler, workers) as client:
        import distributed

        def share(value: Any) -> Any:
            # A lost result of a task is computed again; lost scattered data are not.
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # Dask warns if the value is large
                return client.submit(_itself, value, pure=False)

        def in_advance() -> int:
            return 2 * max(sum(map(int, client.nthreads().values())), 1)

        executor = client.get_executor(pure=False, retries=2)
        try:
            yield Pool(executor, in_advance, share, lambda: client.status == _CONNECTED)
        except distributed.KilledWorker as error:
            raise StorageError(
                f"a block of cases ended {error.allowed_failures + 1} workers, perhaps for "
                "lack of memory; give them more, then continue with resume=True (--resume)"
            ) from None
        except (Exception, futures.CancelledError) as error:
            # each version of Dask reports a lost scheduler in another way
            if client.status == _CONNECTED and not isinstance(error, futures.CancelledError):
                raise
            raise StorageError(
                "the scheduler must stay connected, and the connection was lost; start it again, "
                "then continue with resume=True (--resume)"
            ) from None


def _itself(value: T) -> T:
    return value


@contextmanager
def _connected(scheduler: Any, workers: int) -> Iterator[Any]:
    """A client of the cluster.

    Parameters
    ----------
    scheduler : str or distributed.Client
        "local" starts a cluster of `workers` processes on this machine; else an
        address such as "tcp://10.0.0.1:8786".
    workers : int
        Processes of a local cluster.

    Raises
    ------
    InvalidValue
        When distributed is not installed, or `scheduler` is not a scheduler.
    StorageError
        When no scheduler answers.
    """
    try:
        import distributed
    except ImportError:
        raise InvalidValue(
            f"scheduler must be left out without Dask, got {scheduler!r}; "
            "install it in a clone of the repository with: pip install '.[dask]'"
        ) from None
    if isinstance(scheduler, distributed.Client):
        if scheduler.status != _CONNECTED or scheduler.asynchronous:
            remedy = "open it without asynchronous=True"
            raise validate.fail("scheduler", "a client that is connected", scheduler, remedy)
        yield scheduler
        return
    if not isinstance(scheduler, str):
        remedy = "give for example 'tcp://10.0.0.1:8786'"
        raise validate.fail("scheduler", "an address or a client", scheduler, remedy)
    silent = logging.CRITICAL
    log = logging.getLogger("distributed.client")  # it prints tracebacks of a lost scheduler
    with ExitStack() as stack:
        stack.callback(log.setLevel, log.level)
        log.setLevel(silent)
        try:
            if scheduler == LOCAL:
                options = {"n_workers": workers, "silence_logs": silent, **_LOCAL_CLUSTER}
                scheduler = stack.enter_context(distributed.LocalCluster(**options))
            client = stack.enter_context(distributed.Client(scheduler, timeout=_PATIENCE))
        except RuntimeError as error:  # each process begins as the script does
            raise StorageError(
                f"a local cluster must start, and did not: {error}; in a script, put the commands "
                "under: if __name__ == '__main__'"
            ) from None
        except (OSError, ValueError) as error:
            raise StorageError(
                f"scheduler {scheduler} must answer, and did not: {error}; "
                "check the address, or start one with --scheduler local"
            ) from None
        yield client
