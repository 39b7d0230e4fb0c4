"""Derivatives of figures of merit in 34-digit arithmetic, for the tests.

``python tests/reference/derivatives.py [DESIGNS]`` draws designs at random, 159 by default, each
with one of its numbers, and writes the derivatives of their figures by it to ``derivatives.json``.
That takes half an hour. They are central differences of figures that ``taylor.py`` computes: with a
step of 1e-8 of the number the error of the differences is some 1e-15 of the figure over the number.

Units are those of ``generate.py``.
"""

import json
import sys
from pathlib import Path
from random import Random

from generate import COARSE, printable
from mpmath import mp, mpf
from taylor import solve

import escapement as esc
from escapement.base.status import Status

DERIVATIVES = Path(__file__).with_name("derivatives.json")
FIGURES = ("period", "velocity_max", "velocity_min", "handoff_velocity", "contraction")
STEP = mpf("1e-8")


def escapement(design):
    """The escapement of a design."""
    wheel = esc.Geneva(design["slots"], pins=design["pins"], internal=design["internal"])
    inertia = esc.Inertia(float(design["driver_inertia"]), float(design["follower_inertia"]))
    names = ("torque", "friction", "load_torque")
    return esc.Escapement(wheel, inertia, **{name: float(design[name]) for name in names})


def designs(count):
    """Random designs with a terminal cycle, each with the number that varies."""
    random = Random(1973)
    while count:
        slots, internal = random.randint(3, 8), random.random() < 0.25
        most = 1 if internal else 2 * slots // (slots - 2)
        wheel = esc.Geneva(slots, pins=random.randint(1, most), internal=internal)
        inertia = esc.Inertia(10.0 ** random.uniform(-1.5, 0.5), 1.0)
        # every fifth design is close to its Painleve limit
        share = random.uniform(0.8, 0.97) if random.random() < 0.2 else random.uniform(0.1, 0.8)
        friction = share * min(esc.critical_friction(wheel, inertia), 2.0)
        load = random.uniform(0.01, 0.1) if random.random() < 0.3 else 0.0
        design = {
            "slots": slots, "pins": wheel.pins, "internal": internal, "friction": friction,
            "driver_inertia": inertia.driver, "follower_inertia": 1.0, "torque": 1.0,
            "load_torque": load,
        }  # fmt: skip
        if esc.terminal(escapement(design)).status is not Status.OK:
            continue
        numbers = ["friction", "driver_inertia", "follower_inertia"]
        numbers += ["torque", "load_torque"] if load else []
        yield design | {"number": random.choice(numbers)}
        count -= 1


def figures(design, value):
    """The figures of a design with another value of its number, and its last reversal."""
    data = design | {design["number"]: value, "engagements": 1}
    # the search for the cycle begins close to it
    start = esc.terminal(escapement(data)).handoff_velocity
    found = solve(data | {"initial_speed": start}, COARSE)["terminal"]
    numbers = {name: found[name] for name in FIGURES}
    reversals = found["reversal_angles"]
    return numbers | ({"last_reversal_angle": max(reversals)} if reversals else {})


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 159
    lines = []
    for design in designs(count):
        with mp.workdps(COARSE["digits"]):
            middle = mpf(design[design["number"]])
            low, high = (figures(design, middle * (1 + k * STEP)) for k in (-1, 1))
            slopes = {name: (high[name] - low[name]) / (2 * STEP * middle) for name in low}
            lines.append(json.dumps(design | {"derivatives": printable(slopes)}))
        print(len(lines), file=sys.stderr)
        DERIVATIVES.write_text("[\n" + ",\n".join(lines) + "\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main()
