"""How exact the derivatives of `escapement.sensitivities` are.

``python benchmarks/sensitivity_accuracy.py [DESIGNS]`` compares them with differences of the
figures over random designs (Richardson's extrapolation, with steps that fall from 1 % of the
number until its own error estimate is least), and in ten designs with differences of figures
computed to 34 digits. It writes the greatest error of each figure, as a share of the figure over
the number, and the estimated error of the difference there to
``results/sensitivity_accuracy.csv``.
"""

import csv
import math
import sys
from dataclasses import replace
from pathlib import Path
from random import Random

import escapement as esc
from escapement.model.numbers import numbers_of, with_number

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results" / "sensitivity_accuracy.csv"
FOLLOWER = 5e-6
SHARES = tuple(0.01 * 4.0**-k for k in range(9))
"""Steps of differences, as shares of the number."""
ROUNDING = 1e-15
"""Rounding error of a figure that is assumed, as a share of the figure."""
LENGTHS = ("crank_radius", "pin_radius", "centre_distance_error")


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


def richardson(timer, name, figures, value):
    """Derivatives of figures by differences, and the estimated error of each.

    Steps are reduced until the estimated error grows again. The estimate is the difference of two
    extrapolations, plus the effect of rounding errors of the figures. It is large if a step reaches
    over a corner of the figure.
    """
    best = {}
    for share in SHARES:
        step = share * abs(value)
        at = {k: esc.terminal(with_number(timer, name, value + k * step)).as_dict()
              for k in (-4, -2, -1, 1, 2, 4)}  # fmt: skip
        for figure in figures:
            one, two, four = ((at[k][figure] - at[-k][figure]) / (2 * k * step) for k in (1, 2, 4))
            fine, rough = (4.0 * one - two) / 3.0, (4.0 * two - four) / 3.0
            found = (16.0 * fine - rough) / 15.0
            doubt = abs(found - fine) + ROUNDING * abs(at[1][figure]) / step
            if not doubt >= best.get(figure, (0.0, math.inf))[1]:
                best[figure] = found, doubt
    return best


def compare(count):
    """The greatest error of each figure over random designs, and the error of the difference."""
    worst, random, designs, pairs = {}, Random(28), 0, 0
    for case in range(count):
        timer = random_design(random)
        try:
            exact = esc.sensitivities(timer)
        except ValueError:
            continue
        designs += 1
        numbers = {name: value for name, value in numbers_of(timer).items() if value}
        values = exact.figures.as_dict()
        for name in random.sample(sorted(numbers), min(3, len(numbers))):
            judged = richardson(timer, name, exact.absolute, numbers[name])
            for figure, (found, doubt) in judged.items():
                if not values[figure]:
                    continue
                pairs += 1
                scale = abs(numbers[name] / values[figure])
                error = scale * abs(exact.absolute[figure][name] - found)
                if not error <= worst.get(figure, (-1.0,))[0]:
                    worst[figure] = error, scale * doubt, case, name
        print(case, file=sys.stderr)
    print(f"{designs} designs with a cycle, {pairs} derivatives", file=sys.stderr)
    return worst


def in_34_digits(count=10):
    """The worst relative error of figures' derivatives against differences of 34 digits."""
    sys.path.insert(0, str(ROOT / "tests" / "reference"))
    from mpmath import mp, mpf
    from taylor import solve

    figures = ("period", "velocity_max", "velocity_min", "handoff_velocity", "contraction")
    worst, random = dict.fromkeys(figures, 0.0), Random(34)
    fine = {"digits": 42, "order": 32, "tolerance": "1e-29"}
    for _ in range(count):
        slots = random.choice((3, 4, 6))
        wheel, inertia = esc.Geneva(slots), esc.Inertia(random.uniform(0.05, 0.5), 1.0)
        friction = random.uniform(0.5, 0.8) * esc.critical_friction(wheel, inertia)
        data = {"slots": slots, "pins": wheel.pins, "internal": False, "friction": friction}
        data |= {"driver_inertia": inertia.driver, "follower_inertia": 1.0, "torque": 1.0}
        data |= {"load_torque": 0.0, "initial_speed": 0.0, "engagements": 4}
        name = random.choice(("friction", "driver_inertia", "follower_inertia"))
        own = esc.sensitivities(esc.Escapement(wheel, inertia, torque=1.0, friction=friction))
        with mp.workdps(42):
            step = mpf(10) ** -11
            low, high = (
                solve(data | {name: mpf(data[name]) + k * step}, fine)["terminal"] for k in (-1, 1)
            )
            for figure in figures:
                exact = (high[figure] - low[figure]) / (2 * step)
                error = float(abs(own.absolute[figure][name] - exact) / abs(exact))
                worst[figure] = max(worst[figure], error)
        print(slots, name, worst, file=sys.stderr)
    return worst


def main():
    """Compare, print and write."""
    designs = int((sys.argv[1:] or ["300"])[0])
    rows = [
        (name, f"{x:.2e}", f"{y:.2e}", *more) for name, (x, y, *more) in compare(designs).items()
    ]
    exact = in_34_digits().items()
    rows += [(f"{name}, against 34 digits", f"{x:.2e}", "", "", "") for name, x in exact]
    with RESULTS.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        head = ("figure", "worst_error", "error_of_difference", "design", "number")
        writer.writerows([head, *rows])
    for row in rows:
        print(*row)


if __name__ == "__main__":
    main()
