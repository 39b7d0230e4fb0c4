"""Time per case of all figures of merit, for random cases in a batch.

``python benchmarks/batch_rate.py [--cases 200000]``

The cases are of three mechanisms in equal parts. The logarithm (base 10) of the inertia ratio is
uniform from -2 to 1, and friction is uniform from 0.05 to 0.9 of the Painlevé limit, so that no two
cases have the same solution. Blocks of cases go to threads as in a sweep; every number of workers
must give the same bits.
"""

import argparse
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np

import escapement as esc
from escapement.base.text import print_columns
from escapement.benchmark import describe_machine, write_csv
from escapement.dynamics.painleve import painleve_limit
from escapement.engines.energy import batch

ROOT = Path(__file__).resolve().parents[1]
SLOTS = (3, 4, 6)
BLOCK = 2000


class Rate(NamedTuple):
    """Shortest time of all cases at one tolerance, on a number of threads.

    wall : wall time of all cases [s].
    us_per_case : wall time per case [µs].
    processor_us_per_case : processor time of all threads per case [µs].
    speedup : wall time with one worker, divided by this one.
    """

    rtol: float
    workers: int
    cases: int
    wall: float
    us_per_case: float
    processor_us_per_case: float
    speedup: float
    failed: int


class Block(NamedTuple):
    """Consecutive cases of one mechanism."""

    mechanism: esc.Geneva
    ratio: np.ndarray
    friction: np.ndarray


def draw(cases: int, seed: int) -> list[Block]:
    """Random blocks; friction is drawn against each case's own limit."""
    rng = np.random.default_rng(seed)
    blocks = []
    for k in range(max(1, cases // BLOCK)):
        wheel = esc.Geneva(slots=SLOTS[k % len(SLOTS)])
        ratio = 10.0 ** rng.uniform(-2.0, 1.0, BLOCK)
        ends = wheel.breaks[0], wheel.breaks[-1]
        limits = np.array([painleve_limit(wheel.path, rho, *ends)[0] for rho in ratio])
        blocks.append(Block(wheel, ratio, rng.uniform(0.05, 0.9, BLOCK) * limits))
    return blocks


def solve(block: Block, rtol: float) -> tuple[np.ndarray, np.ndarray]:
    """Figures of merit and status of a block."""
    nothing = np.zeros(block.ratio.size)
    numbers = np.array([block.ratio, block.friction, block.friction, nothing, nothing])
    return batch.solve(block.mechanism, numbers, rtol)


def run(
    blocks: list[Block], rtol: float, workers: int
) -> tuple[tuple[float, float], list[np.ndarray]]:
    """Wall and processor time, and the figures of all blocks."""
    with ThreadPoolExecutor(workers) as pool:
        begin, used = time.perf_counter(), time.process_time()
        solved = list(pool.map(lambda block: solve(block, rtol), blocks))
        times = time.perf_counter() - begin, time.process_time() - used
    return times, [array for pair in solved for array in pair]


def measure(blocks: list[Block], rtol: float, most: int, rounds: int) -> list[Rate]:
    """Every number of workers takes its turn in each round."""
    counts = range(1, most + 1)
    times: dict[int, list[tuple[float, float]]] = {count: [] for count in counts}
    expected = run(blocks, rtol, 1)[1]
    for _ in range(rounds):
        for count in counts:
            spent, found = run(blocks, rtol, count)
            times[count].append(spent)
            for old, new in zip(expected, found, strict=True):
                if old.tobytes() != new.tobytes():
                    raise AssertionError(f"{count} workers give other bits than one")
    failed = sum(int(np.count_nonzero(status)) for status in expected[1::2])
    cases, rates = len(blocks) * BLOCK, []
    for count in counts:
        wall, used = (min(column) for column in zip(*times[count], strict=True))
        speedup = min(times[1])[0] / wall
        per_case = wall / cases * 1e6, used / cases * 1e6
        rates.append(Rate(rtol, count, cases, wall, *per_case, speedup, failed))
    return rates


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=200_000)
    parser.add_argument("--rtol", type=float, nargs="+", default=[1e-10, 1e-12])
    parser.add_argument("--workers", type=int, default=describe_machine()["cores"])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1973)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "benchmarks" / "results")
    args = parser.parse_args()
    blocks = draw(args.cases, args.seed)
    rates = [
        rate for rtol in args.rtol for rate in measure(blocks, rtol, args.workers, args.rounds)
    ]
    args.output.mkdir(parents=True, exist_ok=True)
    write_csv(args.output / "batch_rate.csv", rates)
    print_columns([Rate._fields], rates)


if __name__ == "__main__":
    sys.exit(main())
