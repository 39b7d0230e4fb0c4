"""Drives that are measured, and readings that contain only known errors."""

import math

import numpy as np

import escapement as esc

DEG = math.pi / 180.0
PRIKHODKO = esc.EllipticalPlanetary(0.016, 0.009)


ROWS = np.linspace(0.0, 1.0, 41)
DRIVES = {
    "planetary": PRIKHODKO,
    **{str(slots): esc.Geneva(slots) for slots in (3, 4, 5)},
    "4 with dwell": esc.Geneva(4, pins=1),
    "internal": esc.Geneva(6, internal=True),
    "gear-driven": esc.GearDriven(4, 2, curve="epicycloid"),
    "table": esc.Tabulated(2.0 * ROWS, ROWS + 0.1 * np.sin(2.0 * np.pi * ROWS)),
}


def read(mechanism=PRIKHODKO, **planted):
    """Readings that hold nothing but what is planted."""
    return esc.synthetic_readings(mechanism, **({"seed": 1, "samples": 600, "turns": 5} | planted))


def shown(result, shaft):
    (found,) = [e for e in result.shaft_errors if (e.shaft, e.order) == (shaft, 1)]
    return found
