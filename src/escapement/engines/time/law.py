"""The equation of motion in natural units, as numbers and as solve_ivp's right-hand side."""

from typing import Any, NamedTuple

import numpy as np

from escapement import dynamics
from escapement.dynamics import scene_of
from escapement.jit import jit
from escapement.mechanisms.slotted import transmission_at
from escapement.model import Escapement, FloatArray
from escapement.scene import Scene, scene_tuple


class Law(NamedTuple):
    """The equation of motion of one scene, for use outside of kernels.

    scene : the scene. plain : the same as `scene.scene_tuple` gives it, for kernels.
    """

    scene: Scene
    plain: tuple[Any, ...]

    @classmethod
    def of(cls, escapement: Escapement) -> "Law":
        """The law that an escapement moves by."""
        return cls(escapement.scene, scene_tuple(escapement.scene))

    @property
    def is_table(self) -> bool:
        """Whether the transmission comes from a table and not from a pin's path."""
        return self.scene.path.table

    def transmission(self, theta: float) -> tuple[float, float, float]:
        """g, u and g' at a driver angle."""
        g, u, dg = transmission_at(self.scene.path, theta)
        return g, u, dg

    def acceleration(self, theta: float, speed: float, side: float) -> float:
        """Driver acceleration while the given side of the slot carries the force."""
        return float(self.tabulate(np.array([theta]), np.array([speed**2]), side)[0][0])

    def force(self, theta: float, w: float) -> float:
        """A number with the sign of the contact force, whose zero is the pin reversal."""
        return float(contact_at(theta, w, self.plain))

    def side(self, theta: float, speed: float) -> float:
        """Side of the slot, +1 or -1, that carries the force where a piece begins."""
        return float(side_from(theta, speed**2, self.plain))

    def tabulate(
        self, theta: FloatArray, w: FloatArray, side: float
    ) -> tuple[FloatArray, FloatArray]:
        """Acceleration, and `force`, at many driver angles."""
        table = np.empty((5, theta.size))
        dynamics.tabulate(self.scene, theta, w, side, table)
        return table[2], table[4]


@jit(allocates=True)
def contact_at(theta, w, plain):
    """X at a driver angle; solve_ivp asks for it at every step."""
    scene = scene_of(plain)
    g, _u, dg = transmission_at(scene.path, theta)
    return dynamics.contact(g, dg, w, scene)


@jit(allocates=True)
def side_from(theta, w, plain):
    """Side of the slot that carries the force from a driver angle on."""
    scene = scene_of(plain)
    g, _u, dg = transmission_at(scene.path, theta)
    return dynamics.side_at(g, dg, w, scene)


@jit(allocates=True)
def slope(x, y, anchor, unit, side, plain):
    """Derivative of y by x, in the units of a piece.

    y = (angle from `anchor`, speed / unit, friction loss / unit^2), and x = time * unit;
    the scene comes as `scene.scene_tuple` gives it.
    """
    scene = scene_of(plain)
    out = np.empty(3)
    g, u, dg = transmission_at(scene.path, anchor + y[0])
    w = (unit * y[1]) ** 2
    out[0] = y[1]
    # J_s theta_ddot = 1 - p_s (g' w + load)
    out[1] = dynamics.acceleration(g, u, dg, w, side, scene) / unit**2
    # The loss is mu |N R| |u| theta_dot. It is taken with the sign of N, so that it stays
    # smooth where a trial step runs past the reversal.
    moment = dynamics.contact_moment(g, u, dg, w, side, scene)
    out[2] = dynamics.signed_loss(side, scene) * abs(u) * moment * y[1] / unit**2
    return out
