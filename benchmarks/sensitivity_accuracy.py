"""How exact the derivatives of `escapement.sensitivities` are.

``python benchmarks/sensitivity_accuracy.py [DESIGNS]`` compares derivatives with those of 34
digits in ``tests/reference/derivatives.json``, and checks all derivatives of random designs by
another unit of mass, length or time, which changes no motion: for each unit the relative
derivatives of a figure, each times the power of the unit in its number, add up to the power in the
figure. It writes the greatest error of each figure to ``results/sensitivity_accuracy.csv``: as a
share of the derivative, or of the figure over the number if that is more, against 34 digits; and
the greatest error of a sum.
"""

import csv
import json
import sys
from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np

import escapement as esc
from escapement.model.numbers import with_number
from escapement.study.plan import unit_kind
from escapement.tolerance.derivatives import slopes_of

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results" / "sensitivity_accuracy.csv"
REFERENCE = ROOT / "tests" / "reference" / "derivatives.json"
FOLLOWER = 5e-6
UNITS = {
    "torque": (1, 2, -2), "inertia": (1, 2, 0), "drag": (1, 2, 0), "viscous": (1, 2, -1),
    "length": (0, 1, 0), "time": (0, 0, 1), "speed": (0, 0, -1), "acceleration": (0, 0, -2),
    "force": (1, 1, -2), "energy": (1, 2, -2),
}  # fmt: skip
"""Powers of mass, length and time of a unit; an angle and a ratio have none."""


def random_design(random):
    """A random escapement with some effects of real parts."""
    n, own = random.randint(3, 8), {}
    if random.random() < 0.6:
        own["crank_radius"] = 0.01
        if random.random() < 0.6:
            own["pin_radius"] = random.uniform(1e-4, 8e-4)
        if random.random() < 0.5:
            pins = esc.Geneva(n).pins
            errors = {"pin_angle_errors": (pins, 3e-4), "crank_radius_errors": (pins, 5e-6)}
            errors |= {"slot_angle_errors": (n, 3e-4), "slot_offsets": (n, 5e-6)}
            own["centre_distance_error"] = random.gauss(0.0, 5e-6)
            for name, (count, size) in errors.items():
                own[name] = tuple(random.gauss(0.0, size) for _ in range(count))
    inertia = esc.Inertia(10.0 ** random.uniform(-1.5, 0.5) * FOLLOWER, FOLLOWER)
    timer = esc.Escapement(esc.Geneva(n, **own), inertia, torque=random.uniform(0.005, 0.02))
    plain = {key: own[key] for key in ("crank_radius", "pin_radius") if key in own}
    limit = esc.critical_friction(esc.Geneva(n, **plain), inertia)
    some = {"friction": min(limit, 2.0) * random.uniform(0.1, 0.7)}
    for name, size in {
        "load_torque": 0.1 * timer.torque, "driver_bearing_torque": 0.1 * timer.torque,
        "driver_drag": 0.05 * FOLLOWER, "follower_drag": 0.05 * FOLLOWER,
        "driver_viscous": 0.05 * (FOLLOWER * timer.torque) ** 0.5,
        "follower_viscous": 0.05 * (FOLLOWER * timer.torque) ** 0.5,
    }.items():  # fmt: skip
        if random.random() < 0.35:
            some[name] = size * random.uniform(0.1, 1.0)
    if own and random.random() < 0.4:
        for body in ("driver", "follower"):
            some[f"{body}_bearing_friction"] = random.uniform(0.05, 0.2)
            some[f"{body}_bearing_radius"] = random.uniform(1e-4, 1e-3)
    return replace(timer, **some)


def in_34_digits():
    """The greatest error of each figure against derivatives of 34 digits, and where it is."""
    worst = {}
    for case, design in enumerate(json.loads(REFERENCE.read_text(encoding="utf-8"))):
        wheel = esc.Geneva(design["slots"], pins=design["pins"], internal=design["internal"])
        inertia = esc.Inertia(design["driver_inertia"], design["follower_inertia"])
        others = {name: design[name] for name in ("torque", "friction", "load_torque")}
        timer, number = esc.Escapement(wheel, inertia, **others), design["number"]
        figures, exact = esc.terminal(timer), design["derivatives"]

        def solve(name, value, timer=timer):
            return esc.terminal(with_number(timer, name, value))

        slopes = slopes_of(solve, timer, figures, {number: design[number]}, [*exact])[number]
        for figure, text in exact.items():
            scale = max(abs(float(text)), abs(getattr(figures, figure) / design[number]))
            error = abs(slopes[figure].below - float(text)) / scale
            worst[figure] = max(worst.get(figure, (0.0,)), (error, case, number))
    return worst


def by_other_units(count):
    """The greatest error of a sum of relative derivatives of each figure, and where it is."""
    worst, random, designs = {}, Random(28), 0
    for case in range(count):
        try:
            found = esc.sensitivities(random_design(random))
        except ValueError:
            continue
        designs += 1
        for figure, shares in found.relative.items():
            if not shares:
                continue
            powers = np.array([UNITS.get(unit_kind(name), (0, 0, 0)) for name in shares])
            sums = np.array([*shares.values()]) @ powers
            error = float(np.abs(sums - UNITS.get(unit_kind(figure), (0, 0, 0))).max())
            worst[figure] = max(worst.get(figure, (0.0,)), (error, case, ""))
    print(f"{designs} designs with a cycle", file=sys.stderr)
    return worst


def main():
    """Compare, print and write."""
    designs = int((sys.argv[1:] or ["50"])[0])
    judges = {"34 digits": in_34_digits(), "other units": by_other_units(designs)}
    rows = [
        (judge, figure, f"{error:.2e}", *where)
        for judge, worst in judges.items()
        for figure, (error, *where) in worst.items()
    ]
    with RESULTS.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerows([("judge", "figure", "worst_error", "design", "number"), *rows])
    for row in rows:
        print(*row)


if __name__ == "__main__":
    main()
