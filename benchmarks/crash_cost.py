"""The cost of crash safety: a study of ten million cases with and without partial results.

    python benchmarks/crash_cost.py [--cases 10000000] [--workers 2] [--folder .]

Both runs solve and compress the same blocks. The first writes them straight into the file;
the second is what `escapement sweep` does.
"""

import argparse
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import escapement as esc
from escapement.study.block import blocks_of
from escapement.study.parse import plan_from
from escapement.study.plan import StudyPlan
from escapement.study.pool import in_threads
from escapement.study.running import (
    Work,
    frame_of,
    numerics,
    solve_block,
    solved_scenes,
    write_plan,
)
from escapement.study.writer import write_blocks


def study(cases: int) -> StudyPlan:
    timer = esc.Escapement(esc.Geneva(slots=4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113, 0.35)
    torque = np.linspace(0.005, 0.02, 1000)
    return plan_from(timer, {"friction": np.linspace(0.05, 0.4, cases // 1000), "torque": torque})


def write_once(plan: StudyPlan, path: Path, workers: int) -> None:
    frame = frame_of(plan)
    cut = blocks_of(frame)
    with in_threads(workers) as pool:
        work = Work(plan, cut, numerics(), solved_scenes(plan, pool))
        write_blocks(frame, path, pool.completed(solve_block, work, range(len(cut))), True)


def keep(plan: StudyPlan, path: Path, workers: int) -> None:
    write_plan(plan, path, force=True, workers=workers)


def timed(write: Callable, plan: StudyPlan, path: Path, workers: int) -> tuple[float, float]:
    """Seconds on the clock and of the processor, of all threads."""
    begin, used = time.perf_counter(), time.process_time()
    write(plan, path, workers)
    return time.perf_counter() - begin, time.process_time() - used


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", type=int, default=10_000_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--folder", default=".")
    args = parser.parse_args()
    timed(keep, study(100_000), Path(tempfile.mkdtemp()) / "warm.h5", 1)
    plan = study(args.cases)
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        once, kept = [], []
        for _ in range(args.rounds):
            once.append(timed(write_once, plan, Path(folder) / "once.h5", args.workers))
            kept.append(timed(keep, plan, Path(folder) / "kept.h5", args.workers))
        size = (Path(folder) / "kept.h5").stat().st_size
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{plan.cases} cases, {size / 1e6:.0f} MB, at most {memory:.0f} MiB of memory")
    for place, name in enumerate(("on the clock", "of the processor")):
        one, other = (min(times[place] for times in runs) for runs in (once, kept))
        print(f"{name}: written once {one:.2f} s, crash-safe {other:.2f} s, "
              f"ratio {other / one:.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
