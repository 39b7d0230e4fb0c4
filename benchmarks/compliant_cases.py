"""Random mechanisms between walls that yield: their energy, their status and their time.

    python benchmarks/compliant_cases.py ledger      500 cases: the energy balance closes
    python benchmarks/compliant_cases.py hard       1000 cases: friction from 0 to 2

A pin can press into a wall no deeper than if all energy were in the spring of the wall. A pin that
went through a wall would be deeper than that.
"""

import argparse
import csv
import math
import time
from pathlib import Path

import numpy as np

import escapement as esc

RESULTS = Path(__file__).parent / "results"
RADIUS, TORQUE = 0.01, 0.1


def escapement_of(seed: int, hard: bool) -> esc.Escapement:
    """A random escapement; lengths by the crank radius, the rest in natural units."""
    draw = np.random.default_rng([seed, hard])
    internal = bool(draw.random() < 0.3)
    slots = int(draw.choice([3, 4, 5, 6, 8]))
    follower = 10.0 ** draw.uniform(-6, -4)
    rho = 10.0 ** draw.uniform(-1.5, 0.5)
    clock, unit = math.sqrt(follower / TORQUE), TORQUE / RADIUS**2
    stiffness = 1e5 if hard else 10.0 ** draw.uniform(4.5, 6.5)
    damping = 10.0 ** draw.uniform(-1.5, 0.5) * math.sqrt(stiffness)
    clearance = 10.0 ** draw.uniform(-5, -2) if hard or draw.random() < 0.8 else 0.0
    wheel = esc.Geneva(
        slots,
        internal=internal,
        crank_radius=RADIUS,
        clearance=2.0 * clearance * RADIUS,
        pin_radius=RADIUS * draw.choice([0.0, draw.uniform(0.01, 0.1)]),
    )
    some = {
        "load_torque": 0.1 * TORQUE,
        "driver_bearing_torque": 0.2 * TORQUE,
        "driver_drag": 0.02 * follower,
        "follower_drag": 0.02 * follower,
        "driver_viscous": 0.05 * math.sqrt(follower * TORQUE),
        "follower_viscous": 0.05 * math.sqrt(follower * TORQUE),
    }
    chosen = {name: most * draw.random() for name, most in some.items() if draw.random() < 0.3}
    for body in ("driver", "follower"):
        if draw.random() < 0.3:
            chosen[f"{body}_bearing_friction"] = 0.2 * draw.random()
            chosen[f"{body}_bearing_radius"] = 0.1 * RADIUS
    law = {"damping": damping * unit * clock, "contact_law": "linear"}
    if draw.random() < 0.3:
        law = {"restitution": draw.uniform(0.05, 0.6), "contact_law": "hunt-crossley"}
    return esc.Escapement(
        wheel,
        esc.Inertia(rho * follower, follower),
        torque=TORQUE,
        friction=draw.uniform(0.0, 2.0) if hard else draw.uniform(0.0, 0.4),
        stiffness=stiffness * unit,
        slip_speed=1e-4 * RADIUS / clock,
        **law,
        **chosen,
    )


def depth_share(motion: esc.Motion) -> float:
    """Deepest penetration, divided by that with all energy in the spring of one wall."""
    rows, own = motion.trajectory.rows, motion.escapement
    table, joint = rows.table, rows.joint
    states = table["state"]
    sense, centre = own.scene.path.numbers[9], own.mechanism.centre_distance
    touching = np.abs(table["mode"]) == 1
    theta, phi = states[table["mode"] == 0, :2].T
    flying = sense * np.sin(sense * theta - phi) - centre * np.sin(phi)
    # on a wall the second coordinate is the distance from the slot's middle line
    across = np.append(np.abs(states[touching, 1]), np.abs(flying))
    depth = across.max() - joint.half_clearance
    turning = rows.at(rows.steps, table["time"][rows.steps])
    energy = 0.5 * (own.scene.rho * turning[1] ** 2 + turning[4] ** 2).max()
    energy += own.mechanism.cell_angle
    power, factor = (2.5, 0.4) if joint.hertz else (2.0, 0.5)
    most = (energy / (factor * joint.stiffness)) ** (1.0 / power)
    return float(depth / most)


def row_of(seed: int, hard: bool) -> dict[str, object]:
    """Results of a case, and the time that it took."""
    own = escapement_of(seed, hard)
    start = time.process_time()
    motion = esc.simulate(own, 6, rtol=1e-9)
    middle = time.process_time()
    figures = esc.terminal(own, rtol=1e-8) if hard else None
    end = time.process_time()
    return {
        "seed": seed,
        "slots": own.mechanism.slots,
        "internal": own.mechanism.internal,
        "friction": round(own.friction, 4),
        "law": own.contact_law,
        "status": motion.status.label,
        "residual": f"{motion.ledger.residual:.1e}",
        "depth": f"{depth_share(motion):.3f}",
        "seconds": round(middle - start, 2),
        "terminal": "" if figures is None else figures.status.label,
        "spread": "" if figures is None else figures.spread is not None,
        "terminal_seconds": round(end - middle, 2),
    }


def main() -> None:
    """Run the cases and write one row for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("part", choices=["ledger", "hard"])
    parser.add_argument("--count", type=int)
    parser.add_argument("--first", type=int, default=0)
    given = parser.parse_args()
    hard = given.part == "hard"
    count = given.count or (1000 if hard else 500)
    rows = []
    path = RESULTS / f"compliant_{given.part}.csv"
    with path.open("w", newline="") as file:
        for seed in range(given.first, given.first + count):
            rows.append(row_of(seed, hard))
            if len(rows) == 1:
                csv.DictWriter(file, list(rows[0])).writeheader()
            csv.DictWriter(file, list(rows[0])).writerow(rows[-1])
            file.flush()
    residual = max(abs(float(str(row["residual"]))) for row in rows)
    slowest = max(max(row["seconds"], row["terminal_seconds"]) for row in rows)
    print("largest residual", residual, "slowest", slowest, "s")
    print("deepest", max(float(str(row["depth"])) for row in rows))


if __name__ == "__main__":
    main()
