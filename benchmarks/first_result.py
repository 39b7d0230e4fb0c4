"""Time of a new process until its first result, with and without compiled code.

``python benchmarks/first_result.py``

The cache of compiled code starts in an empty folder: the first line of each kind compiles, and the
others load that code. Times are those of the whole process, interpreter included; on a busy machine
read the processor time.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from escapement.base.text import print_columns
from escapement.benchmark import write_csv

ROOT = Path(__file__).resolve().parents[1]

TIMER = """
import escapement as esc
timer = esc.Escapement(
    esc.Geneva(slots=4), esc.Inertia(3.39e-7, 5.65e-6), torque=0.0113, friction=0.35
)
"""
EVERYTHING = """
import numpy as np
motion = esc.simulate(timer)
motion.extrema, motion.reversals, motion.samples, motion.ledger
esc.terminal(timer)
esc.simulate(timer, engine="ivp").extrema
esc.terminal(timer, engine="ivp")
loaded = esc.Escapement(timer.mechanism, timer.inertia, timer.torque, 0.2, timer.torque / 10)
esc.simulate(loaded, duration=0.5).samples
esc.simulate(esc.Escapement(timer.mechanism, timer.inertia, timer.torque)).samples
esc.simulate(esc.Escapement(esc.Geneva(slots=8), timer.inertia, timer.torque, 0.05)).samples
esc.sweep(timer, friction=np.linspace(0.1, 0.3, 10))
"""
RUN = [
    *("run", "--units", "in-lbf-s", "--torque", "0.1", "--friction", "0.35", "--json"),
    *("--driver-inertia", "3e-6", "--follower-inertia", "50e-6"),
]
PROCESSES = {
    "everything, nothing compiled": ["-c", TIMER + EVERYTHING],
    "everything": ["-c", TIMER + EVERYTHING],
    "simulate, 20 engagements": ["-c", TIMER + "esc.simulate(timer)"],
    "terminal": ["-c", TIMER + "esc.terminal(timer)"],
    "sweep, 1000 cases": ["-c", TIMER + "esc.sweep(timer, torque=[timer.torque] * 1000)"],
    "escapement run --json": ["-m", "escapement", *RUN],
    "escapement --version": ["-m", "escapement", "--version"],
    "import escapement": ["-c", "import escapement"],
    "the interpreter alone": ["-c", ""],
}


class Start(NamedTuple):
    """Shortest wall and processor time of a process [s] over several runs."""

    process: str
    wall: float
    processor: float
    runs: int


def measure(arguments: list[str], folder: str) -> tuple[float, float]:
    """Wall and processor time of one process that keeps compiled code in `folder`."""
    environment = os.environ | {"NUMBA_CACHE_DIR": folder}
    begin, used = time.perf_counter(), _used()
    subprocess.run(
        [sys.executable, *arguments], check=True, env=environment, stdout=subprocess.DEVNULL
    )
    return time.perf_counter() - begin, _used() - used


def _used() -> float:
    """Processor time of all child processes that have ended [s]."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return children.ru_utime + children.ru_stime


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "benchmarks" / "results")
    args = parser.parse_args()
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        for name, arguments in PROCESSES.items():
            rounds = 1 if "nothing compiled" in name else args.rounds
            times = [measure(arguments, folder) for _ in range(rounds)]
            walls, processors = zip(*times, strict=True)
            lines.append(Start(name, min(walls), min(processors), rounds))
    args.output.mkdir(parents=True, exist_ok=True)
    write_csv(args.output / "first_result.csv", lines)
    print_columns([Start._fields], lines)


if __name__ == "__main__":
    sys.exit(main())
