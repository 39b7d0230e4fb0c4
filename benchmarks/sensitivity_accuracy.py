"""How exact the derivatives of `escapement.sensitivities` are.

``python benchmarks/sensitivity_accuracy.py [DESIGNS]`` compares derivatives with those of 34
digits in ``tests/reference/derivatives.json``, and checks all derivatives of random designs by
another unit of mass, length or time, which changes no motion: for each unit the relative
derivatives of a figure, each times the power of the unit in its number, add up to the power in the
figure. It writes the greatest error of each figure to ``results/sensitivity_accuracy.csv``: as a
share of the derivative, or of the figure over the number if that is more, against 34 digits; and
the greatest error of a sum.
"""

import sys
from dataclasses import replace
from pathlib import Path
from random import Random

from common import write_rows

import escapement as esc

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))
from derivative_tools import errors_of_powers, worst_against_34_digits

FOLLOWER = 5e-6


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


def by_other_units(count):
    """The greatest error of a sum of relative derivatives of each figure, and where it is."""
    worst, random, designs = {}, Random(28), 0
    for case in range(count):
        try:
            found = esc.sensitivities(random_design(random))
        except ValueError:
            continue
        designs += 1
        for figure, missed, _ in errors_of_powers(found):
            worst[figure] = max(worst.get(figure, (0.0,)), (float(missed.max()), case, ""))
    print(f"{designs} designs with a cycle", file=sys.stderr)
    return worst


def main():
    """Compare, print and write."""
    designs = int((sys.argv[1:] or ["50"])[0])
    judges = {"34 digits": worst_against_34_digits(), "other units": by_other_units(designs)}
    rows = [
        (judge, figure, f"{error:.2e}", *where)
        for judge, worst in judges.items()
        for figure, (error, *where) in worst.items()
    ]
    write_rows("sensitivity_accuracy", rows, ("judge", "figure", "worst_error", "design", "number"))
    for row in rows:
        print(*row)


if __name__ == "__main__":
    main()
