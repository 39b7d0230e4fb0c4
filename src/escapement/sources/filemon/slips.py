"""What Filemon's equations must read: every slip, with the size of the error it makes.

Each erratum that is a formula carries the formula as printed, as corrected, and
what both should give, from the pin's path. `equations` evaluates them for 3 to 10
slots, so that a correction proves itself. Some slips may be those of the scan.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from escapement.constant_speed import geneva, reversal_study
from escapement.constant_speed.kernels import derivatives_at
from escapement.mechanisms import Geneva
from escapement.model import FloatArray
from escapement.sources.printed import EquationErratum, FormulaErratum

Formula = Callable[[FloatArray, FloatArray], Any]
"""From c and beta, arrays of one shape, to the values of an equation."""

SLOTS = tuple(range(3, 11))
_SHARES = np.array([-0.93, -0.7, -0.41, -0.2, 0.13, 0.35, 0.62, 0.88])  # places as shares of beta_0


@dataclass(frozen=True)
class _GridErratum(FormulaErratum):
    """A slip with what its formulas should give.

    truth : from the pin's path.
    angles : attribute of the grid, where the formulas are tried.
    """

    truth: "Callable[[_Grid], FloatArray] | None" = None
    angles: str = "places"

    def error(self, formula: Formula, grid: "_Grid") -> float:
        """Greatest relative deviation of a formula over the grid."""
        assert self.truth is not None
        found = formula(grid.c, getattr(grid, self.angles))
        return float(np.abs(found / self.truth(grid) - 1.0).max())


class _Grid:
    """Angles of 3 to 10 slots, and derivatives of the transmission at them."""

    def __init__(self) -> None:
        n = np.repeat(SLOTS, _SHARES.size)
        self.c = geneva.crank_ratio(n)
        self.places = np.tile(_SHARES, len(SLOTS)) * geneva.engagement_half(n)
        self.exit = geneva.engagement_half(n)
        self.steepest = geneva.acceleration_max_angle(n)
        self.highest = reversal_study(n, 1e15).torque_max_angle  # F is as good as infinite
        values = [
            derivatives_at(Geneva(int(k), pins=1).path, angle)
            for k, angle in zip(n, self.places, strict=True)
        ]
        self.g, self.dg, self.ddg, _ = np.array(values).T


def equations() -> list[EquationErratum]:
    """Every erratum of the equations, each tried out: relative errors for 3 to 10 slots."""
    grid = _Grid()
    return [slip.tried(partial(slip.error, grid=grid)) for slip in _SLIPS]


def _length(c: FloatArray, b: FloatArray) -> FloatArray:
    return 1.0 + c * c - 2.0 * c * np.cos(b)


def _rate(c: FloatArray, b: FloatArray) -> FloatArray:
    return -c * (1.0 - c * c) * np.sin(b) / _length(c, b) ** 2


def _ratio(c: FloatArray, b: FloatArray) -> FloatArray:
    return c * (np.cos(b) - c) / _length(c, b)


def _jerk(sign: float) -> Formula:
    def formula(c: FloatArray, b: FloatArray) -> FloatArray:
        x = np.cos(b)
        top = 2.0 * c * x**2 + (1.0 + sign * c * c) * x - 4.0 * c
        found: FloatArray = -c * (1.0 - c * c) * top / _length(c, b) ** 3
        return found

    return formula


def _cosine(sign: float) -> Formula:
    def formula(c: FloatArray, b: FloatArray) -> FloatArray:
        k = (1.0 + sign * c * c) / (4.0 * c)
        return -k + np.sqrt(k * k + 2.0)

    return formula


def _torque_slope(power: int) -> Formula:
    """dM_2/d beta at F = 1, M_e = eta = 1, the second denominator to a power."""

    def formula(c: FloatArray, b: FloatArray) -> FloatArray:
        x = np.cos(b)
        top = 2.0 * c * x**3 + 2.0 * (1.0 - c * c) * x**2 - (5.0 * c + c**3) * x + 5.0 * c * c - 1.0
        found: FloatArray = _rate(c, b) - c * c * (1.0 - c * c) * top / _length(c, b) ** power
        return found

    return formula


def _cubic(shift: float, sign: float, third: float, cube: float) -> Formula:
    """1 + the reduced cubic (12) over y^3, y = cos(beta*) + shift a."""

    def formula(c: FloatArray, b: FloatArray) -> FloatArray:
        a, q, d = (1.0 - c * c) / c, 0.5 * (5.0 + c * c), (5.0 * c * c - 1.0) / (2.0 * c)
        y = np.cos(b) + shift * a
        rest = y * (-third * a * a - q) + cube * a**3 + sign * third * q * a + d
        return 1.0 + (y**3 + rest) / y**3

    return formula


_SLIPS = (
    _GridErratum(
        "before (3)",
        "epsilon_0 = omega_0^2 d^2 alpha/d beta^2",
        "epsilon_0 = omega_2^2 d^2 alpha/d beta^2",
        lambda c, b: _ratio(c, b) ** 2 * _rate(c, b),
        _rate,
        lambda grid: grid.dg,
    ),
    _GridErratum(
        "d^3 alpha/d beta^3, before (5)",
        "2c cos^2(beta) + (1 - c^2) cos(beta) - 4c",
        "2c cos^2(beta) + (1 + c^2) cos(beta) - 4c",
        _jerk(-1.0),
        _jerk(1.0),
        lambda grid: grid.ddg,
    ),
    _GridErratum(
        "after (5)",
        "through the portion 0 to -beta_0 the same magnitudes but with negative signs",
        "through the portion 0 to +beta_0",
    ),
    _GridErratum("before (6)", "M_2 = Theta_0 omega_2^2/M_e", "F = Theta_0 omega_2^2/M_e"),
    _GridErratum(
        "(1) and (6)",
        "M_2 = i_omega (M_e + Theta_0 epsilon_0)/eta at every angle",
        "multiplied by eta, not divided, where M_2 < 0: there the follower drives",
    ),
    _GridErratum(
        "(7)",
        "denominator c (1 - c^2 sin(beta))",
        "denominator c (1 - c^2) sin(beta)",
        lambda c, b: _length(c, b) ** 2 / (c * (1.0 - c * c * np.sin(b))),
        lambda c, b: _length(c, b) ** 2 / (c * (1.0 - c * c) * np.sin(b)),
        lambda grid: -1.0 / grid.dg,
    ),
    _GridErratum(
        "cos(beta) under dF/d beta",
        "-(1 - c^2)/(4c) + sqrt(((1 - c^2)/(4c))^2 + 2)",
        "-(1 + c^2)/(4c) + sqrt(((1 + c^2)/(4c))^2 + 2), as in (5)",
        _cosine(-1.0),
        _cosine(1.0),
        lambda grid: np.cos(grid.steepest),
        "steepest",
    ),
    _GridErratum(
        "(9)",
        "F23 = -1/tan(alpha_0) = tan(beta_0)",
        "F23 = 1/tan(alpha_0) = tan(beta_0)",
        lambda c, b: -1.0 / np.tan(np.arcsin(c)),
        lambda c, b: 1.0 / np.tan(np.arcsin(c)),
        lambda grid: np.tan(grid.exit),
        "exit",
    ),
    _GridErratum(
        "dM_2/d beta, after Fig. 16",
        "second denominator (1 - 2c cos(beta) + c^2)^3",
        "second denominator (1 - 2c cos(beta) + c^2)^4",
        _torque_slope(3),
        _torque_slope(4),
        lambda grid: grid.dg + grid.dg**2 + grid.g * grid.ddg,
    ),
    _GridErratum("F for dM_2/d beta = 0", "(14)", "(11), as the text that follows calls it"),
    _GridErratum(
        "(12)",
        "unknown cos(beta*), constant 0.074 a^3 - 0.333 b a + d",
        "unknown cos(beta*) + a/3, constant 2 a^3/27 + a b/3 + d",
        _cubic(0.0, -1.0, 0.333, 0.074),
        _cubic(1.0 / 3.0, 1.0, 1.0 / 3.0, 2.0 / 27.0),
        lambda grid: np.ones_like(grid.c),
        "highest",
    ),
)
