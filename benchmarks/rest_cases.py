"""Random mechanisms that come to rest: springs that run down, and drives that drive nothing.

    python benchmarks/rest_cases.py spent       500 springs and curves that end, with clearance
    python benchmarks/rest_cases.py mixed       500 of both kinds, with all contacts and engines

A drive that drives nothing has a constant torque of the bearing that equals its torque or exceeds
it. Frictions are up to 0.95 of the Painleve limit, plays from 1e-6 to 1e-2 crank radii; there are
restitutions, journals, bearings, loads and both kinds of drag. The status is judged by statics, not
by the engine: a motion that has stopped is SPENT where the curve gives no torque any more, and else
STALL; then the torque that is left must not exceed what bearing, load and friction hold. Both
bodies must have no more energy than those that count as at rest, or the driver turns back where the
pin leaves the slot. Of springs with a play below 1e-5 and no rebound, the engine without clearance
must give the same status and the same number of handoffs, but for one. A row has the processor time
without compilation. The energy balance has to close within 1e-10, with compliant walls 1e-6, and
without clearance 1e-8: there a stop is placed to 1e-12 rad, and a motion may stop within 1e-4 rad.
"""

import argparse
import time
from collections import Counter
from dataclasses import replace

import numpy as np
from common import random_journals, random_losses, write_rows

import escapement as esc
from escapement.base.status import Status
from escapement.dynamics.painleve import friction_limits

RADIUS, FOLLOWER, TORQUE = 0.01, 5e-6, 0.01
CLOCK = (FOLLOWER / TORQUE) ** 0.5
ENGAGEMENTS, REST = 400, 1e-6


def case(seed, undriven, contact):
    """A random escapement and its initial speed [rad/s]."""
    random = np.random.default_rng([seed, undriven, len(contact)])
    internal, slots = bool(random.random() < 0.25), int(random.integers(3, 9))
    pins = 1 if internal or random.random() < 0.3 else None
    play = 0.0 if contact == "none" else 10.0 ** random.uniform(-6.0, -2.0)
    wheel = esc.Geneva(
        slots, pins, internal, RADIUS,
        pin_radius=RADIUS * random.choice([0.0, random.uniform(0.01, 0.08)]),
        clearance=2.0 * RADIUS * play,
    )  # fmt: skip
    model = random_losses(random, 0.33, TORQUE, FOLLOWER)
    model |= random_journals(random, 0.33, 0.05 * RADIUS)
    if contact == "rigid" and random.random() < 0.5:
        model["restitution"] = random.uniform(0.0, 0.6)
    if contact == "compliant":
        model["stiffness"] = 10.0 ** random.uniform(5.0, 6.0) * TORQUE / RADIUS**2
    model |= drive(random, undriven, wheel.cell_angle)
    inertia = esc.Inertia(FOLLOWER * 10.0 ** random.uniform(-1.5, 0.5), FOLLOWER)
    smooth = esc.Escapement(wheel, inertia, **model)
    friction = random.uniform(0.02, 0.95) * min(friction_limits(smooth)[0], 1.2)
    speed = random.choice([0.0, random.uniform(0.0, 2.0)]) / CLOCK
    return replace(smooth, friction=friction), float(speed)


def drive(random, undriven, cell):
    """Numbers of a torque that ends, or of one that the bearing holds."""
    if undriven:
        held = TORQUE * random.choice([1.0, random.uniform(1.0, 1.5)])
        found = {"torque": TORQUE, "driver_bearing_torque": held}
        if random.random() < 0.3:
            found["spring_rate"] = TORQUE / cell * random.uniform(0.01, 0.5)
        elif random.random() < 0.3:
            torques = TORQUE * random.uniform(0.2, 1.0, 4)
            angles = cell * np.append(0.0, np.cumsum(random.uniform(0.2, 2.0, 3)))
            found["torque"] = esc.TorqueCurve(angles, torques)
        return found
    turned = cell * random.uniform(0.3, 25.0)
    if random.random() < 0.25:
        # spent at a dead centre
        turned = cell * (int(random.integers(0, 20)) + 0.5)
    if random.random() < 0.5:
        return {"torque": TORQUE, "spring_rate": TORQUE / turned}
    middle = turned * random.uniform(0.2, 0.9)
    curve = esc.TorqueCurve((0.0, middle, turned), (TORQUE, random.uniform(0.2, 1.0) * TORQUE, 0.0))
    return {"torque": curve}


def faults(own, motion):
    """What is wrong with how a motion ends; "" if nothing."""
    state, unit = motion.at(motion.end_time), own.torque_unit
    kinetic = own.inertia.driver * state.theta_dot**2 + own.inertia.follower * state.phi_dot**2
    # with compliant walls it is the driver's speed that counts, and the follower may be faster
    more = own.inertia.follower * own.mechanism.transmission_max**2
    most = own.inertia.driver + (more if own.contact == "compliant" else 0.0)
    resting = kinetic <= 1.001 * REST * most / CLOCK**2
    turned = float(state.theta - motion.at(0.0).theta)
    torque = unit if own.curve is None else float(own.curve(turned + 1e-9))
    left = torque - own.driver_bearing_torque
    back = state.theta_dot < 0.0
    if motion.status is Status.OK:
        return "" if not resting and motion.handoff_times.size == ENGAGEMENTS else "goes on at rest"
    if motion.status is Status.NOT_CONVERGED:
        return "" if back and left > 0.0 and "back out" in motion.message else "gives up"
    if not (resting or back):
        return "stops in motion"
    if motion.status is not (Status.SPENT if torque <= 1e-12 * unit else Status.STALL):
        return "wrong status"
    held = left <= 1e-12 * unit or own.load_torque > 0.0
    return "" if held else "stops although it is driven"


def beside(own, motion, speed):
    """Difference from the motion without clearance, where both must agree; "" if none."""
    wheel = own.mechanism
    if own.contact != "rigid" or wheel.clearance > 2e-5 * RADIUS or own.restitution > 0.0:
        return ""
    plain = replace(own, mechanism=replace(wheel, clearance=0.0))
    ideal = esc.simulate(plain, ENGAGEMENTS, initial_speed=speed)
    apart = ideal.handoff_times.size - motion.handoff_times.size
    return (
        "" if ideal.status is motion.status and abs(apart) <= 1 else f"{ideal.status.label} {apart}"
    )


def row_of(seed, undriven, contact):
    """Results of a case, and the time that it took."""
    own, speed = case(seed, undriven, contact)
    begin = time.process_time()
    motion = esc.simulate(own, ENGAGEMENTS, initial_speed=speed)
    seconds = time.process_time() - begin
    residual = motion.ledger.residual if motion.end_time > 0.0 else 0.0
    wrong = [faults(own, motion), "" if undriven else beside(own, motion, speed)]
    if not abs(residual) < {"compliant": 1e-6, "rigid": 1e-10, "none": 1e-8}[contact]:
        wrong.append("energy")
    return {
        "seed": seed,
        "kind": "undriven" if undriven else "spent",
        "contact": contact,
        "status": motion.status.label,
        "handoffs": motion.handoff_times.size,
        "seconds": f"{seconds:.3f}",
        "residual": f"{residual:.1e}",
        "wrong": "; ".join(filter(None, wrong)),
    }


def kinds(part, seed):
    """Whether a case has no drive, and its contact."""
    if part == "spent":
        return False, "rigid"
    return seed % 2 == 1, ("rigid", "compliant", "rigid", "none")[seed // 2 % 4]


def main():
    """Run the cases, write a row for each, print a summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=["spent", "mixed"])
    parser.add_argument("-n", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    for seed in range(8):
        # compiles what the cases need
        row_of(seed, *kinds(asked.part, seed))
    rows = []
    for seed in range(asked.first, asked.first + asked.n):
        rows.append(row_of(seed, *kinds(asked.part, seed)))
        if rows[-1]["wrong"]:
            print(rows[-1], flush=True)
    write_rows(f"rest_{asked.part}", rows)
    print(Counter((row["kind"], row["contact"], row["status"]) for row in rows))
    print("wrong:", sum(bool(row["wrong"]) for row in rows))
    print(f"slowest: {max(float(row['seconds']) for row in rows):.2f} s")


if __name__ == "__main__":
    main()
