"""The problem that every solver gets, its equation, and how wrong an answer is.

Four slots, four pins and Meyer's inertias (1973, Appendix E) under 0.10 in-lbf, twenty
engagements from rest. The answer is the time and the driver speed at each handoff; the
error is the largest relative difference from a reference of twenty digits.

The package's engines get an `Escapement`. A solver that knows nothing of the package gets
the textbook's equation in natural units (inertia of the follower, torque, `clock`).
Between entry, dead centre, the one reversal and the exit the side s of the slot and the
sense of sliding are fixed, so p = g + kappa u with kappa = s mu sign(u):

    theta_ddot = (1 - p g' w) / (rho + g p),      w = theta_dot^2

With n = a cos - 1, L = a^2 + 1 - 2 a cos, g = n/L, u = a sin/L and g' = -(a^2 - 1) u/L
(Meyer 1-7, 1-8) one division is left. The same source serves Python and Numba; the contact
function, whose zero is the reversal, is multiplied by L^2.
"""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from typing import NamedTuple

import numpy as np

from escapement.jit import jit
from escapement.mechanisms import Geneva
from escapement.model import Escapement, FloatArray, Inertia
from escapement.units import INCH_POUND

REFERENCE = "reference.json"
"""Data file of this package, written by `benchmarks/make_reference.py`."""


@dataclass(frozen=True)
class Problem:
    """A motion from rest with a known answer.

    Parameters
    ----------
    name, title : str
        In files, and in figures.
    friction : float
        Coefficient of friction [-].
    slots : int
        Slots of an external wheel in continuous engagement.
    driver_inertia, follower_inertia : float
        Moments of inertia [kg m^2].
    torque : float
        Driving torque [N m].
    engagements : int
        Handoffs that are compared.
    """

    name: str
    title: str
    friction: float
    slots: int = 4
    driver_inertia: float = 3e-6 * INCH_POUND
    follower_inertia: float = 50e-6 * INCH_POUND
    torque: float = 0.10 * INCH_POUND
    engagements: int = 20

    @cached_property
    def escapement(self) -> Escapement:
        """The problem as the package states it."""
        return Escapement(
            mechanism=Geneva(slots=self.slots),
            inertia=Inertia(driver=self.driver_inertia, follower=self.follower_inertia),
            friction=self.friction,
            torque=self.torque,
        )

    @cached_property
    def numbers(self) -> tuple[float, float, float, float]:
        """Centre distance, inertia ratio, friction and half the engagement angle [rad].

        All a solver needs to know when the follower's inertia, the torque and
        `clock` are its units.
        """
        turn = math.pi / self.slots
        ratio = self.driver_inertia / self.follower_inertia
        return 1.0 / math.sin(turn), ratio, self.friction, math.pi / 2.0 - turn

    @property
    def clock(self) -> float:
        """Unit of time of `numbers`, sqrt(I_f / torque) [s]."""
        return math.sqrt(self.follower_inertia / self.torque)

    @cached_property
    def reference(self) -> tuple[FloatArray, FloatArray]:
        """Handoff times [s] and speeds [rad/s], correctly rounded."""
        text = files(__package__).joinpath(REFERENCE).read_text(encoding="utf-8")
        record = json.loads(text)[self.name]
        times, speeds = record["handoff_times"], record["handoff_velocities"]
        return np.array([float(x) for x in times]), np.array([float(x) for x in speeds])

    def error(self, times: FloatArray, speeds: FloatArray) -> float:
        """Largest relative error of handoff times and speeds [-]; NaN where one is missing."""
        if len(times) != self.engagements:
            return math.nan
        found, expected = np.array([times, speeds]), np.array(self.reference)
        return float(np.abs(found / expected - 1.0).max())


PROBLEMS = (
    Problem("meyer", r"four slots, $\mu$ = 0.35", 0.35),
    # the Painleve limit is 0.406079, so the reduced inertia falls to a hundredth
    Problem("near-limit", r"$\mu$ = 0.402, 99 % of the Painlevé limit", 0.402),
)


Parameters = tuple[float, float, float]
"""Centre distance a, inertia ratio rho, signed friction kappa."""
Vector = Sequence[float] | FloatArray
"""Driver angle and driver speed."""


class SmoothPiece(NamedTuple):
    """One smooth piece of an engagement.

    parameters : of the equation of motion.
    start : driver angle where it starts; None at the reversal.
    end : driver angle where it ends; None at the reversal.
    """

    parameters: Parameters
    start: float | None
    end: float | None


def pieces_of(problem: Problem) -> tuple[SmoothPiece, SmoothPiece, SmoothPiece]:
    """Entry to dead centre, on to the reversal, on to the handoff."""
    a, rho, mu, end = problem.numbers
    return (
        SmoothPiece((a, rho, -mu), -end, 0.0),
        SmoothPiece((a, rho, mu), 0.0, None),
        SmoothPiece((a, rho, -mu), None, end),
    )


def driver_acceleration(theta: float, speed: float, a: float, rho: float, kappa: float) -> float:
    """Driver acceleration."""
    n = a * math.cos(theta) - 1.0
    q = a * a - 1.0
    length = q - 2.0 * n
    slide = a * math.sin(theta)
    p = n + kappa * slide
    square = length * length
    return (square * length + q * p * slide * speed * speed) / (length * (rho * square + n * p))


def contact_function(theta: float, speed: float, a: float, rho: float) -> float:
    """A function that falls through zero at the pin reversal."""
    n = a * math.cos(theta) - 1.0
    q = a * a - 1.0
    return n * (q - 2.0 * n) - rho * q * a * math.sin(theta) * speed * speed


def derivative(t: float, y: Vector, a: float, rho: float, kappa: float) -> list[float]:
    """Right-hand side for y = (theta, theta_dot) in plain Python."""
    return [y[1], driver_acceleration(y[0], y[1], a, rho, kappa)]


def reversal(t: float, y: Vector, a: float, rho: float, kappa: float) -> float:
    """Event of the reversal in plain Python."""
    return contact_function(y[0], y[1], a, rho)


compiled_acceleration = jit(driver_acceleration)
compiled_contact = jit(contact_function)


@jit(allocates=True)
def compiled_derivative(t: float, y: FloatArray, a: float, rho: float, kappa: float) -> FloatArray:
    """Right-hand side for y = (theta, theta_dot), compiled."""
    out = np.empty(2)
    out[0] = y[1]
    out[1] = compiled_acceleration(y[0], y[1], a, rho, kappa)
    return out


@jit
def compiled_reversal(t: float, y: FloatArray, a: float, rho: float, kappa: float) -> float:
    """Event of the reversal, compiled."""
    value: float = compiled_contact(y[0], y[1], a, rho)
    return value
