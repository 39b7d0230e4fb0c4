"""Drives that are measured, and readings with nothing in them but what is planted."""

import math

import numpy as np

import escapement as esc

DEG = math.pi / 180.0
PRIKHODKO = esc.EllipticalPlanetary(0.016, 0.009)


DRIVES = [
    PRIKHODKO,
    esc.Geneva(3),
    esc.Geneva(4),
    esc.Geneva(4, pins=1),
    esc.Geneva(5),
    esc.Geneva(6, internal=True),
    esc.GearDriven(4, 2, curve="epicycloid"),
    esc.Tabulated(
        np.linspace(0.0, 2.0, 41),
        np.linspace(0.0, 1.0, 41) + 0.1 * np.sin(np.pi * np.arange(41) / 20),
    ),
]
NAMES = ["planetary", "3", "4", "4 with dwell", "5", "internal", "gear-driven", "table"]


def read(mechanism=PRIKHODKO, **planted):
    """Readings that hold nothing but what is planted."""
    return esc.synthetic_readings(mechanism, **({"seed": 1, "samples": 600, "turns": 5} | planted))


def shown(result, shaft):
    (found,) = [e for e in result.shaft_errors if (e.shaft, e.order) == (shaft, 1)]
    return found
