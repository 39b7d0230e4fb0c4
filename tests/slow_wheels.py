"""Wheels nearly without losses, whose motion takes very long to repeat itself."""

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
