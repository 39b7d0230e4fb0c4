"""Writes the benchmark's reference from the 40-digit integrator of the tests.

``python benchmarks/make_reference.py`` takes about a minute and needs mpmath. Every
problem is solved at two precisions, orders and tolerances; their largest relative
difference is kept as ``error``.
"""

import json
import sys
from dataclasses import asdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "reference"))

from generate import reference  # noqa: E402

from escapement.benchmark.problems import PROBLEMS, REFERENCE, Problem  # noqa: E402

KEPT = ("error", "handoff_times", "handoff_velocities")


def solved(problem: Problem) -> dict[str, object]:
    """A problem's inputs and its answer."""
    data = asdict(problem) | {"pins": problem.escapement.mechanism.pins, "internal": False}
    data |= {"load_torque": 0.0, "initial_speed": 0.0}
    del data["title"]
    record = reference(data)
    return {key: record[key] for key in (*data, *KEPT)}


def main() -> None:
    """Solve all problems and replace the data file."""
    records = {problem.name: solved(problem) for problem in PROBLEMS}
    for name, record in records.items():
        print(name, "error", record["error"])
    target = ROOT / "src" / "escapement" / "benchmark" / REFERENCE
    target.write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
