"""The cost of crash safety, and of HDF5's own encoding, in a study of ten million cases.

    python benchmarks/crash_cost.py [--cases 10000000] [--workers 2] [--folder .]

Three runs solve the same blocks, by turns. The first writes them straight into the file; the second
is what `escapement sweep` does; the third keeps plain numbers instead of encoded chunks, and lets
HDF5 shuffle, compress and checksum them when it writes the file.
"""

import argparse
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from unittest import mock

import h5py
import numpy as np

import escapement as esc
from escapement.base import files
from escapement.study import running, writer
from escapement.study.block import Block, blocks_of
from escapement.study.hdf5 import create_datasets
from escapement.study.parse import plan_from
from escapement.study.plan import StudyPlan
from escapement.study.pool import in_threads
from escapement.study.running import frame_of, write_plan
from escapement.study.solving import Work, numerics, solve_block, solved_scenes
from escapement.study.writer import write_blocks


def study(cases: int) -> StudyPlan:
    timer = esc.Escapement(esc.Geneva(slots=4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113, 0.35)
    torque = np.linspace(0.005, 0.02, 1000)
    return plan_from(timer, {"friction": np.linspace(0.05, 0.4, cases // 1000), "torque": torque})


def write_once(plan: StudyPlan, path: Path, workers: int) -> None:
    frame = frame_of(plan)
    cut = blocks_of(frame)
    with in_threads(workers) as pool:
        work = Work(plan, cut, numerics(), True, solved_scenes(plan, pool))
        write_blocks(frame, path, pool.completed(solve_block, work, range(len(cut))), True)


def keep(plan: StudyPlan, path: Path, workers: int) -> None:
    write_plan(plan, path, force=True, workers=workers)


def plain_block(work: Work, number: int) -> Block:
    """A block whose chunks are not encoded."""
    block = solve_block(work._replace(encoded=False), number)
    chunks = [values.tobytes() for values in block.data.values()]
    sizes = np.array([len(chunks), *map(len, chunks)], "<u4")
    return block._replace(data=b"".join((sizes.tobytes(), *chunks)))


def write_plain(frame, path, blocks, force, temporary) -> None:
    """Write blocks that are not encoded."""
    cut = blocks_of(frame)
    with files.pending_hdf5(path, force, temporary) as (hdf5, _):
        results = create_datasets(hdf5, frame, cut.tile)
        for block in blocks:
            first, (start, stop) = cut.offset(block.number), cut.span(block.number)
            for dataset, data in zip(results, block.chunks, strict=True):
                shape = list(cut.tile)
                axis = next((k for k, n in enumerate(shape) if n > 1), 0)
                shape[axis] = (stop - start) // max(int(np.prod(shape[axis + 1 :])), 1)
                box = tuple(slice(o, o + n) for o, n in zip(first, shape, strict=True))
                dataset[box] = np.frombuffer(data, dataset.dtype).reshape(shape)


def by_hdf5(plan: StudyPlan, path: Path, workers: int) -> None:
    with (
        mock.patch.object(running, "solve_block", plain_block),
        mock.patch.object(writer, "write_hdf5", write_plain),
    ):
        keep(plan, path, workers)


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
    ways = {"written once": write_once, "crash-safe": keep, "encoded by HDF5": by_hdf5}
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        spent: dict[str, list] = {name: [] for name in ways}
        for _ in range(args.rounds):
            for name, write in ways.items():
                path = Path(folder) / f"{write.__name__}.h5"
                spent[name].append(timed(write, plan, path, args.workers))
        size = (Path(folder) / "keep.h5").stat().st_size
        with h5py.File(Path(folder) / "keep.h5") as one, h5py.File(path) as other:
            assert all(np.array_equal(one[n], other[n], equal_nan=True) for n in one)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{plan.cases} cases, {size / 1e6:.0f} MB, at most {memory:.0f} MiB of memory")
    for place, clock in enumerate(("on the clock", "of the processor")):
        least = {name: min(times[place] for times in runs) for name, runs in spent.items()}
        shown = (f"{name} {s:.2f} s ({s / least['crash-safe']:.2f})" for name, s in least.items())
        print(f"{clock}: {', '.join(shown)}")


if __name__ == "__main__":
    main()
