"""The motion as its textbook states it: for solvers that know nothing of the package.

Natural units (inertia of the follower, torque, `clock`), external Geneva wheel without
load. Between entry, dead centre, the one reversal and the exit the side s of the slot
and the sense of sliding are fixed, so p = g + kappa u with kappa = s mu sign(u):

    theta_ddot = (1 - p g' w) / (rho + g p),      w = theta_dot^2

With n = a cos - 1, L = a^2 + 1 - 2 a cos, g = n/L, u = a sin/L and g' = -(a^2 - 1) u/L
(Meyer 1-7, 1-8) one division is left. Everything below is this one formula, written
once for Python and Numba; the contact function, whose zero is the reversal, is
multiplied by L^2.
"""

import math
from typing import NamedTuple

import numpy as np

from escapement.benchmark.problems import Problem
from escapement.jit import jit

Parameters = tuple[float, float, float]
"""Centre distance a, inertia ratio rho, signed friction kappa."""


class Piece(NamedTuple):
    """One smooth piece of an engagement.

    parameters : of the equation of motion.
    start : driver angle where it starts; None at the reversal.
    end : driver angle where it ends; None at the reversal.
    """

    parameters: Parameters
    start: float | None
    end: float | None


def pieces_of(problem: Problem) -> tuple[Piece, Piece, Piece]:
    """Entry to dead centre, on to the reversal, on to the handoff."""
    a, rho, mu, end = problem.numbers
    return (
        Piece((a, rho, -mu), -end, 0.0),
        Piece((a, rho, mu), 0.0, None),
        Piece((a, rho, -mu), None, end),
    )


def acceleration(theta, speed, a, rho, kappa):
    """Driver acceleration."""
    n = a * math.cos(theta) - 1.0
    q = a * a - 1.0
    length = q - 2.0 * n
    slide = a * math.sin(theta)
    p = n + kappa * slide
    square = length * length
    return (square * length + q * p * slide * speed * speed) / (length * (rho * square + n * p))


def contact(theta, speed, a, rho):
    """Falls through zero at the pin reversal."""
    n = a * math.cos(theta) - 1.0
    q = a * a - 1.0
    return n * (q - 2.0 * n) - rho * q * a * math.sin(theta) * speed * speed


def derivative(t, y, a, rho, kappa):
    """Right-hand side for y = (theta, theta_dot) in plain Python."""
    return [y[1], acceleration(y[0], y[1], a, rho, kappa)]


def reversal(t, y, a, rho, kappa):
    """Event of the reversal in plain Python."""
    return contact(y[0], y[1], a, rho)


compiled_acceleration = jit(acceleration)
compiled_contact = jit(contact)


@jit(allocates=True)
def compiled_derivative(t, y, a, rho, kappa):
    """Right-hand side for y = (theta, theta_dot), compiled."""
    out = np.empty(2)
    out[0] = y[1]
    out[1] = compiled_acceleration(y[0], y[1], a, rho, kappa)
    return out


@jit
def compiled_reversal(t, y, a, rho, kappa):
    """Event of the reversal, compiled."""
    return compiled_contact(y[0], y[1], a, rho)
