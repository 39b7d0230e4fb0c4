"""Time and memory of `escapement measure` against the number of samples.

``python benchmarks/many_readings.py [--rows 10000 100000 1000000 10000000]``

Each number of rows is written as synthetic readings and measured in a process of its
own, statistics, shaft errors and periodogram included.
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import escapement as esc
from escapement.base.text import print_columns
from escapement.benchmark import write_csv
from escapement.measurement import measure, read_readings

ROOT = Path(__file__).resolve().parents[1]
DRIVE = esc.EllipticalPlanetary(0.016, 0.009)
PER_TURN = 200


class Cost(NamedTuple):
    """A file of readings, and time and memory to measure it.

    peak_memory : of the process [MB].
    """

    rows: int
    megabytes: float
    read_seconds: float
    total_seconds: float
    peak_memory: float


def measure_once(path: Path) -> None:
    """Read and measure a file; print what it took."""
    begin = time.perf_counter()
    readings = read_readings(path)
    read = time.perf_counter() - begin
    result = measure(readings, DRIVE, encoder=esc.Encoder(4096))
    figures = (result.chi_squared_test, result.published_test, result.anderson_darling_test)
    assert len(figures) == 3
    assert result.message
    assert result.periodogram.peak >= 0
    total = time.perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(json.dumps([path.stat().st_size / 1e6, read, total, peak]))


def cost(rows: int, folder: Path) -> Cost:
    """Write readings, measure them in a new process."""
    path = folder / "readings.csv"
    readings = esc.synthetic_readings(
        DRIVE, seed=1, samples=rows, turns=rows / PER_TURN, noise=0.01, encoder=esc.Encoder(4096)
    )
    esc.write_readings(readings, path, force=True)
    del readings
    done = subprocess.run(
        [sys.executable, __file__, "--measure", path], stdout=subprocess.PIPE, check=True
    )
    return Cost(rows, *json.loads(done.stdout))


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=int, nargs="+", default=[10**k for k in range(4, 8)])
    parser.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "benchmarks" / "results")
    args = parser.parse_args()
    if args.measure is not None:
        measure_once(args.measure)
        return
    with tempfile.TemporaryDirectory() as folder:
        costs = [cost(rows, Path(folder)) for rows in args.rows]
    args.output.mkdir(parents=True, exist_ok=True)
    write_csv(args.output / "many_readings.csv", costs)
    print_columns([Cost._fields], costs)


if __name__ == "__main__":
    sys.exit(main())
