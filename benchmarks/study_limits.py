"""One case of a study: solved, taken from a table, and written to the disk.

    python benchmarks/study_limits.py

An ideal mechanism that starts from rest depends on two numbers, friction and the ratio of inertias;
torque only scales its motion. So a table of these two, which is interpolated, is the limit of any
solver, and the disk that of any study. Runs alternate; times are the least processor times, that of
the disk the least on the clock.
"""

import os
import tempfile
import time
from functools import partial

import numpy as np
from common import write_rows
from limits import PROBLEM, ROUNDS, spent
from scipy.interpolate import RectBivariateSpline

import escapement as esc

BYTES = 2 * 36
"""What a study writes for a case: at most 36 bytes, first into its store and then into the file."""


def study(friction, **axes):
    """The periods of a study of friction and one other number, on one thread."""
    found = esc.sweep(PROBLEM.escapement, workers=1, results=["period"], friction=friction, **axes)
    return np.asarray(found["period"])


def cases():
    """Rows of one case of a study: solved, taken from a table, written."""
    own, rng = PROBLEM.escapement, np.random.default_rng(1)
    friction, far = np.linspace(0.05, 0.25, 100), own.inertia.driver * np.geomspace(0.5, 2.0, 100)
    torque = np.linspace(0.5, 2.0, 10_000) * own.torque
    table = RectBivariateSpline(friction, np.log(far), np.log(study(friction, driver_inertia=far)))
    x, y = np.sort(rng.uniform(0.05, 0.25, 30)), np.sort(rng.uniform(far[0], far[-1], 30))
    error = np.abs(np.exp(table(x, np.log(y))) / study(x, driver_inertia=y) - 1.0).max()
    many = rng.choice(friction, 10_000), np.log(rng.choice(far, 10_000))
    rows = [
        ("each case solved", 0.0, 1e4, partial(study, friction, driver_inertia=far)),
        ("solved once for all torques", 0.0, 1e6, partial(study, friction, torque=torque)),
        ("a table of two numbers", error, 1e4, partial(table.ev, *many)),
    ]
    times = np.min([[spent(run) for *_, run in rows] for _ in range(ROUNDS)], axis=0)
    found = [
        (name, f"{error:.1e}", f"{1e6 * took / count:.3g}")
        for (name, error, count, _), took in zip(rows, times, strict=True)
    ]
    return [*found, ("its bytes on the disk", 0.0, f"{written(1_000_000):.3g}")]


def written(count):
    """Time of writing the bytes of so many cases down to the disk [us a case]."""
    took = []
    for _ in range(ROUNDS):
        began = time.perf_counter()
        with tempfile.TemporaryFile(dir=".") as file:
            file.write(os.urandom(BYTES) * count)
            file.flush()
            os.fsync(file.fileno())
        took.append(time.perf_counter() - began)
    return 1e6 * min(took) / count


if __name__ == "__main__":
    write_rows("study_limits", cases(), ("what", "error", "microseconds a case"))
