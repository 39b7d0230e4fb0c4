"""Whether a brute-force grid finds better designs than `escapement.design`.

``python benchmarks/design_grid.py [POINTS]`` takes the requirement of ``runs/thirty_seconds.toml``.
On a grid of POINTS inertia ratios, radii and torques of every wheel it computes all figures at all
three frictions by `sweep`, without interpolation, and counts the designs of the grid that satisfy
all bounds and are better than a design of the front by more than one per cent in every objective.
Results go to ``results/design_grid.csv``.
"""

import sys
import time
from pathlib import Path

import numpy as np
from common import write_rows

import escapement as esc
from escapement.inverse_design.similarity import wheels_for
from escapement.inverse_design.timer_search import misses

ROOT = Path(__file__).resolve().parents[1]


def of_wheel(wheel, requirement, points):
    """Figures of a grid of designs of one wheel, each an array."""
    names = ("inertia_ratio", "crank_radius", "torque")
    axes = [np.geomspace(*getattr(requirement, name), points) for name in names]
    ratios, radii, torques = (x.reshape(-1) for x in np.meshgrid(*axes, indexing="ij"))
    table = np.repeat(wheel.exact({"driver_inertia": axes[0]}), points**2, axis=0)
    inertias = torques * (wheel.period / np.exp(table[:, 0])) ** 2
    numbers = ratios, radii, torques, inertias
    return wheel.in_si(table, dict(zip((*names, "follower_inertia"), numbers, strict=True)))


def main():
    """Compare, print and write."""
    points = int((sys.argv[1:] or ["24"])[0])
    requirement, _ = esc.load_requirement(ROOT / "runs" / "thirty_seconds.toml")
    esc.design(requirement)
    start = time.perf_counter()
    found = esc.design(requirement)
    took = time.perf_counter() - start
    front = np.array([[d.values[name] for name in requirement.objectives] for d in found.designs])
    tried = good = better = 0
    most = 0.0
    for wheel in wheels_for(requirement):
        values = of_wheel(wheel, requirement, points)
        kept = misses(values, requirement).sum(axis=0) == 0.0
        tried, good = tried + kept.size, good + int(kept.sum())
        costs = np.column_stack([values[name][kept] for name in requirement.objectives])
        for row in front:
            gain = (1.0 - costs / row).min(axis=1)
            better += int((gain > 0.01).sum())
            most = max(most, float(gain.max(initial=0.0)))
    rows = [("seconds", f"{took:.2f}"), ("designs", len(front)), ("grid", tried),
            ("within_bounds", good), ("better_by_one_per_cent", better),
            ("greatest_gain", f"{most:.2g}")]  # fmt: skip
    write_rows("design_grid", rows, ("figure", "value"))
    for row in rows:
        print(*row)


if __name__ == "__main__":
    main()
