"""Both engines on random real mechanisms: pins with width, rollers, bearings, drags, loads.

``python benchmarks/real_cases.py [-n CASES] [--first SEED] [--drives] [-o FILE]``

Every case has a random subset of the effects, any kind of slotted wheel, with or without a dwell,
and starts from rest or fast. The tolerance of the fast engine is 1e-12, that of ``ivp`` 1e-10. A
case is wrong if a time or a speed of a handoff differs by more than ten times the latter, if
status or reversals differ, or if the energy balance of the fast engine leaves more than 1e-12 of
the work. With ``--drives`` springs, torque curves and trains with efficiencies from 0.6 to 1 are
among the effects, and the instants at which the power in a train changes its direction are
compared as well.
"""

import argparse
import csv
import sys
from collections import Counter
from pathlib import Path

import numpy as np

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.dynamics.painleve import friction_limits

EFFECTS = (
    *("pin", "roller", "driver journal", "follower journal", "bearing torque", "driver drag"),
    *("follower drag", "driver viscous", "follower viscous", "load"),
)
DRIVES = ("spring", "curve", "barrel", "load train")
ENGAGEMENTS = 4


def draw(seed, drives=False):
    """An escapement, its initial speed [rad/s] and its effects; None where none fits."""
    random = np.random.default_rng(seed)
    present = {name for name in EFFECTS if random.random() < 0.4}
    # with a random drive fewer other effects are drawn
    if drives:
        present = {name for name in EFFECTS if name in present and random.random() < 0.5}
        present |= {name for name in DRIVES if random.random() < 0.6}
    length = 10.0 ** random.uniform(-3, -1)
    try:
        wheel = draw_wheel(random, length, present)
        numbers = draw_numbers(random, wheel, present)
        if drives:
            numbers |= draw_drive(random, wheel, present, numbers)
        smooth = esc.Escapement(wheel, friction=0.0, **numbers)
    except InvalidValue:
        return None
    limit = min(friction_limits(smooth))
    if not limit > 0.0:
        return None
    friction = min(limit, 2.0) * random.choice([0.0, 0.05, 0.3, 0.7, 0.95])
    timer = esc.Escapement(wheel, friction=friction, **numbers)
    speed = random.choice([0.0, 10.0 ** random.uniform(-1, 2)]) / timer.time_unit
    return timer, float(speed), present


def draw_wheel(random, length, present):
    """A wheel of any kind, with pins or rollers that fit its slots."""
    kind = random.choice(["external", "internal", "geared"], p=[0.5, 0.25, 0.25])
    slots = int(random.integers(3, 13))

    def make(**radii):
        if kind == "geared":
            return esc.GearDriven(stations, lobes, curve, fixed_radius=length, **radii)
        return esc.Geneva(slots, pins, kind == "internal", crank_radius=length, **radii)

    pins = None
    if kind == "external" and random.random() < 0.5:
        pins = int(random.integers(1, 2 * slots // (slots - 2) + 1))
    stations, lobes = int(random.integers(4, 9)), str(random.choice(["1/2", "1", "3/2", "2", "3"]))
    curve = str(random.choice(["hypocycloid", "epicycloid"]))
    outer = length * make().widest_pin * random.uniform(0.02, 0.6)
    if "roller" in present:
        return make(pin_radius=outer * random.uniform(0.2, 0.8), roller_radius=outer)
    return make(pin_radius=outer) if "pin" in present else make()


def draw_numbers(random, wheel, present):
    """Inertias, torque and resisting torques."""
    follower, torque = 10.0 ** random.uniform(-7, -3), 10.0 ** random.uniform(-3, 1)
    unit, closest = (follower * torque) ** 0.5, wheel.crank_radius * wheel.widest_pin
    drawn = {
        "driver journal": {
            "driver_bearing_friction": random.uniform(0.02, 0.4),
            "driver_bearing_radius": wheel.crank_radius * random.uniform(0.02, 0.2),
        },
        "follower journal": {
            "follower_bearing_friction": random.uniform(0.02, 0.4),
            "follower_bearing_radius": closest * random.uniform(0.02, 0.4),
        },
        "bearing torque": {"driver_bearing_torque": torque * random.uniform(0.0, 0.4)},
        "driver drag": {"driver_drag": follower * 10.0 ** random.uniform(-4, -1)},
        "follower drag": {"follower_drag": follower * 10.0 ** random.uniform(-4, -1)},
        "driver viscous": {"driver_viscous": unit * 10.0 ** random.uniform(-4, -0.5)},
        "follower viscous": {"follower_viscous": unit * 10.0 ** random.uniform(-4, -0.5)},
        "load": {"load_torque": torque / wheel.transmission_max * random.uniform(0.0, 0.5)},
    }
    if not wheel.plain_crank:
        drawn.pop("driver journal")
    inertia = esc.Inertia(driver=follower * 10.0 ** random.uniform(-2, 1), follower=follower)
    numbers = {"inertia": inertia, "torque": torque}
    for name in sorted(present & drawn.keys()):
        numbers |= drawn[name]
    return numbers


def draw_drive(random, wheel, present, numbers):
    """Trains, and a torque that changes with the angle."""
    drawn, ratio = {}, 1.0
    share = {name: random.choice([1.0, random.uniform(0.6, 1.0)], p=[0.1, 0.9]) for name in DRIVES}
    if "barrel" in present:
        ratio = 10.0 ** random.uniform(-0.5, 1.0)
        felt = numbers["inertia"].driver * 10.0 ** random.uniform(-1, 2)
        drawn["barrel"] = esc.Train(ratio, share["barrel"], felt * ratio**2)
    if "load train" in present:
        other = 10.0 ** random.uniform(-0.5, 1.0)
        felt = numbers["inertia"].follower * 10.0 ** random.uniform(-2, 1)
        drawn["load_train"] = esc.Train(other, share["load train"], felt / other**2)
        drawn["load_torque"] = numbers.get("load_torque", 0.0) / other
    torque, turn = numbers["torque"] * ratio, wheel.cell_angle / ratio
    drawn["torque"] = torque
    if "curve" in present:
        angles = np.concatenate([[0.0], np.cumsum(random.uniform(0.2, 2.0, 4))]) * turn
        torques = torque * random.uniform(0.4, 1.0, 5)
        drawn["torque"] = esc.TorqueCurve(angles, torques)
    elif "spring" in present:
        drawn["spring_rate"] = torque / turn * 10.0 ** random.uniform(-3, -0.7)
    return drawn


def compare(timer, speed):
    """Status of the fast engine, greatest difference, residual, and a description of errors."""
    fast, slow = (
        esc.simulate(timer, ENGAGEMENTS, initial_speed=speed, engine=name)
        for name in ("energy", "ivp")
    )
    if fast.status is not slow.status or fast.handoff_times.size != slow.handoff_times.size:
        return fast.status.label, np.inf, 0.0, f"status {slow.status.label} by ivp"
    pairs = (
        (fast.handoff_times, slow.handoff_times),
        (fast.handoff_velocities, slow.handoff_velocities),
    )
    apart = max((float(np.abs(a / b - 1.0).max()) for a, b in pairs if a.size), default=0.0)
    residual = abs(fast.ledger.residual)
    wrong = [
        *(["apart"] if apart > 1e-9 else []),
        *(["ledger"] if residual > 1e-12 else []),
        *(["reversals"] if fast.reversals.time.size != slow.reversals.time.size else []),
        *(["flow"] if fast.flow_changes.time.size != slow.flow_changes.time.size else []),
        *(["slide"] if fast.slide_changes.time.size != slow.slide_changes.time.size else []),
    ]
    return fast.status.label, apart, residual, " ".join(wrong)


def main():
    """Compare, print what is wrong and a summary, and write a line a case."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-n", type=int, default=2000)
    parser.add_argument("--drives", action="store_true")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("-o", "--output", type=Path)
    given = parser.parse_args()
    rows, seed = [], given.first
    while len(rows) < given.n:
        case = draw(seed, given.drives)
        if case is not None:
            timer, speed, present = case
            status, apart, residual, wrong = compare(timer, speed)
            effects = ", ".join(name for name in (*EFFECTS, *DRIVES) if name in present)
            rows.append([seed, status, f"{apart:.2g}", f"{residual:.2g}", wrong, effects])
            if wrong:
                print(f"seed {seed}: {wrong}, {apart:.3g}, {effects}", flush=True)
        seed += 1
    bad = sum(bool(row[4]) for row in rows)
    worst = max(float(row[2]) for row in rows)
    print(
        f"{len(rows)} cases, {bad} wrong, greatest difference {worst:.2g}, greatest residual "
        f"{max(float(row[3]) for row in rows):.2g}, {dict(Counter(row[1] for row in rows))}"
    )
    if given.output is not None:
        with open(given.output, "w", newline="", encoding="utf-8") as stream:
            csv.writer(stream).writerows(
                [["seed", "status", "difference", "residual", "wrong", "effects"], *rows]
            )
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
