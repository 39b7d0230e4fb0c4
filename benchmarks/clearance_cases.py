"""Random mechanisms with clearance and rigid impact: status, time, walls and energy balance.

``python benchmarks/clearance_cases.py [CASES] [--trains]`` draws plays of 1e-5 to 1e-2 crank radii
on either side, restitutions from 0 to 0.6 and frictions up to 2 below the Painleve limit, with
loads, bearings and drags. It simulates twenty engagements of each, looks for the terminal cycle,
asks for 4001 states, and writes a row for each to ``results/clearance_cases.csv``: the processor
time of the three, how far the pin went beyond a wall, in crank radii, and the share of the work
that the energy balance leaves unaccounted for. With ``--trains`` each mechanism has a barrel and a
load behind trains that lose up to half of the power; the rows go to
``results/clearance_cases_trains.csv``.
"""

import argparse
import csv
import time
from collections import Counter
from pathlib import Path

import numpy as np

import escapement as esc
from escapement.dynamics.painleve import friction_limits

RESULTS = Path(__file__).resolve().parent / "results"
RADIUS, FOLLOWER, TORQUE = 0.01, 5e-6, 0.01


def case(seed, trains=False):
    """A random escapement, if wanted with trains that lose power."""
    random = np.random.default_rng(seed)
    internal, slots = bool(random.random() < 0.25), int(random.integers(3, 13))
    clock = (FOLLOWER / TORQUE) ** 0.5
    model = {"restitution": random.uniform(0.0, 0.6)}
    for name, most in {
        "load_torque": 0.1 * TORQUE, "driver_bearing_torque": 0.1 * TORQUE,
        "driver_drag": 0.02 * FOLLOWER, "follower_drag": 0.02 * FOLLOWER,
        "driver_viscous": 0.02 * FOLLOWER / clock, "follower_viscous": 0.02 * FOLLOWER / clock,
    }.items():  # fmt: skip
        if random.random() < 0.3:
            model[name] = most * random.random()
    for body in ("driver", "follower"):
        if random.random() < 0.3:
            model[f"{body}_bearing_friction"] = 0.2 * random.random()
            model[f"{body}_bearing_radius"] = 0.05 * RADIUS
    wheel = esc.Geneva(
        slots, 1 if internal else None, internal, RADIUS,
        pin_radius=RADIUS * random.choice([0.0, random.uniform(0.01, 0.08)]),
        clearance=2.0 * RADIUS * 10.0 ** random.uniform(-5.0, -2.0),
    )  # fmt: skip
    inertia = esc.Inertia(FOLLOWER * 10.0 ** random.uniform(-1.5, 0.5), FOLLOWER)
    share, torque = random.random(), TORQUE
    if trains:
        first, second = random.uniform(2.0, 8.0), random.uniform(1.5, 6.0)
        barrel = FOLLOWER * first**2 * 10.0 ** random.uniform(-1.5, 0.5)
        last = FOLLOWER / second**2 * 10.0 ** random.uniform(-2.0, 0.0)
        model["barrel"] = esc.Train(first, random.uniform(0.5, 1.0), barrel)
        model["load_train"] = esc.Train(second, random.uniform(0.5, 1.0), last)
        model["load_torque"] = model.get("load_torque", 0.0) / second
        torque *= first
    limit = friction_limits(esc.Escapement(wheel, inertia, torque, **model))[0]
    return esc.Escapement(wheel, inertia, torque, share * min(limit, 2.0), **model)


def beyond(motion):
    """How far the pin's centre lies beyond the walls, in crank radii; negative within."""
    own, wheel = motion.escapement, motion.escapement.mechanism
    state = motion.at(np.linspace(0.0, motion.end_time, 4001))
    cell = wheel.cell_angle
    start = -0.5 * cell if wheel.pins > 1 else float(wheel.breaks[0])
    number = np.floor((state.theta - start) / cell + 1e-12)
    angle, turned = state.theta - number * cell, state.phi - number * wheel.follower_step
    inside = (angle >= wheel.breaks[0]) & (angle <= wheel.breaks[-1])
    centre = wheel.centre_distance
    pin = centre + np.exp(1j * angle) if wheel.internal else centre - np.exp(-1j * angle)
    across = (pin * np.exp(-1j * turned)).imag
    play = 0.5 * wheel.clearance / wheel.crank_radius
    assert own.contact == "rigid"
    return float((np.abs(across) - play)[inside].max(initial=-play))


def main():
    """Run the cases, write a row for each, print a summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="?", type=int, default=1000)
    parser.add_argument("--trains", action="store_true")
    asked = parser.parse_args()
    esc.terminal(case(0))
    rows = []
    for seed in range(asked.cases):
        own = case(seed, asked.trains)
        begin = time.process_time()
        motion = esc.simulate(own, 20)
        middle = time.process_time()
        figures = esc.terminal(own)
        end = time.process_time()
        deep = beyond(motion) if motion.end_time > 0.0 else 0.0
        states = time.process_time() - end
        rows.append((
            seed, f"{own.friction:.4f}", f"{own.restitution:.3f}", motion.status.label,
            figures.status.label, f"{middle - begin:.4f}", f"{end - middle:.4f}", f"{states:.4f}",
            f"{deep:.1e}", f"{motion.ledger.residual:.1e}",
        ))  # fmt: skip
    header = ("seed", "friction", "restitution", "motion", "terminal", "motion_seconds",
              "terminal_seconds", "states_seconds", "beyond_wall", "residual")  # fmt: skip
    name = "clearance_cases_trains.csv" if asked.trains else "clearance_cases.csv"
    with (RESULTS / name).open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([header, *rows])
    print(Counter(row[3] for row in rows), Counter(row[4] for row in rows))
    for place, name in ((5, "motion"), (6, "terminal"), (7, "states")):
        print(f"slowest {name}: {max(float(row[place]) for row in rows):.3f} s")
    print(f"farthest beyond a wall: {max(float(row[8]) for row in rows):.1e} crank radii")
    print(f"greatest residual: {max(abs(float(row[9])) for row in rows):.1e}")


if __name__ == "__main__":
    main()
