"""A study of torque and friction, written to HDF5: wall time, time of solving, peak memory.

``python benchmarks/map_to_hdf5.py [--side 1000] [--first torque] [--workers 2] [--folder DIR]``

It computes all figures of merit of 10^6 cases, with either axis as the first; ``--side 10000``
writes 10^8 cases (about 4 GB) to show that memory stays bounded. Every run is a separate process,
which loads compiled code, so that its peak memory is that of the run. The file is removed
afterwards.
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from escapement.base.text import print_columns
from escapement.benchmark import describe_machine, write_csv
from escapement.benchmark.problems import PROBLEMS

AXES = {"torque": "torque, friction", "friction": "friction, torque"}
ROOT = Path(__file__).resolve().parents[1]


class Map(NamedTuple):
    """One sweep: times in seconds, memory and file in MB.

    axes : their order, the first varying slowest.
    wall, processor : of the sweep into the file; the processor's in all threads.
    solving : processor time within the engine, summed over threads.
    """

    axes: str
    workers: int
    cases: int
    failed: int
    importing: float
    wall: float
    processor: float
    solving: float
    peak_memory_mb: float
    file_mb: float


def sweep(side: int, first: str, workers: int, path: Path) -> dict[str, float]:
    """Run one sweep in this process, and measure it."""
    begin = time.perf_counter()
    import escapement as esc
    from escapement.engines.energy import batch
    from escapement.study.parse import plan_from
    from escapement.study.running import write_plan

    timer = PROBLEMS[0].escapement
    esc.simulate(timer)
    importing = time.perf_counter() - begin
    solve, spent = batch.solve, []

    def watched(*arguments: Any) -> Any:
        start = time.thread_time()
        solved = solve(*arguments)
        spent.append(time.thread_time() - start)
        return solved

    batch.solve = watched
    axes = {
        "torque": timer.torque * np.linspace(0.5, 2.0, side),
        "friction": np.linspace(0.05, 0.40, side),
    }
    if first == "friction":
        axes = dict(reversed(axes.items()))
    start, used = time.perf_counter(), time.process_time()
    plan = plan_from(timer, axes)
    tally = write_plan(plan, path, workers=workers)
    return {
        "cases": tally.cases,
        "failed": tally.failed,
        "importing": importing,
        "wall": time.perf_counter() - start,
        "processor": time.process_time() - used,
        "solving": sum(spent),
        "peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }


def measure(side: int, first: str, workers: int, folder: Path) -> Map:
    """Run one sweep in a process of its own."""
    path = folder / "map.h5"
    command = [sys.executable, __file__, "--sweep", str(side), first, str(workers), str(path)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    record = json.loads(done.stdout)
    size = path.stat().st_size / 1e6
    path.unlink()
    return Map(AXES[first], workers, file_mb=size, **record)


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=1000, help="values of each axis")
    parser.add_argument("--first", nargs="+", default=list(AXES), choices=AXES, help="slow axis")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, describe_machine()["cores"]])
    parser.add_argument("--rounds", type=int, default=3, help="runs, the fastest counts")
    parser.add_argument("--folder", type=Path, help="where the file goes (default: temporary)")
    parser.add_argument("--sweep", nargs=4, help=argparse.SUPPRESS)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "benchmarks" / "results")
    args = parser.parse_args()
    if args.sweep:
        side, first, workers, path = args.sweep
        print(json.dumps(sweep(int(side), first, int(workers), Path(path))))
        return
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        maps = [
            min(
                (measure(args.side, first, workers, Path(folder)) for _ in range(args.rounds)),
                key=lambda line: line.wall,
            )
            for first in args.first
            for workers in args.workers
        ]
    args.output.mkdir(parents=True, exist_ok=True)
    name = "map_to_hdf5.csv" if args.side == 1000 else f"map_to_hdf5_{args.side}.csv"
    write_csv(args.output / name, maps)
    print_columns([Map._fields], maps)


if __name__ == "__main__":
    sys.exit(main())
