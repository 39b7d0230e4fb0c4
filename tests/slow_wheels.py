"""Wheels nearly without losses, whose motion takes very long to repeat itself."""

from dataclasses import replace

import escapement as esc

FRICTIONS = (0.0, 1e-12, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)
DRAGS = {
    "driver_viscous": (0.3, 1e-6),
    "follower_viscous": (0.2, 1e-6),
    "driver_drag": (0.3, 5e-6),
    "follower_drag": (0.2, 5e-6),
}
"""How often there is each drag, and its unit: follower inertia, over a second or not."""


def random_wheel(rng):
    """An escapement, and the speed with which it starts [rad/s]."""
    geneva = esc.Geneva(int(rng.integers(3, 9)), internal=bool(rng.random() < 0.15))
    inertia = esc.Inertia(10.0 ** rng.uniform(-2, 1) * 5e-6, 5e-6)
    numbers = {"friction": float(rng.choice(FRICTIONS))}
    for name, (often, unit) in DRAGS.items():
        if rng.random() < often:
            numbers[name] = float(unit * 10.0 ** rng.uniform(-9, -2))
    if rng.random() < 0.3:
        numbers["load_torque"] = float(0.01 * rng.uniform(0.0, 0.3))
    start = float(rng.choice([0.0, 0.0, 0.0, 1e3, 1e5]))
    return esc.Escapement(geneva, inertia, torque=0.0113, **numbers), start


EFFICIENCIES = (0.7, 0.9, 0.99, 0.9999, 1.0 - 1e-7)


def with_lossy_trains(rng):
    """As `random_wheel`, with one or two trains that lose power, often with an inertia behind."""
    escapement, start = random_wheel(rng)
    some = rng.random(2) < (0.7, 0.5)

    def train(ratio, least):
        inertia = float(rng.choice([0.0, 10.0 ** rng.uniform(least, least + 3.0)]))
        return esc.Train(ratio, float(rng.choice(EFFICIENCIES)), inertia)

    trains = {"barrel": train(10.0, -7.0)} if some[0] else {}
    if some[1] or not trains:
        trains["load_train"] = train(float(rng.uniform(0.5, 2.0)), -8.0)
    return replace(escapement, **trains), start


def with_uneven_parts(rng):
    """As `random_wheel`, with one or two pins and with errors of pins and slots."""
    escapement, start = random_wheel(rng)
    wheel = escapement.mechanism
    pins, size = 1 if wheel.internal else int(rng.integers(1, 3)), 10.0 ** rng.uniform(-6, 0)
    uneven = replace(
        wheel, pins=pins, crank_radius=0.01,
        slot_offsets=tuple(rng.uniform(-1e-5, 1e-5, wheel.slots) * size),
        pin_angle_errors=tuple(rng.uniform(-1e-3, 1e-3, pins) * size),
    )  # fmt: skip
    return replace(escapement, mechanism=uneven), start
