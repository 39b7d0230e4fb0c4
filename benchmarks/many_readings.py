"""Time and memory of `escapement measure` against the number of samples.

``python benchmarks/many_readings.py [--decades 7]``

Each number of rows, from 10^4 to 10^7, is written as synthetic readings and measured in a process
of its own, statistics, shaft errors and periodogram included.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from common import asked, tell

import escapement as esc
from escapement.measurement import measure, read_readings

DRIVE = esc.EllipticalPlanetary(0.016, 0.009)
PER_TURN = 200


def measure_once(path):
    """Read and measure a file; print its size and what it took, with the peak of memory."""
    begin = time.perf_counter()
    readings = read_readings(path)
    read = time.perf_counter() - begin
    assert measure(readings, DRIVE, encoder=esc.Encoder(4096)).periodogram.peak >= 0
    total = time.perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(json.dumps([path.stat().st_size / 1e6, read, total, peak]))


def cost(rows, folder):
    """Write readings, measure them in a new process."""
    path = folder / "readings.csv"
    readings = esc.synthetic_readings(
        DRIVE, seed=1, samples=rows, turns=rows / PER_TURN, noise=0.01, encoder=esc.Encoder(4096)
    )
    esc.write_readings(readings, path, force=True)
    del readings
    done = subprocess.run([sys.executable, __file__, path], stdout=subprocess.PIPE, check=True)
    names = ("rows", "megabytes", "read_seconds", "total_seconds", "peak_memory")
    return dict(zip(names, [rows, *json.loads(done.stdout)], strict=True))


def main():
    """Measure, print, write."""
    decades, whole = asked(__doc__, decades=7)
    with tempfile.TemporaryDirectory() as folder:
        costs = [cost(10**k, Path(folder)) for k in range(4, decades + 1)]
    tell("many_readings", costs, whole)


if __name__ == "__main__":
    measure_once(Path(sys.argv[1])) if sys.argv[1:2] and sys.argv[1].endswith(".csv") else main()
