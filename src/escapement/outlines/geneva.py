"""Shapes of a Geneva drive in crank radii, as complex numbers.

The kinematics need only points and lines; a picture needs bodies. Widths are
chosen here so that no two bodies collide in any position: slots end where the
pin turns back, locking arcs stay clear of slots, and the driver's locking disc
is cut by the very envelope of the wheel that turns past it.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from escapement.mechanisms import Geneva
from escapement.model import FloatArray

_RAYS = 720  # of the locking disc; twice a multiple of every possible number of pins
_POSITIONS = {False: 361, True: 721}  # more for an internal wheel, whose corners sweep further
_MARCHES = 40
_SETTLED = 1e-5


@dataclass(frozen=True)
class Wheels:
    """Proportions of a drawing; the follower's axis is the origin.

    All lengths are in crank radii; slot 0 lies along the positive real axis
    when the follower angle is zero.
    """

    mechanism: Geneva

    @property
    def side(self) -> float:
        """+1 where slots are entered outwards (internal), -1 inwards."""
        return 1.0 if self.mechanism.internal else -1.0

    @property
    def slot_end(self) -> float:
        """Distance of a pin from the follower's axis at dead centre."""
        return self.mechanism.centre_distance + self.side

    @property
    def pin(self) -> float:
        """Pin radius."""
        return 0.08 if self.mechanism.internal else min(0.08, 0.4 * self.slot_end)

    @property
    def half_slot(self) -> float:
        """Half the slot width: the pin with a little play."""
        return 1.08 * self.pin

    @property
    def rim(self) -> float:
        """Radius of the rim; a pin enters as its centre crosses the mouth."""
        entry = self.mechanism.centre_distance * math.cos(math.pi / self.mechanism.slots)
        return math.hypot(entry, self.half_slot)

    @property
    def locks(self) -> bool:
        """Whether there is a dwell, and so locking arcs."""
        return not self.mechanism.continuous

    @property
    def lock(self) -> float:
        """Radius of the locking arcs; 0.1 of wheel is left beside each slot."""
        return 0.9 - self.half_slot

    @property
    def gap(self) -> float:
        """Play between the locking disc and the wheel."""
        return min(0.02, 0.2 * abs(self.mechanism.centre_distance - self.rim))

    @property
    def body(self) -> float:
        """Outer radius of the follower."""
        return self.slot_end + self.half_slot + 0.18 if self.mechanism.internal else self.rim

    @property
    def plate(self) -> float:
        """Radius of the crank disc that carries the pins."""
        return 1.0 + self.pin + 0.07

    @cached_property
    def outline(self) -> np.ndarray:
        """Closed edge of the follower that faces the driver; shape (points,), complex."""
        step = self.mechanism.follower_step
        sector = np.concatenate([self._slot(), self._land()])
        turns = np.exp(1j * step * np.arange(self.mechanism.slots))
        edge = (turns[:, None] * sector).ravel()
        return np.append(edge, edge[0])

    def _slot(self) -> np.ndarray:
        half = self.half_slot
        mouth = self.mechanism.centre_distance * math.cos(math.pi / self.mechanism.slots)
        turn = np.linspace(-np.pi / 2, np.pi / 2, 25)
        end = self.slot_end + half * (self.side * np.cos(turn) + 1j * np.sin(turn))
        return np.concatenate([[mouth - 1j * half], end, [mouth + 1j * half]])

    def _land(self) -> np.ndarray:
        """From slot 0 to slot 1, the corners left out."""
        middle = self.mechanism.follower_step / 2.0
        corner = math.asin(self.half_slot / self.rim)
        if not self.locks:
            sweep = np.linspace(corner, 2.0 * middle - corner, 61)[1:-1]
            return self.rim * np.exp(1j * sweep)
        axis = self.mechanism.centre_distance
        cosine = (self.rim**2 + axis**2 - self.lock**2) / (2.0 * self.rim * axis)
        horn = math.acos(cosine)
        spread = abs(np.angle(self.side * (self.rim * np.exp(1j * horn) - axis)))
        swing = 1j * self.side * np.linspace(-spread, spread, 61)[1:-1]
        arc = axis + self.side * self.lock * np.exp(swing)
        before = self.rim * np.exp(1j * np.linspace(corner, middle - horn, 9)[1:])
        after = self.rim * np.exp(1j * np.linspace(middle + horn, 2.0 * middle - corner, 9)[:-1])
        return np.concatenate([before, arc * np.exp(1j * middle), after])

    def clearance(self, points: np.ndarray) -> FloatArray:
        """How far points of the follower's plane lie outside its body, at least.

        Positive outside, negative inside; never more than the true distance.
        """
        step = self.mechanism.follower_step
        folded = points * np.exp(-1j * step * np.round(np.angle(points) / step))
        x, y = folded.real, np.abs(folded.imag)
        nearest = np.minimum(x, self.slot_end) if self.side > 0 else np.maximum(x, self.slot_end)
        slot = self.half_slot - np.hypot(x - nearest, y)
        rim = -self.side * (np.abs(folded) - self.rim)
        outside = np.maximum(slot, rim)
        if self.locks:
            centre = self.mechanism.centre_distance * np.exp(1j * step / 2.0)
            outside = np.maximum(outside, self.lock - np.abs(x + 1j * y - centre))
        return outside


def pose(mechanism: Geneva, theta: float) -> float:
    """Follower angle [rad] at any driver angle from a pin's dead centre.

    Counted on through engagements; locked between the exit of one pin and the
    entry of the next.
    """
    entry, exit_ = mechanism.breaks[0], mechanism.breaks[-1]
    engagement = math.floor((theta - entry) / mechanism.cell_angle)
    local = min(theta - engagement * mechanism.cell_angle, exit_)
    return engagement * mechanism.follower_step + float(mechanism.follower_angle(local))


@lru_cache(maxsize=32)
def locking_disc(wheels: Wheels) -> np.ndarray:
    """Outline of the driver's locking disc about its axis, pin 0 at dead centre.

    An external wheel leaves a disc with a hollow for each pin, an internal one
    a crescent opposite the pin. Every ray from the driver's axis is followed
    until the turning wheel, in any of its positions, comes within the gap.
    """
    mechanism, side = wheels.mechanism, wheels.side
    positions = _POSITIONS[mechanism.internal]
    theta = np.linspace(mechanism.breaks[0], mechanism.breaks[-1], positions)
    to_follower = np.exp(-1j * mechanism.follower_angle(theta))
    turned = np.exp(1j * side * theta) * to_follower
    axis = mechanism.centre_distance * to_follower
    rays = side * np.exp(1j * np.linspace(0.0, np.pi, _RAYS // 2 + 1))
    edge = wheels.lock - 1.2 * wheels.gap
    radius = np.full(rays.size, edge if mechanism.internal else 0.0)
    for _ in range(_MARCHES):
        points = axis[:, None] + turned[:, None] * (radius * rays)
        free = wheels.clearance(points).min(axis=0) - wheels.gap
        before, radius = radius, np.clip(radius - side * free, 0.0, edge)
        if np.abs(radius - before).max() < _SETTLED:
            break
    radius = np.concatenate([radius, radius[-2:0:-1]])
    rays = np.concatenate([rays, rays[-2:0:-1].conj()])
    if mechanism.internal:
        solid = radius < edge - 1e-6
        return np.concatenate([edge * rays[solid], (radius * rays)[solid][::-1]])
    pins = mechanism.pins or 1
    hollows = [np.roll(radius, k * _RAYS // pins) for k in range(pins)]
    return np.min(hollows, axis=0) * rays
