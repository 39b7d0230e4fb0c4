"""Working on the blocks of a plan on a Dask cluster: workers solve, the client writes."""

import logging
import time
import uuid
from collections.abc import Generator, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import islice
from typing import Any

from escapement import validate
from escapement.errors import InvalidValue, StorageError
from escapement.study.block import Block, Tiling, encode_block
from escapement.study.evaluate import Evaluator
from escapement.study.identity import numerics
from escapement.study.plan import StudyPlan

LOCAL = "local"
_TASK_TIME = 0.5  # s: far above the cost of a task, and little to lose with a worker
_LARGEST_TASK = 64  # blocks
_AHEAD = 2  # tasks on their way for each thread of the cluster
_PATIENCE = 15.0  # s to find a scheduler
_TICK = 0.01  # s between two looks at what is done
_CONNECTED = "running"  # status of a client
_PLANS: dict[str, tuple[Evaluator, Tiling]] = {}


class PlanOnWorkers:
    """Gives the plan to every worker, also those that come later, as a Dask plugin.

    Tasks then name it: data scattered to workers would be lost with them.
    """

    def __init__(self, key: str, plan: StudyPlan, cut: Tiling) -> None:
        self._key, self._plan, self._cut = key, plan, cut

    def setup(self, worker: Any) -> None:
        _PLANS[self._key] = Evaluator(self._plan), self._cut

    def teardown(self, worker: Any) -> None:
        _PLANS.pop(self._key, None)


def solve_blocks(key: str, numbers: list[int], version: str) -> tuple[list[Block], float]:
    """A task: some blocks of a plan, and the seconds they took."""
    if version != numerics():
        raise InvalidValue(
            f"workers must have the version of the client, numerics {version}, got {numerics()}; "
            "install the same geneva-escapement everywhere"
        )
    begin = time.perf_counter()
    evaluate, cut = _PLANS[key]
    blocks = [encode_block(cut, n, evaluate(*cut.span(n))) for n in numbers]
    return blocks, time.perf_counter() - begin


@contextmanager
def connect(scheduler: Any, workers: int | None) -> Iterator[Any]:
    """A client of the cluster.

    Parameters
    ----------
    scheduler : str or distributed.Client
        "local" starts a cluster of `workers` processes on this machine; else an
        address such as "tcp://10.0.0.1:8786".
    workers : int or None
        Processes of a local cluster.

    Raises
    ------
    InvalidValue
        When distributed is not installed, or `scheduler` is none.
    StorageError
        When no scheduler answers.
    """
    try:
        import distributed
    except ImportError:
        raise InvalidValue(
            f"scheduler must be left out without Dask, got {scheduler!r}; "
            "install it with: pip install 'geneva-escapement[dask]'"
        ) from None
    if isinstance(scheduler, distributed.Client):
        if scheduler.status != _CONNECTED or scheduler.asynchronous:
            remedy = "open it, with asynchronous left out"
            raise validate.fail("scheduler", "a client that is connected", scheduler, remedy)
        yield scheduler
        return
    log = logging.getLogger("distributed.client")  # it prints tracebacks of a lost scheduler
    with ExitStack() as stack:
        stack.callback(log.setLevel, log.level)
        log.setLevel(logging.CRITICAL)
        try:
            if scheduler == LOCAL:
                scheduler = stack.enter_context(
                    distributed.LocalCluster(
                        n_workers=workers,
                        threads_per_worker=1,
                        host="127.0.0.1",
                        dashboard_address=None,
                        silence_logs=logging.CRITICAL,
                    )
                )
            client = stack.enter_context(distributed.Client(scheduler, timeout=_PATIENCE))
        except TypeError:
            remedy = "give for example 'tcp://10.0.0.1:8786'"
            raise validate.fail("scheduler", "an address or a client", scheduler, remedy) from None
        except RuntimeError as error:  # each process begins as the script does
            raise StorageError(
                f"a local cluster must start, and did not: {error}; of a script, put what it does "
                "under: if __name__ == '__main__'"
            ) from None
        except (OSError, ValueError, TimeoutError) as error:
            raise StorageError(
                f"scheduler {scheduler} must answer, and did not: {error}; "
                "check the address, or start one with --scheduler local"
            ) from None
        yield client


def in_cluster(
    plan: StudyPlan, cut: Tiling, numbers: Iterable[int], client: Any
) -> Generator[Block, None, None]:
    """The blocks of these numbers, in the order of their completion.

    A block whose worker is lost is solved again elsewhere.

    Raises
    ------
    StorageError
        When the same blocks cost several workers, or the scheduler is lost.
    """
    import distributed

    key = f"escapement-{uuid.uuid4().hex}"
    # made here, where distributed is known to be there; workers find its base by name
    plugin = type("Plugin", (PlanOnWorkers, distributed.WorkerPlugin), {})(key, plan, cut)
    client.register_plugin(plugin, name=key)
    waiting = iter(numbers)
    done = distributed.as_completed()
    running: set[Any] = set()
    size = 1
    try:
        while True:
            most = _AHEAD * max(sum(client.nthreads().values()), 1)
            while len(running) < most and (task := list(islice(waiting, size))):
                future = client.submit(solve_blocks, key, task, numerics(), pure=False, retries=2)
                running.add(future)
                done.add(future)
            if not running:
                return
            while not done.has_ready():  # `next` would wait for a lost scheduler for ever
                if client.status != _CONNECTED:
                    raise _lost()
                time.sleep(_TICK)
            future = next(done)
            running.discard(future)
            if future.cancelled():  # the scheduler is back, and knows nothing of them
                raise _lost()
            blocks, seconds = future.result()
            yield from blocks
            pace = len(blocks) * _TASK_TIME / max(seconds, 1e-6)
            size = max(1, min(round(pace), 2 * len(blocks), _LARGEST_TASK))
    except distributed.KilledWorker as error:
        raise StorageError(
            f"a block ended {error.allowed_failures + 1} workers, perhaps for lack of memory; "
            "give workers more memory, then continue with resume=True"
        ) from None
    except Exception:  # each version of Dask tells a lost scheduler in other ways
        if client.status == _CONNECTED:
            raise
        raise _lost() from None
    finally:
        if client.status == _CONNECTED:
            client.cancel(list(running))
            client.unregister_worker_plugin(key)


def _lost() -> StorageError:
    return StorageError(
        "the scheduler must stay, and was lost; start it again, then continue with resume=True"
    )
