"""Random timers of perfect parts, and errors of the parts that nobody could make or measure."""

from dataclasses import replace

import numpy as np

import escapement as esc
from escapement.dynamics.painleve import friction_limits


def random_timer(seed):
    """A timer with a wheel of any number of slots and pins, and the speed with which it starts."""
    rng = np.random.default_rng([seed, 77])
    slots = int(rng.integers(3, 11))
    pins = int(rng.integers(1, (esc.Geneva(slots).pins or 1) + 1))
    pin = float(rng.choice([0.0, 5e-4, rng.uniform(0, 1e-3)]))
    wheel = esc.Geneva(slots, pins, crank_radius=0.01, pin_radius=pin)
    inertia, losses = esc.Inertia(5e-6 * 10 ** rng.uniform(-1.5, 0.7), 5e-6), {}
    if rng.random() < 0.3:
        losses["load_torque"] = 0.0113 * rng.uniform(0, 0.15)
    if rng.random() < 0.2:
        losses["driver_drag"] = 5e-6 * 10 ** rng.uniform(-4, -1.5)
    if rng.random() < 0.2:
        losses["follower_viscous"] = 10 ** rng.uniform(-8, -6)
    timer = esc.Escapement(wheel, inertia, torque=0.0113, friction=0.1, **losses)
    most = min(0.9 * friction_limits(timer)[0], 0.6)
    timer = replace(timer, friction=float(rng.uniform(0.05, most)))
    return timer, float(rng.choice([0, 0, 0, rng.uniform(0, 600)])), rng


def slight_errors(wheel, rng):
    """Eight sets of errors of 1e-15 m or 1e-13 rad, each of one part."""

    def one(count, size):
        errors = np.zeros(count)
        errors[rng.integers(count)] = size
        return tuple(errors.tolist())

    return [
        *({"centre_distance_error": sign * 1e-15} for sign in (1.0, -1.0)),
        *({"slot_offsets": one(wheel.slots, sign * 1e-15)} for sign in (1.0, -1.0)),
        *({"slot_angle_errors": one(wheel.slots, sign * 1e-13)} for sign in (1.0, -1.0)),
        {"crank_radius_errors": one(wheel.pins, 1e-15)},
        {"pin_angle_errors": one(wheel.pins, 1e-13)},
    ]
