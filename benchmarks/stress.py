"""Compares random cases with independent results: no wrong number may have status ok.

    python benchmarks/stress.py bulk|ivp [--first 0] [--cases N] [--seed 1973]

There are two comparisons, of mechanisms with 3 to 1000 slots, external and internal, inertia
ratios of 1e-8 to 1e8, friction from 1e-12 to 0.999999 of the Painleve limit, loads from
none to more than the drive carries, starts at rest and at up to 1000 natural units of
speed, and tolerances of 1e-13 to 1e-3:

    bulk   the `energy` engine against the Taylor integrator of `independent`
    ivp    both engines and that integrator, on fewer engagements

A number that differs by more than ten times the tolerance is computed again by `judge.py` with 34
digits, which also computes how much one rounding error in each parameter changes the number. It is
called wrong only if its error exceeds both.

Case number i is the same in every run: 100 000 of bulk and 10 000 of ivp, or N from the first on.
The counts go to results/stress_PART.csv, and the cases that failed to stress_PART.failures.csv.
"""

import argparse

import numpy as np
from common import write_rows
from comparison import ENGAGEMENTS, OUTCOMES, case_results
from random_cases import Problem, draw

CASES = {"bulk": 100_000, "ivp": 10_000}
LIMITS = {"error <= 0.1 rtol": 0.1, "error <= rtol": 1.0, "error <= 10 rtol": 10.0}
COUNTS = (*OUTCOMES, *LIMITS)
WORST = "worst ok error / rtol"
WARM_UP = Problem(4, 4, False, 0.06, 0.35, 0.01, 0.0, 1e-9, 0.86)
"""A first case, which compiles what the others need."""
FAILED = ("engine", "outcome", "error / rtol", "told", *Problem._fields)


def added(table, results):
    """Counts of a table {engine: row}, with the results of one more case."""
    for engine, kind, error, _told in results:
        row = table.setdefault(engine, dict.fromkeys(("cases", *COUNTS), 0) | {WORST: 0.0})
        row["cases"] += 1
        row[kind] += 1
        if kind == "ok":
            for name, limit in LIMITS.items():
                row[name] += error <= limit
            row[WORST] = max(row[WORST], error)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=CASES)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--cases", type=int, help="how many cases")
    parser.add_argument("--seed", type=int, default=1973)
    asked = parser.parse_args()
    part, seed, table, failures = asked.part, asked.seed, {}, []
    case_results(part, WARM_UP, ENGAGEMENTS[part])
    for index in range(asked.first, asked.first + (asked.cases or CASES[part])):
        problem = draw(np.random.default_rng([seed, part == "ivp", index]))
        results = case_results(part, problem, ENGAGEMENTS[part])
        added(table, results)
        for engine, kind, error, told in results:
            if kind not in ("ok", "beyond doubles"):
                failures.append([engine, kind, f"{error:.3g}", told, *problem])
                print(index, *failures[-1], flush=True)
    rows = [
        {"engine": engine, "seed": seed, **row, WORST: f"{row[WORST]:.3g}"}
        for engine, row in table.items()
    ]
    write_rows(f"stress_{part}", rows)
    write_rows(f"stress_{part}.failures", failures, FAILED)


if __name__ == "__main__":
    main()
