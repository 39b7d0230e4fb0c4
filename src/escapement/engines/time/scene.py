"""The equation of motion in natural units, as numbers and as solve_ivp's right-hand side."""

from typing import NamedTuple

import numpy as np

from escapement.dynamics import acceleration, bend, contact, contact_moment, side_at, tabulate
from escapement.jit import jit
from escapement.mechanisms.slotted import transmission_at
from escapement.mechanisms.table import is_table, smooth_intervals
from escapement.model import Escapement, FloatArray


class Scene(NamedTuple):
    """What the equation of motion depends on: the mechanism's path, rho, mu and the load."""

    path: FloatArray
    rho: float
    mu: tuple[float, float]
    load: float

    @classmethod
    def of(cls, escapement: Escapement) -> "Scene":
        """The scene of an escapement."""
        path, load = escapement.mechanism.path, escapement.load_ratio
        return cls(path, escapement.inertia_ratio, escapement.loss, load)

    @property
    def is_table(self) -> bool:
        """Whether the transmission comes from a table and not from a pin's path."""
        return bool(is_table(self.path))

    def smooth_edges(self, breaks: tuple[float, ...]) -> FloatArray:
        """Driver angles between which the transmission is analytic, knots of a table included."""
        edges: FloatArray = smooth_intervals(self.path, np.array(breaks))
        return edges

    def transmission(self, theta: float) -> tuple[float, float, float]:
        """g, u and g' at a driver angle."""
        g, u, dg = transmission_at(self.path, theta)
        return g, u, dg

    def acceleration(self, theta: float, speed: float, sign: float) -> float:
        """Driver acceleration while the side `sign` carries the force."""
        state = (*self.transmission(theta), speed**2, sign)
        return float(acceleration(*state, self.rho, self.mu, self.load))

    def force(self, theta: float, w: float) -> float:
        """A number with the sign of the contact force, whose zero is the pin reversal."""
        g, _u, dg = self.transmission(theta)
        return float(contact(g, dg, w, self.rho, self.load))

    def side(self, theta: float, speed: float) -> float:
        """Side of the slot, +1 or -1, that carries the force where a piece begins."""
        g, _u, dg = self.transmission(theta)
        return float(side_at(g, dg, speed**2, self.rho, self.load))

    def tabulate(
        self, theta: FloatArray, w: FloatArray, sign: float
    ) -> tuple[FloatArray, FloatArray]:
        """Acceleration, and `force`, at many driver angles."""
        table = np.empty((4, theta.size))
        tabulate(self.path, theta, w, sign, self.rho, self.mu, self.load, table)
        g, dg, rates, _moment = table
        # N R J_s = rho (g' w + load) + g: neither friction nor s enters (PHYSICS.md 2)
        return rates, self.rho * (dg * w + self.load) + g


@jit(allocates=True)
def slope(x, y, anchor, unit, sign, path, rho, mu, load):
    """Derivative of y by x, in the units of a piece.

    y = (angle from `anchor`, speed / unit, friction loss / unit^2), and x = time * unit.
    """
    out = np.empty(3)
    g, u, dg = transmission_at(path, anchor + y[0])
    w = (unit * y[1]) ** 2
    out[0] = y[1]
    # (rho + g p) theta_ddot + p (g' w + load) = 1, PHYSICS.md 2
    out[1] = acceleration(g, u, dg, w, sign, rho, mu, load) / unit**2
    # The loss is mu |N R| |u| theta_dot. It is taken with the sign of N, so that it stays
    # smooth where a trial step runs past the reversal.
    moment = contact_moment(g, u, dg, w, sign, rho, mu, load)
    out[2] = bend(sign, mu) * abs(u) * moment * y[1] / unit**2
    return out
