"""Run time against error of the package's two engines and SciPy's solve_ivp.

`work_precision.run` measures, `work_precision.write` fills a folder. This module has times of
calls, a description of the machine, and tables.

Disturbances can only make a run longer, so the shortest of many runs is the best measure of the
code. Solvers take turns, so that a disturbance affects all of them. Runs on one core are timed by
the processor time of all threads: on an idle machine this equals the wall time, and on a busy one
interruptions of a long run do not count.
"""

import contextlib
import math
import os
import platform
import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from timeit import Timer
from typing import Any

from escapement import __version__
from escapement.base.files import replace_file
from escapement.base.text import as_csv

Call = Callable[[], Any]

_SAMPLE = 5e-3  # [s], long compared with the clock's resolution, short compared with disturbances
_OTHER_FACTS = ("processor", "cores", "load", "system", "escapement", "quick")


def timed(call: Call) -> tuple[float, Any]:
    """Time of one call [s], and its result."""
    begin = time.process_time()
    result = call()
    return time.process_time() - begin, result


def shortest(calls: Sequence[Call], rounds: int) -> list[float]:
    """Shortest time of each call [s] over rounds in which each takes its turn.

    A quick call is repeated within a turn until the sample is long enough, and the
    sample's mean counts.
    """
    timers = [Timer(call, timer=time.process_time) for call in calls]
    # the very first call also loads what it needs, so the shorter of two counts
    once = [max(min(timer.repeat(2, 1)), 1e-7) for timer in timers]
    repeats = [max(1, round(_SAMPLE / each)) for each in once]
    best = [math.inf] * len(calls)
    for _ in range(rounds):
        for index, (timer, count) in enumerate(zip(timers, repeats, strict=True)):
            best[index] = min(best[index], timer.timeit(count) / count)
    return best


def describe_machine(packages: Sequence[str] = ()) -> dict[str, Any]:
    """Processor, cores, system, and versions, also of further `packages`.

    It contains nothing that identifies the machine's owner.
    """
    installed = [name for name in ("numpy", "scipy", "numba", *packages) if find_spec(name)]
    allowed = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
    return {
        "processor": _processor(),
        "cores": len(allowed) if allowed else os.cpu_count() or 1,
        # processes that others keep running here, as an average over a minute
        "load": round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None,
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "escapement": __version__,
        **{name: version(name) for name in installed},
    }


def machine_in_a_line(machine: dict[str, Any]) -> str:
    """The result of `describe_machine`, for the foot of a figure."""
    versions = ", ".join(f"{name} {machine[name]}" for name in machine if name not in _OTHER_FACTS)
    return f"{machine['processor']}, {machine['cores']} cores; {versions}"


def write_csv(path: Path, rows: Sequence[Any]) -> Path:
    """Replace `path` by named tuples of one kind as CSV; missing values are empty."""
    lines = [rows[0]._fields, *([_short(value) for value in row] for row in rows)]
    replace_file(path, [as_csv(lines).encode()])
    return path


def _short(value: Any) -> Any:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return value


def _processor() -> str:
    """The processor's model name, if the system gives it."""
    with contextlib.suppress(OSError, StopIteration):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        named = next(line for line in lines if line.startswith("model name"))
        return named.partition(":")[2].strip()
    return platform.machine()
