"""Random timers with thick pins and with friction in their journals."""

import math

import escapement as esc

CRANK = 0.02


def nearest_of(slots, internal):
    """Distance of the axes, sense of the crank, and least distance of a pin from the follower."""
    distance, sign = 1.0 / math.sin(math.pi / slots), 1.0 if internal else -1.0
    return distance, sign, min(distance + sign, math.sqrt(distance**2 - 1.0))


def random_timer(rng):
    """With pins up to where neighbouring slots meet, and drivers light and heavy."""
    slots, internal = int(rng.integers(3, 13)), bool(rng.random() < 0.25)
    numbers = {}
    for body in ("driver", "follower"):
        if rng.random() < 0.25:
            numbers[f"{body}_bearing_friction"] = rng.uniform(0.0, 0.3)
            numbers[f"{body}_bearing_radius"] = CRANK * rng.uniform(0.0, 0.2)
    widest = nearest_of(slots, internal)[2] * math.sin(math.pi / slots)
    pin = CRANK * rng.uniform(0.05, 0.98) * widest
    wheel = esc.Geneva(slots, 1, internal=internal, crank_radius=CRANK, pin_radius=pin)
    inertia = esc.Inertia(5e-6 * 10.0 ** rng.uniform(-3, 1.5), 5e-6)
    return esc.Escapement(wheel, inertia, torque=0.01, **numbers)
