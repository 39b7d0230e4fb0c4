"""Times of calls, the machine they were measured on, and tables of them.

A disturbance only ever makes a run longer, so the shortest of many says most about the
code. Solvers take turns: what disturbs one for a while disturbs all. What runs on one
core is timed by the processor time it used, in all threads: on an idle machine that is the
time on the wall, and on a busy one a long run is not charged for its interruptions.
"""

import gc
import math
import os
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from escapement import __version__
from escapement.files import replace_file
from escapement.text import as_csv

Call = Callable[[], Any]
Clock = Callable[[], float]

processor, wall = time.process_time, time.perf_counter

_SAMPLE = 5e-3  # [s] is long against the clock's grain and short against most disturbances
_PACKAGES = ("numpy", "scipy", "numba")
_OTHER_FACTS = ("processor", "cores", "load", "system", "escapement", "quick")


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


def describe_machine(packages: Sequence[str] = ()) -> dict[str, Any]:
    """Processor, cores, system, and versions, also of further `packages`.

    Nothing in it tells whose machine this is.
    """
    versions = {name: _version(name) for name in (*_PACKAGES, *packages)}
    return {
        "processor": _processor(),
        "cores": _cores(),
        "load": _load(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "escapement": __version__,
        **{name: found for name, found in versions.items() if found is not None},
    }


def machine_in_a_line(machine: dict[str, Any]) -> str:
    """What `describe_machine` found, for the foot of a figure."""
    versions = ", ".join(f"{name} {machine[name]}" for name in machine if name not in _OTHER_FACTS)
    return f"{machine['processor']}, {machine['cores']} cores; {versions}"


def write_csv(path: Path, rows: Sequence[Any]) -> Path:
    """Replace `path` by named tuples of one kind as CSV; what does not exist is empty."""
    lines = [rows[0]._fields, *([_short(value) for value in row] for row in rows)]
    replace_file(path, [as_csv(lines).encode()])
    return path


def _short(value: Any) -> Any:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return value


def _repeats(call: Call) -> int:
    """How many calls fill a sample."""
    # the very first call also loads what it needs, so the second counts
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


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _processor() -> str:
    """The processor's model name, where the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _load() -> float | None:
    """Processes that others keep running here, as an average over a minute."""
    return round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None


def _cores() -> int:
    """Cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
