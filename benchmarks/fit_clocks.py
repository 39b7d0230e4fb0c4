"""Fits of run-ups whose logger's clock was started at different times.

``python benchmarks/fit_clocks.py [--seeds 100]``

For each seed the same noisy angles are fitted with times from 0, 60 and 1000 s and in Unix time.
An interval is right if it contains the true value.
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np

import escapement as esc
from escapement.base.text import print_columns
from escapement.benchmark import write_csv
from escapement.measurement import MotionFit

RESULT = Path(__file__).resolve().parent / "results" / "fit_clocks.csv"
ORIGINS = {"0 s": 0.0, "60 s": 60.0, "1000 s": 1000.0, "Unix time in ms": 1_764_100_000.0}
TRUTH = np.array([0.22, 0.010])
WHEEL, INERTIA = esc.Geneva(4), esc.Inertia(3.39e-7, 5.65e-6)


class Row(NamedTuple):
    """For how many seeds an interval contained the true value.

    explained : for how many the verdict is that the model explains the motion.
    half_width_percent : the greatest half-width over the true value.
    apart : greatest relative difference of an estimate, or of a half-width, from that with times
        from 0 s.
    """

    clock: str
    number: str
    seeds: int
    inside: int
    explained: int
    half_width_percent: float
    apart: float


def fits_of(seed: int, motion: esc.Motion, guess: esc.Escapement) -> list[MotionFit]:
    """The fit of one run-up at each start of the clock."""
    random = np.random.default_rng(seed)
    time = np.linspace(-0.02, 1.0, 500) * motion.end_time
    angle = motion.at(np.clip(time, 0.0, None)).theta
    angle = angle + np.radians(0.3) * random.standard_normal(time.size)
    nothing = np.full(time.size, np.nan)
    return [
        esc.fit_motion(esc.Readings(angle, nothing, time=time - time[0] + origin), guess)
        for origin in ORIGINS.values()
    ]


def main() -> None:
    """Fit all run-ups, print and write how often the intervals are right."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=100)
    seeds = parser.parse_args().seeds
    motion = esc.simulate(esc.Escapement(WHEEL, INERTIA, TRUTH[1], TRUTH[0]), 15)
    guess = esc.Escapement(WHEEL, INERTIA, 0.02, 0.1)
    found = [fits_of(seed, motion, guess) for seed in range(seeds)]
    values = np.array([[fit.values for fit in row] for row in found])
    halves = np.array([[fit.half_widths for fit in row] for row in found])
    inside = (np.abs(values - TRUTH) <= halves).sum(axis=0)
    good = np.array([[fit.verdict.good is True for fit in row] for row in found]).sum(axis=0)
    apart = [np.abs(it / it[:, :1] - 1.0).max(axis=0) for it in (values, halves)]
    rows = []
    for j, origin in enumerate(ORIGINS):
        for k, name in enumerate(("friction", "torque")):
            width = 100.0 * float(halves[:, j, k].max()) / float(TRUTH[k])
            far = max(float(one[j, k]) for one in apart)
            rows.append(Row(origin, name, seeds, int(inside[j, k]), int(good[j]), width, far))
    print_columns([list(Row._fields)], [list(row) for row in rows])
    if seeds == 100:
        write_csv(RESULT, rows)


if __name__ == "__main__":
    main()
