"""The equation of motion in natural units, as numbers and as solve_ivp's right-hand side."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from escapement.dynamics import law as dynamics
from escapement.dynamics.law import scene_of
from escapement.dynamics.load import load_at
from escapement.dynamics.state_table import LOST, ROWS, LawTable, losses_at, tabulate
from escapement.dynamics.torque import fall_at, is_alike, torque_after, torque_at
from escapement.dynamics.train_losses import flowing
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import pose_at
from escapement.model.escapement import Escapement
from escapement.model.scene import Scene, packed
from escapement.numerics.jit import as_python, jit

_GRID = 128
"""Number of intervals in which the least share of the reduced inertia is searched for."""
_FAR = 4.0 * np.pi
"""Driver angle [rad], of any cell or more, over which a trial step may leave a piece."""


@dataclass(frozen=True)
class SceneLaw:
    """The equation of motion of one scene, for use outside of kernels.

    scene : the scene. plain : the same as `model.scene.packed` gives it, for kernels.
    """

    scene: Scene
    plain: FloatArray

    @classmethod
    def all_of(cls, escapement: Escapement) -> "list[SceneLaw]":
        """The law of each engagement of the pattern of an escapement."""
        return [cls(scene, packed(scene)) for scene in escapement.scenes]

    @property
    def is_steady(self) -> bool:
        """Whether the torque is the same at all angles."""
        return self.scene.torque.size == 3

    @property
    def is_meshed(self) -> bool:
        """Whether the transmission is that of gears, in which no pin slides."""
        return self.scene.path.meshed

    @cached_property
    def losses(self) -> np.ndarray:
        """Indices of those of `dynamics.law.LOSSES` that this scene has."""
        scene = self.scene
        present = (
            scene.mu_plus,
            scene.driver_journal + scene.bearing,
            scene.follower_journal,
            scene.driver_drag + scene.driver_viscous + scene.pace,
            scene.follower_drag + scene.follower_viscous,
            scene.barrel_efficiency < 1.0,
            scene.load_train_efficiency < 1.0,
        )
        return np.flatnonzero(present)

    def loss_rates(self, theta: float, w: float, side: float) -> FloatArray:
        """The losses that there are, per driver angle."""
        rates: FloatArray = self.table(np.array([theta]), np.array([w]), side)[LOST:][
            self.losses, 0
        ]
        return rates

    def acceleration(self, theta: float, speed: float, side: float) -> float:
        """Driver acceleration while the given side of the slot carries the force."""
        law = LawTable(*self.table(np.array([theta]), np.array([speed**2]), side))
        return float(law.rate[0])

    def rest(self, theta: float, side: float) -> float:
        """Driver speed at which a motion counts as at rest."""
        return float(dynamics.rest_speed(theta, side, self.scene))

    def driver_angle(self, theta: Any) -> Any:
        """Driver angle turned since the start of the motion, at one in the cell."""
        return self.scene.driver_angle + (theta - self.scene.edges[0])

    def after(self, driver_angle: float) -> "SceneLaw":
        """The law in the cell after a driver angle turned."""
        scene = self.scene._replace(driver_angle=driver_angle)
        return SceneLaw(scene, packed(scene))

    def along(self, theta: float) -> "SceneLaw":
        """The law whose torque goes on beyond its knots as it is at a driver angle."""
        driver_angle = self.driver_angle(theta)
        torque, slope = torque_after(driver_angle, self.scene)
        ends = driver_angle + np.array([-_FAR, _FAR])
        fall = self.scene.fall if is_alike(self.scene) else self._fall_along(driver_angle, ends)
        line = [0.0, 0.0, torque]
        if slope or fall is not self.scene.fall:
            line = [0.0, *ends, *(torque + slope * (ends - driver_angle))]
        scene = self.scene._replace(torque=np.array(line), fall=fall)
        return SceneLaw(scene, packed(scene))

    def _fall_along(self, driver_angle: float, ends: FloatArray) -> FloatArray:
        """`Scene.fall` with rows for two ends, as it is between the knots at a driver angle."""
        fall, (period, *angles) = (
            self.scene.fall,
            self.scene.torque[: self.scene.torque.size // 2 + 1],
        )
        speeds, turned = int(fall[0]), driver_angle % period if period else driver_angle
        rows = fall[1 + speeds :].reshape(len(angles), -1)
        k = int(np.searchsorted(angles, turned, side="right"))
        before, after = max(k - 1, 0), min(k, len(angles) - 1)
        width = angles[after] - angles[before] or 1.0
        share = (turned - angles[before] + ends - driver_angle)[:, None] / width
        found = rows[before] + share * (rows[after] - rows[before])
        return np.concatenate([fall[: 1 + speeds], found.reshape(-1)])

    def force(self, theta: float, w: float, side: float) -> float:
        """A number with the sign of the contact force, whose zero is the pin reversal.

        In a dwell (`side` is 0) there is no contact, and the number is 1.
        """
        return float(contact_at(theta, w, side, self.plain)) if side else 1.0

    def signs(self, theta: float, side: float) -> tuple[float, float]:
        """Signs of the sliding speed and of g; 0 for gears, in which they never change."""
        if self.is_meshed:
            return 0.0, 0.0
        g, u, _dg, radius = pose_at(self.scene.path, theta)
        slide = as_python(dynamics.slide_at)(g, u, radius, side, self.scene)
        return float(np.sign(slide)), float(np.sign(g))

    def side(self, theta: float, speed: float, before: float) -> float:
        """Side of the slot, +1 or -1, that carries the force where a piece begins.

        `before` is the side before it, and 0 where the follower was locked.
        """
        return float(side_from(theta, speed**2, before or 1.0, self.plain))

    def table(self, theta: FloatArray, w: FloatArray, side: float) -> FloatArray:
        """The rows of a `LawTable` at many driver angles."""
        table, inward = np.empty((ROWS, theta.size)), np.zeros(theta.size)
        tabulate(self.scene, theta, inward, self.driver_angle(theta), w, side, table)
        return table


@jit
def least_share(scene):
    """Least share of rho + g^2 that J_s keeps; near the Painleve limit it is near 0."""
    least, low, high = 1.0, scene.edges[0], scene.edges[-1]
    for i in range(_GRID + 1):
        for side in (-1.0, 1.0):
            theta = low + i * (high - low) / _GRID
            g, c, _k = dynamics.bent_pose(theta, side, scene)
            least = min(least, 1.0 + g * c / (scene.rho + g * g))
    return least


@jit(allocates=True)
def contact_at(theta, w, side, plain):
    """X at a driver angle; solve_ivp asks for it at every step."""
    scene = flowing(theta, side, w, scene_of(plain))
    return dynamics.wall_state(theta, w, side, scene).moment


@jit(allocates=True)
def side_from(theta, w, before, plain):
    """Side of the slot that carries the force just behind a driver angle."""
    scene = flowing(theta, 1.0, w, scene_of(plain))
    now, slope = dynamics.wall_state(theta, w, 1.0, scene), torque_at(theta, scene)[1]
    return dynamics.side_at(theta, now.g, now.k, now.pull, slope, w, before, scene)


@jit(allocates=True)
def slope(x, y, anchor, unit, side, slide_sign, ratio_sign, losses, plain):
    """Derivative of y by x, in the units of a piece.

    y = (angle from `anchor`, speed / unit, each of `losses` / unit^2), and x = time * unit; the
    scene comes as `model.scene.packed` gives it. `slide_sign` and `ratio_sign` are as in
    `dynamics.law.grip`. A trial step may pass the end of a piece, where |v| and |g| have corners
    that would make the solver reject it; with the signs of the piece the law goes on smoothly.
    """
    scene = scene_of(plain)
    out = np.empty(2 + losses.size)
    w, theta = (unit * y[1]) ** 2, anchor + y[0]
    scene = flowing(theta, side, w, scene)
    now = dynamics.wall_state(theta, w, side, scene, slide_sign, ratio_sign)
    out[0], out[1] = y[1], now.rate / unit**2
    path, load = (now.g, now.u, now.radius, now.k), load_at(theta, side, scene)
    signs, fall = (slide_sign, ratio_sign), fall_at(theta, w, scene)
    rates = losses_at(*path, now.pull, w, side, scene, *signs, load, fall)
    for i in range(losses.size):
        out[2 + i] = rates[1 + losses[i]] * y[1] / unit**2
    return out
