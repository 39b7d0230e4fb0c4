"""Compares random cases with independent results: no wrong number may have status ok.

    python benchmarks/stress.py bulk|ivp [--cases N] [--seconds S] [--seed 1973]

There are two comparisons, of mechanisms with 3 to 1000 slots, external and internal, inertia
ratios of 1e-8 to 1e8, friction from 1e-12 to 0.999999 of the Painleve limit, loads from
none to more than the drive carries, starts at rest and at up to 1000 natural units of
speed, and tolerances of 1e-13 to 1e-3:

    bulk   the `energy` engine against the Taylor integrator of `independent`
    ivp    both engines and that integrator, on fewer engagements

A number that differs by more than ten times the tolerance is computed again by `judge.py` with 34
digits, which also computes how much one rounding error in each parameter changes the number. It is
called wrong only if its error exceeds both. A case that takes more than five minutes is given up.

Case number i is the same in every run. Each run goes on where the last one stopped, adds its
counts to results/stress_PART.csv and lists the cases that failed in stress_PART.failures.csv,
until N cases are done (100 000 of bulk, 10 000 of ivp). It can thus be run in parts of S seconds.
--again starts over.
"""

import argparse
import math
import multiprocessing as mp
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from comparison import ENGAGEMENTS, case_results, compare_terminal, expected, simulated
from counts import added, append, read, write
from random_cases import Problem, draw

CASES = {"bulk": 100_000, "ivp": 10_000}
SLICE = 500  # cases between two writes
PATIENCE = 300.0  # seconds of silence, the judge's included, after which a case counts as hung
RESULTS = Path(__file__).resolve().parent / "results"


def work(part, seed, first, last, pipe):
    """Compute cases first..last of a part; send two messages for each, at its start and its end."""
    engagements = ENGAGEMENTS[part]
    warm_up = Problem(4, 4, False, 0.06, 0.35, 0.01, 0.0, 1e-9, 0.86)
    expected(warm_up, 1)
    compare_terminal(warm_up)
    simulated(warm_up, "energy", 1e-9, 1)
    simulated(warm_up, "ivp", 1e-9, 1)
    for index in range(first, last):
        problem = draw(np.random.default_rng([seed, part == "ivp", index]))
        pipe.send((index, problem, None))
        pipe.send((index, problem, case_results(part, problem, engagements)))


def run(part, first, last, seed, end, report):
    """Compute cases first..last of a part until the time `end`; returns the next case's number."""
    context = mp.get_context("spawn")
    index = first
    while index < last and time.perf_counter() < end:
        near, far = context.Pipe(duplex=False)
        worker = context.Process(target=work, args=(part, seed, index, last, far), daemon=True)
        worker.start()
        far.close()
        problem, patience, lost = None, 6 * PATIENCE, ""  # a first case compiles
        while index < last and time.perf_counter() < end:
            if not near.poll(patience):
                lost = "hang"
                break
            try:
                index, problem, rows = near.recv()
            except EOFError:
                lost = "crash"
                break
            patience = PATIENCE
            if rows is not None:
                report(problem, rows)
                index += 1
        worker.terminate()
        worker.join()
        if lost:
            if problem is None or worker.exitcode == 1:
                raise RuntimeError("the comparison itself failed")
            report(problem, [("energy", lost, math.nan, f"exit code {worker.exitcode}")])
            index += 1
    return index


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=CASES)
    parser.add_argument("--cases", type=int, help="cases in all, those of earlier runs included")
    parser.add_argument("--seconds", type=float, default=math.inf, help="length of this run")
    parser.add_argument("--seed", type=int, default=1973)
    parser.add_argument("--again", action="store_true", help="start over")
    parser.add_argument("--out", type=Path, default=RESULTS)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / f"stress_{options.part}.csv"
    failures = path.with_suffix(".failures.csv")
    if options.again:
        path.unlink(missing_ok=True)
        failures.unlink(missing_ok=True)
    table, first = read(path, options.seed)
    last = CASES[options.part] if options.cases is None else options.cases
    end = time.perf_counter() + options.seconds
    while first < last and time.perf_counter() < end:
        lines = []

        def report(problem, results, lines=lines):
            added(table, results)
            for engine, kind, error, told in results:
                if kind not in ("ok", "beyond doubles"):
                    lines.append([engine, kind, f"{error:.3g}", told, *problem])

        until = min(first + SLICE, last)
        first = run(options.part, first, until, options.seed, end, report)
        write(path, table, options.seed)
        append(failures, lines)
        wrong = {engine: row["cases"] - row["ok"] for engine, row in table.items()}
        print(f"{first} of {last} cases, not ok: {wrong}", flush=True)


if __name__ == "__main__":
    main()
