"""What Filemon's equations must read: every slip, with the size of the error it makes.

Each slip that is a formula is evaluated as printed and as corrected, and held against what
both should give, from the pin's path: so a correction proves itself. Some slips may be
those of the scan.
"""

import numpy as np

from escapement.constant_speed import geneva, reversal_study
from escapement.constant_speed.study import derivatives_at
from escapement.mechanisms import Geneva
from escapement.model import FloatArray
from escapement.sources.printed import Slip, read_slips

SLOTS = tuple(range(3, 11))
_SHARES = np.array([-0.93, -0.7, -0.41, -0.2, 0.13, 0.35, 0.62, 0.88])  # places as shares of beta_0


def equations() -> list[Slip]:
    """Every slip of the equations, each tried out: relative errors for 3 to 10 slots."""
    n = np.repeat(SLOTS, _SHARES.size)
    c, half = geneva.crank_ratio(n), geneva.engagement_half(n)
    # the places keep clear of dead centre, where some of the functions are zero
    b = np.tile(_SHARES, len(SLOTS)) * half
    g, dg, ddg, _ = np.array(
        [derivatives_at(Geneva(int(k), pins=1).path, at) for k, at in zip(n, b, strict=True)]
    ).T
    length = 1.0 + c * c - 2.0 * c * np.cos(b)
    ratio, swing = c * (np.cos(b) - c) / length, c * (1.0 - c * c)
    # the acceleration function, from which (7) and the slope of the torque follow
    rate = -swing * np.sin(b) / length**2
    x = np.cos(b)
    jerks = (
        -swing * (2.0 * c * x**2 + (1.0 + sign * c * c) * x - 4.0 * c) / length**3
        for sign in (-1.0, 1.0)
    )
    top = 2.0 * c * x**3 + 2.0 * (1.0 - c * c) * x**2 - (5.0 * c + c**3) * x + 5.0 * c * c - 1.0
    # the second term of dM_2/d beta at F = 1, M_e = eta = 1, without its denominator
    term = c * swing * top
    # the formula as printed, as corrected, and the truth
    tried = {
        "acceleration": (ratio**2 * rate, rate, dg),
        "jerk": (*jerks, ddg),
        "reversal ratio": (
            length**2 / (c * (1.0 - c * c * np.sin(b))), length**2 / (swing * np.sin(b)), -1.0 / dg
        ),
        "steepest": (_cosine(c, -1.0), _cosine(c, 1.0), np.cos(geneva.acceleration_max_angle(n))),
        "limit F23": (-1.0 / np.tan(np.arcsin(c)), 1.0 / np.tan(np.arcsin(c)), np.tan(half)),
        "torque slope": (
            rate - term / length**3, rate - term / length**4, dg + dg**2 + g * ddg
        ),
        "cubic": (_cubic(n, 0.0, -1.0, 0.333, 0.074), _cubic(n, 1 / 3, 1.0, 1 / 3, 2 / 27), 1.0),
    }  # fmt: skip
    deviations = {
        name: (printed / truth - 1.0, corrected / truth - 1.0)
        for name, (printed, corrected, truth) in tried.items()
    }
    return read_slips("filemon", deviations)


def _cosine(c: FloatArray, sign: float) -> FloatArray:
    """cos(beta) where the acceleration is greatest."""
    k = (1.0 + sign * c * c) / (4.0 * c)
    return -k + np.sqrt(k * k + 2.0)


def _cubic(n: FloatArray, shift: float, sign: float, third: float, cube: float) -> FloatArray:
    """1 + the reduced cubic (12) over y^3, y = cos(beta*) + shift a, at its root."""
    c = geneva.crank_ratio(n)
    a, q, d = (1.0 - c * c) / c, 0.5 * (5.0 + c * c), (5.0 * c * c - 1.0) / (2.0 * c)
    # F is as good as infinite
    y = np.cos(reversal_study(n, 1e15).torque_max_angle) + shift * a
    rest = y * (-third * a * a - q) + cube * a**3 + sign * third * q * a + d
    return 1.0 + (y**3 + rest) / y**3
