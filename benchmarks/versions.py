"""Run time of two versions of the package, which take turns in one run.

``python benchmarks/versions.py OLD [NEW] [--cpu x86-64-v3] [--rounds 3]``

A version is a commit, or "." for the files of this folder, the default of NEW. Each runs in a
process of its own, which waits while the other one computes: the speed of a machine changes by a
third within minutes, so times that are not taken by turns cannot be compared. A number is the
shortest processor time of many groups of calls. Questions that a version does not know are left
out. ``--cpu`` compiles for another processor that this one can run, such as one without AVX-512.
"""

import argparse
import gc
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
KEPT = Path(tempfile.gettempdir()) / "escapement-versions"
WORKER = "--worker"
SECONDS = 0.3  # each turn of a question takes this time
GROUP = 1e-4  # a group of calls takes at least this time [s]


def timers() -> dict[str, Callable[[], Any]]:
    """The escapements that are computed; each is made when it is asked for."""
    import escapement as esc

    inertia = esc.Inertia(driver=3e-6 * 0.1129848, follower=50e-6 * 0.1129848)
    wheel, torque = esc.Geneva(slots=4, pins=4), 0.01129848
    ideal = esc.Escapement(wheel, inertia, torque=torque, friction=0.35)

    def real() -> Any:
        thick = replace(wheel, crank_radius=0.01, pin_radius=0.0005)
        bodies = ("driver", "follower")
        journals = {f"{body}_bearing_friction": 0.15 for body in bodies}
        journals |= {f"{body}_bearing_radius": 0.0005 for body in bodies}
        drags = {f"{body}_drag": 0.01 * inertia.follower for body in bodies}
        held = {"driver_bearing_torque": 0.05 * torque}
        return replace(ideal, mechanism=thick, **journals, **drags, **held)

    def loose() -> Any:
        return replace(ideal, mechanism=replace(wheel, crank_radius=0.01, clearance=0.0001))

    return {
        "ideal": lambda: ideal,
        "load": lambda: replace(ideal, load_torque=0.1 * torque),
        "losses": real,
        "clearance": loose,
    }


def questions() -> dict[str, Callable[[], Any]]:
    """What is measured, by names; each has been computed once, so that it is compiled."""
    import numpy as np

    import escapement as esc

    shares = np.linspace(0.5, 1.0, 200)
    computed = {}
    for name, timer in timers().items():
        try:
            made = timer()
        except TypeError:  # a field that this version lacks
            continue
        friction, side = made.friction * shares, made.torque * shares[::10]
        calls = {
            f"simulate, {name}": lambda made=made: esc.simulate(made, engagements=20),
            f"terminal, {name}": lambda made=made: esc.terminal(made),
            f"batch, {name}": lambda made=made, axis=friction: esc.sweep(made, friction=axis),
            f"sweep, {name}": lambda made=made, axes=(friction[::10], side): esc.sweep(
                made, friction=axes[0], torque=axes[1]
            ),
        }
        if name == "clearance":
            calls = {"contact": calls["simulate, clearance"]}
        for question, call in calls.items():
            call()
            computed[question] = call
    return computed


def shortest(call: Callable[[], Any]) -> float:
    """Shortest processor time of a call [s], of many groups of calls."""
    size, best, begin = 1, float("inf"), time.perf_counter()
    gc.disable()
    while time.perf_counter() - begin < SECONDS:
        start = time.process_time()
        for _ in range(size):
            call()
        spent = time.process_time() - start
        if spent < GROUP:
            size *= 2  # reading the clock takes some time itself
        else:
            best = min(best, spent / size)
    gc.enable()
    return best


def work() -> None:
    """Answer for one version: names of its questions, then a time for each name asked for."""
    known = questions()
    print(json.dumps(list(known)), flush=True)
    for line in sys.stdin:
        print(shortest(known[line.strip()]), flush=True)


def sources(version: str) -> Path:
    """Folder with the Python sources of a commit, or of the working tree."""
    if version == ".":
        return ROOT / "src"
    found = ("git", "-C", str(ROOT), "rev-parse", "--verify", f"{version}^{{commit}}")
    commit = subprocess.run(found, check=True, capture_output=True, text=True).stdout.strip()
    folder = KEPT / commit
    if not folder.exists():
        packed = ("git", "-C", str(ROOT), "archive", commit, "src")
        archive = subprocess.run(packed, check=True, capture_output=True).stdout
        with tarfile.open(fileobj=io.BytesIO(archive)) as files:
            files.extractall(folder, filter="data")
    return folder / "src"


class Version:
    """A process that computes with one version, and waits in between."""

    def __init__(self, version: str, cpu: str | None) -> None:
        # a version that would begin with the Python source of its kernels compiles at once
        env = os.environ | {"PYTHONPATH": str(sources(version)), "ESCAPEMENT_COMPILE": "1"}
        if cpu:
            # without features of its own LLVM would add those of this machine
            env |= {"NUMBA_CPU_NAME": cpu, "NUMBA_CPU_FEATURES": ""}
        command, pipe = [sys.executable, __file__, WORKER], subprocess.PIPE
        self.process = subprocess.Popen(command, env=env, stdin=pipe, stdout=pipe, text=True)

    @cached_property
    def names(self) -> list[str]:
        """The questions that it knows."""
        return list(json.loads(self.process.stdout.readline()))

    def time(self, question: str) -> float:
        """Shortest time of a question [s]."""
        print(question, file=self.process.stdin, flush=True)
        return float(self.process.stdout.readline())


def measure(old: Version, new: Version, rounds: int) -> None:
    """Print the times of every question, and their ratio in each round and in all."""
    print(f"{'us':24}{'old':>10}{'new':>10}{'new/old':>9}   in each round")
    for name in new.names:
        both = [
            (old.time(name) if name in old.names else float("nan"), new.time(name))
            for _ in range(rounds)
        ]
        before, after = (min(column) for column in zip(*both, strict=True))
        each = " ".join(f"{y / x:.3f}" for x, y in both)
        print(f"{name:24}{1e6 * before:10.1f}{1e6 * after:10.1f}{after / before:9.3f}   {each}")


def main() -> None:
    """Compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old")
    parser.add_argument("new", nargs="?", default=".")
    parser.add_argument("--cpu", metavar="NAME", help="as LLVM calls it (default: this one)")
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    measure(Version(args.old, args.cpu), Version(args.new, args.cpu), args.rounds)


if __name__ == "__main__":
    sys.exit(work() if sys.argv[1:] == [WORKER] else main())
