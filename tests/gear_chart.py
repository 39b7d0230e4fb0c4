"""Gear-driven wheels of many numbers of stations and lobes, and their path by definition."""

from fractions import Fraction
from functools import cache
from itertools import product

import numpy as np

from escapement import GearDriven
from escapement.mechanisms.gear_equation import CURVES

SOURCES = CURVES[:2]
STATIONS = range(3, 25)
LOBES = sorted({Fraction(a, b) for b in (1, 2, 3) for a in range(30 * b)})


@cache
def chart():
    """Every mechanism with V0 < 1 of these numbers; the whole chart has over 2000."""
    return [
        GearDriven(n, m, curve)
        for curve, n, m in product(SOURCES, STATIONS, LOBES)
        if curve == "epicycloid" or 2 * (m + 2) < n
    ]


def position(k, carrier, arm, theta):
    """Pin path from its definition, and its derivatives by the driver angle."""
    first, second = carrier * np.exp(1j * theta), arm * np.exp(-1j * (k - 1.0) * theta)
    rate = -1j * (k - 1.0)
    return first + second, 1j * first + rate * second, -first + rate**2 * second
