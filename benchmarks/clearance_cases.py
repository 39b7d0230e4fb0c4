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
import time
from collections import Counter

import numpy as np
from common import random_journals, random_losses, write_rows

import escapement as esc
from escapement.dynamics.painleve import friction_limits

RADIUS, FOLLOWER, TORQUE = 0.01, 5e-6, 0.01


def case(seed, trains=False):
    """A random escapement, if wanted with trains that lose power."""
    random = np.random.default_rng(seed)
    internal, slots = bool(random.random() < 0.25), int(random.integers(3, 13))
    model = {"restitution": random.uniform(0.0, 0.6)}
    model |= random_losses(random, 0.3, TORQUE, FOLLOWER)
    model |= random_journals(random, 0.3, 0.05 * RADIUS)
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
        rows.append({
            "seed": seed, "friction": f"{own.friction:.4f}",
            "restitution": f"{own.restitution:.3f}",
            "motion": motion.status.label, "terminal": figures.status.label,
            "motion_seconds": f"{middle - begin:.4f}", "terminal_seconds": f"{end - middle:.4f}",
            "states_seconds": f"{time.process_time() - end:.4f}", "beyond_wall": f"{deep:.1e}",
            "residual": f"{motion.ledger.residual:.1e}",
        })  # fmt: skip
    write_rows("clearance_cases_trains" if asked.trains else "clearance_cases", rows)
    print(Counter(row["motion"] for row in rows), Counter(row["terminal"] for row in rows))
    for name in ("motion_seconds", "terminal_seconds", "states_seconds", "beyond_wall", "residual"):
        print(f"greatest {name}: {max(abs(float(row[name])) for row in rows):.1e}")


if __name__ == "__main__":
    main()
