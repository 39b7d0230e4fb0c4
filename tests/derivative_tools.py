"""Judges of derivatives: 34 digits, and other units of mass, length and time."""

import json
from pathlib import Path

import numpy as np

import escapement as esc
from escapement.model.numbers import with_number
from escapement.study.plan import unit_kind
from escapement.tolerance.derivatives import slopes_of

REFERENCE = Path(__file__).parent / "reference" / "derivatives.json"
"""Designs with derivatives that `reference/derivatives.py` computed."""
SI = {
    "torque": (1, 2, -2), "inertia": (1, 2, 0), "drag": (1, 2, 0), "viscous": (1, 2, -1),
    "length": (0, 1, 0), "time": (0, 0, 1), "speed": (0, 0, -1), "acceleration": (0, 0, -2),
    "force": (1, 1, -2), "energy": (1, 2, -2), "power": (1, 2, -3), "frequency": (0, 0, -1),
    "pressure": (1, -1, -2), "pressure_speed": (1, 0, -3),
}  # fmt: skip
"""Powers of mass, length and time of a unit; an angle and a ratio have none."""


def worst_against_34_digits():
    """The greatest error of each figure, the design and its number; doubts are checked.

    An error is a share of the derivative, or of the figure over the number if that is more.
    """
    worst = {}
    for case, design in enumerate(json.loads(REFERENCE.read_text(encoding="utf-8"))):
        wheel = esc.Geneva(design["slots"], pins=design["pins"], internal=design["internal"])
        inertia = esc.Inertia(design["driver_inertia"], design["follower_inertia"])
        others = {name: design[name] for name in ("torque", "friction", "load_torque")}
        timer, number = esc.Escapement(wheel, inertia, **others), design["number"]
        figures, exact = esc.terminal(timer), design["derivatives"]

        def solve(name, value, timer=timer):
            return esc.terminal(with_number(timer, name, value))

        slopes = slopes_of(solve, timer, figures, {number: design[number]}, [*exact])[number]
        for figure, text in exact.items():
            slope = slopes[figure]
            scale = max(abs(float(text)), abs(getattr(figures, figure) / design[number]))
            error = abs(slope.below - float(text)) / scale
            assert slope.below == slope.above
            assert error <= slope.doubt / scale + 1e-9
            worst[figure] = max(worst.get(figure, (0.0,)), (error, case, number))
    return worst


def errors_of_powers(found):
    """By figure, what Euler's relation misses for mass, length and time, and the shares' powers.

    A unit of another size changes no motion, so that the relative derivatives of a figure, each
    times the power of the unit in its number, add up to the power in the figure.
    """
    for figure, shares in found.relative.items():
        if shares:
            powers = np.array([SI.get(unit_kind(name), (0, 0, 0)) for name in shares])
            sums = np.array([*shares.values()]) @ powers
            yield figure, np.abs(sums - SI.get(unit_kind(figure), (0, 0, 0))), powers
