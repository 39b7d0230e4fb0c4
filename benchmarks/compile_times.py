"""Processor time of compiling each kernel, with nothing compiled before.

``python benchmarks/compile_times.py [COMMIT]``

A process compiles what ``escapement compile`` compiles, of the files here or of a commit, in an
empty folder. ``variants`` is how often a kernel is compiled, for arguments of different types.
``inclusive`` contains the kernels that are compiled because this one calls them, ``exclusive`` does
not, so that its sum is the whole time.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

from versions import ROOT, WORKER, sources

SHOWN = 40  # kernels in the printed table


class Kernel(NamedTuple):
    """Times of a kernel over all its variants [s]."""

    kernel: str
    variants: int
    inclusive: float
    exclusive: float


def work(output: str) -> None:
    """Compile all in this process, and write the table."""
    from numba.core import event

    from escapement.base.text import print_columns
    from escapement.benchmark import write_csv
    from escapement.cli.compile import compile_all

    running: list[list[float]] = []
    times: dict[str, list[float]] = defaultdict(lambda: [0, 0.0, 0.0])

    class Stopwatch(event.Listener):
        """Times from the start of a kernel's compilation to its end."""

        def on_start(self, _event: Any) -> None:
            running.append([time.process_time(), 0.0])

        def on_end(self, event: Any) -> None:
            start, others = running.pop()
            spent, function = time.process_time() - start, event.data["dispatcher"].py_func
            if running:
                running[-1][1] += spent
            name = f"{function.__module__}.{function.__qualname__}".removeprefix("escapement.")
            row = times[name]
            row[0], row[1], row[2] = row[0] + 1, row[1] + spent, row[2] + spent - others

    event.register("numba:compile", Stopwatch())
    compile_all()
    lines = sorted((Kernel(name, *row) for name, row in times.items()), key=lambda x: -x.exclusive)
    whole = sum(line.variants for line in lines), sum(line.exclusive for line in lines)
    lines.insert(0, Kernel("all", whole[0], whole[1], whole[1]))
    rounded = [x._replace(inclusive=round(x[2], 2), exclusive=round(x[3], 2)) for x in lines]
    write_csv(Path(output), rounded)
    print_columns([Kernel._fields], rounded[:SHOWN])


def main() -> None:
    """Measure in a new process."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("version", nargs="?", default=".", metavar="COMMIT")
    results = ROOT / "benchmarks" / "results" / "compile_times.csv"
    parser.add_argument("-o", "--output", type=Path, default=results)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        env = os.environ | {"PYTHONPATH": str(sources(args.version)), "NUMBA_CACHE_DIR": folder}
        command = [sys.executable, __file__, WORKER, str(args.output.resolve())]
        subprocess.run(command, check=True, env=env | {"ESCAPEMENT_COMPILE": "1"})


if __name__ == "__main__":
    sys.exit(work(sys.argv[2]) if sys.argv[1:2] == [WORKER] else main())
