"""Random mechanisms between walls that yield: their status, their energy, their time.

    python benchmarks/compliant_cases.py [CASES]

Friction is up to 2, the stiffness 1e5 torque over the square of the crank radius, and the play
from 1e-5 to 1e-2 crank radii. A pin can press into a wall no deeper than if all energy were in the
spring of the wall. A pin that went through a wall would be deeper than that.
"""

import math
import sys
import time

import numpy as np
from common import random_journals, random_losses, write_rows

import escapement as esc

RADIUS, TORQUE, STIFFNESS = 0.01, 0.1, 1e5


def escapement_of(seed):
    """A random escapement; lengths by the crank radius, the rest in natural units."""
    draw = np.random.default_rng([seed, True])
    internal = bool(draw.random() < 0.3)
    slots = int(draw.choice([3, 4, 5, 6, 8]))
    follower = 10.0 ** draw.uniform(-6, -4)
    inertia = esc.Inertia(10.0 ** draw.uniform(-1.5, 0.5) * follower, follower)
    clock, unit = math.sqrt(follower / TORQUE), TORQUE / RADIUS**2
    damping = 10.0 ** draw.uniform(-1.5, 0.5) * math.sqrt(STIFFNESS)
    wheel = esc.Geneva(
        slots, internal=internal, crank_radius=RADIUS,
        clearance=2.0 * 10.0 ** draw.uniform(-5, -2) * RADIUS,
        pin_radius=RADIUS * draw.choice([0.0, draw.uniform(0.01, 0.1)]),
    )  # fmt: skip
    model = random_losses(draw, 0.3, TORQUE, follower, bearing=0.2, viscous=0.05)
    model |= random_journals(draw, 0.3, 0.1 * RADIUS)
    law = {"damping": damping * unit * clock, "contact_law": "linear"}
    if draw.random() < 0.3:
        law = {"restitution": draw.uniform(0.05, 0.6), "contact_law": "hunt-crossley"}
    walls = law | {"stiffness": STIFFNESS * unit, "slip_speed": 1e-4 * RADIUS / clock}
    return esc.Escapement(wheel, inertia, TORQUE, draw.uniform(0.0, 2.0), **model, **walls)


def depth_share(motion):
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


def row_of(seed):
    """Results of a case, and the time that it took."""
    own = escapement_of(seed)
    start = time.process_time()
    motion = esc.simulate(own, 6, rtol=1e-9)
    middle = time.process_time()
    figures = esc.terminal(own, rtol=1e-8)
    return {
        "seed": seed, "slots": own.mechanism.slots, "internal": own.mechanism.internal,
        "friction": round(own.friction, 4), "law": own.contact_law, "status": motion.status.label,
        "residual": f"{motion.ledger.residual:.1e}", "depth": f"{depth_share(motion):.3f}",
        "seconds": round(middle - start, 2), "terminal": figures.status.label,
        "spread": figures.spread is not None,
        "terminal_seconds": round(time.process_time() - middle, 2),
    }  # fmt: skip


def main(cases=1000):
    """Run the cases, write a row for each, print the greatest numbers."""
    rows = [row_of(seed) for seed in range(cases)]
    write_rows("compliant_hard", rows)
    for name in ("residual", "depth", "seconds", "terminal_seconds"):
        print(f"greatest {name}: {max(abs(float(row[name])) for row in rows):.2g}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
