"""Slips of Meyer's equations and text; those that are formulas are tried on his three wheels."""

import numpy as np

from escapement.mechanisms import Geneva
from escapement.sources.report import Slip, read_slips

_SHARES = np.array([-0.93, -0.7, -0.41, -0.2])
"""Places as shares of half a cell, before dead centre, where no term of a sum is negative."""


def equations() -> list[Slip]:
    """Every slip of equations and text: relative errors of formulas for 3, 4 and 6 slots."""
    rows = []
    for slots in (3, 4, 6):
        wheel = Geneva(slots)
        theta = _SHARES * wheel.breaks[-1]
        found = wheel.transmission(theta)
        a = np.full(theta.shape, 1.0 / np.sin(np.pi / slots))
        rows.append(np.array([a, theta, found.g, found.u, found.dg]))
    a, theta, g, u, dg = np.concatenate(rows, axis=1)
    sine, x = np.sin(theta), a * np.cos(theta) - 1.0
    length, bent = 1.0 + a * a - 2.0 * a * np.cos(theta), a * sine * (1.0 - a * a)
    # driver speed and acceleration, crank radius, and both inertias are 1
    force = (g + dg) / np.sqrt(length)
    moment = bent / length**2 + x / length
    first, second = -2.0 * x * a * sine / length**2, 4.0 * a * sine / length**3
    # the formula as printed, the true one, and what both should give
    tried = {
        "force": (moment / length**1.5, moment / length**0.5, force),
        "force 1-13": (
            bent / length**1.5 + x / length**1.5, bent / length**2.5 + x / length**1.5, force
        ),
        "arm": (a * sine / length**1.5, a * sine / length**0.5, u * np.sqrt(length)),
        "kinetic": (
            first + (-a * np.cos(theta) - 1.0) ** 2 * second, first - x * x * second, 2.0 * g * dg
        ),
        "inertia": (1.0 + x / length**2, 1.0 + x * x / length**2, 1.0 + g * g),
    }  # fmt: skip
    deviations = {
        name: (printed / goal - 1.0, true / goal - 1.0)
        for name, (printed, true, goal) in tried.items()
    }
    return read_slips("meyer", deviations)
