"""Time of studies of imperfect parts, and of their engagements compared with ideal ones.

``python benchmarks/imperfect_parts.py [--cases 100000] [--workers 2] [--rounds 3]``

The wheel has four pins and four slots. A study is a whole process of ``escapement sweep``, from a
TOML file to HDF5. Engagements are compared by their processor times in one process, in which the
calls alternate; the table has medians.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import escapement as esc
from escapement.base.text import print_columns
from escapement.base.units import INCH_POUND
from escapement.benchmark import write_csv

RESULTS = Path(__file__).resolve().parent / "results"
STUDY = """friction = 0.3
torque = 0.0113
[mechanism]
kind = "geneva"
slots = 4
crank_radius = 0.01
{pin}
[inertia]
driver = 3.39e-7
follower = 5.65e-6
[sample]
method = "latin-hypercube"
size = {cases}
"""
ANGLES = ("slot_angle_errors", "pin_angle_errors")
LENGTHS = ("crank_radius_errors", "slot_offsets", "centre_distance_error")
SETS = {
    "angles": (dict.fromkeys(ANGLES, 1e-3), ""),
    "all errors": (dict.fromkeys(ANGLES, 1e-3) | dict.fromkeys(LENGTHS, 1e-5), ""),
    "all errors, wide pins": (
        dict.fromkeys(ANGLES, 1e-3) | dict.fromkeys(LENGTHS, 1e-5), "pin_radius = 0.0005"
    ),
}  # fmt: skip


class Study(NamedTuple):
    """A study of random sets: times of its process in seconds."""

    errors: str
    cases: int
    workers: int
    wall: float
    processor: float


class Cost(NamedTuple):
    """Time of an engagement in microseconds, and its ratio to that of an ideal one."""

    question: str
    errors: str
    ideal: float
    imperfect: float
    ratio: float


def sweep(name: str, cases: int, workers: int, folder: Path) -> Study:
    """One study in a process of its own."""
    tolerances, pin = SETS[name]
    text = STUDY.format(cases=cases, pin=pin)
    text += "".join(f"{key} = {{ tolerance = {size} }}\n" for key, size in tolerances.items())
    (folder / "study.toml").write_text(text)
    command = [sys.executable, "-m", "escapement", "sweep", str(folder / "study.toml"), "--quiet"]
    command += ["-o", str(folder / "study.h5"), "--force", "--workers", str(workers)]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Study(name, cases, workers, wall, used)


def timer(rng: np.random.Generator, name: str = "") -> esc.Escapement:
    """An escapement that differs from all before, ideal unless a set of errors is named."""
    inertia = esc.Inertia(3e-6 * INCH_POUND, 50e-6 * INCH_POUND)
    tolerances, pin = SETS.get(name, ({}, ""))
    errors: dict[str, Any] = {
        key: size * rng.uniform(-1.0, 1.0, None if key.startswith("centre") else 4)
        for key, size in tolerances.items()
    }
    wheel = esc.Geneva(4, crank_radius=0.01, pin_radius=5e-4 if pin else 0.0, **errors)
    return esc.Escapement(wheel, inertia, 0.1 * INCH_POUND, 0.3 + 1e-6 * rng.uniform())


def motion(drive: esc.Escapement) -> int:
    """A motion of 400 engagements."""
    return int(esc.simulate(drive, engagements=400).handoff_times.size)


def cycle(drive: esc.Escapement) -> int:
    """The figures of merit of a terminal cycle."""
    return len(esc.terminal(drive).beats)


def cost(question: Callable[[esc.Escapement], int], name: str) -> Cost:
    """Compare engagements; their calls alternate."""
    rng, times = np.random.default_rng(1), {"": [], name: []}
    for _ in range(200):
        for errors, found in times.items():
            drive = timer(rng, errors)
            start = time.process_time()
            count = question(drive)
            found.append(1e6 * (time.process_time() - start) / count)
    ideal, imperfect = (float(np.median(found)) for found in times.values())
    return Cost(question.__doc__ or "", name, ideal, imperfect, imperfect / ideal)


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=100_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3, help="runs, the fastest counts")
    args = parser.parse_args()
    costs = [cost(question, name) for question in (motion, cycle) for name in SETS]
    with tempfile.TemporaryDirectory() as folder:
        studies = [
            min(
                (sweep(name, args.cases, args.workers, Path(folder)) for _ in range(args.rounds)),
                key=lambda study: study.wall,
            )
            for name in SETS
        ]
    for name, rows in (("costs", costs), ("studies", studies)):
        write_csv(RESULTS / f"imperfect_{name}.csv", rows)
        print_columns([type(rows[0])._fields], rows)


if __name__ == "__main__":
    main()
