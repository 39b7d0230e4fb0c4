"""Bodies of a Geneva drive in crank radii.

The kinematics need only points and lines, while a picture needs bodies. Widths are
chosen here so that no two bodies collide in any position: slots end where the
pin turns back, locking arcs stay clear of slots, and the driver's locking disc
is cut by the envelope of the wheel that turns past it.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from escapement.mechanisms import Geneva
from escapement.model import FloatArray
from escapement.outlines import (
    Body,
    ComplexArray,
    Disc,
    circle_edge,
    closed,
    locked_angle,
    slotted_edge,
)

# Rays of the locking disc; the number is twice a multiple of every possible number of pins.
_RAYS = 720
# Positions of the wheel; an internal one needs more, because its corners sweep further.
_POSITIONS = {False: 361, True: 721}
_MARCHES = 40
_SETTLED = 1e-5


@dataclass(frozen=True)
class GenevaOutline:
    """Proportions and bodies of a Geneva drive.

    All lengths are in crank radii. The follower's axis is the origin, the driver's lies on
    the positive real axis, and so does slot 0 when the follower angle is zero.
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
    def pin_radius(self) -> float:
        """Pin radius."""
        return 0.08 if self.mechanism.internal else min(0.08, 0.4 * self.slot_end)

    @property
    def half_slot(self) -> float:
        """Half the slot width: the pin with a little play."""
        return 1.08 * self.pin_radius

    @property
    def rim_radius(self) -> float:
        """Radius of the rim; a pin enters as its centre crosses the mouth."""
        entry = self.mechanism.centre_distance * math.cos(math.pi / self.mechanism.slots)
        return math.hypot(entry, self.half_slot)

    @property
    def locks(self) -> bool:
        """Whether there is a dwell, and so locking arcs."""
        return not self.mechanism.continuous

    @property
    def lock_radius(self) -> float:
        """Radius of the locking arcs; 0.1 of wheel is left beside each slot."""
        return 0.9 - self.half_slot

    @property
    def gap(self) -> float:
        """Play between the locking disc and the wheel."""
        return min(0.02, 0.2 * abs(self.mechanism.centre_distance - self.rim_radius))

    @property
    def follower_radius(self) -> float:
        """Outer radius of the follower."""
        return self.slot_end + self.half_slot + 0.18 if self.mechanism.internal else self.rim_radius

    @property
    def crank_disc_radius(self) -> float:
        """Radius of the crank disc that carries the pins."""
        return 1.0 + self.pin_radius + 0.07

    @cached_property
    def follower_edge(self) -> ComplexArray:
        """Closed edge of the follower that faces the driver; shape (points,), complex."""
        slots, land = self.mechanism.slots, self._land()
        return slotted_edge(self.rim_radius, self.slot_end, self.half_slot, 25, land, slots)

    def bodies(self, theta: float) -> list[Body | Disc]:
        """Everything that is drawn, where it stands at a driver angle.

        "follower", "crank-disc", "driver-shaft" and "pin-k" with k counted from 0 are always
        there; "locking-disc" only with a dwell, "follower-shaft" only of an external wheel.
        """
        mechanism, centre = self.mechanism, self.mechanism.centre_distance
        outside = (circle_edge(self.follower_radius),) if mechanism.internal else ()
        found: list[Body | Disc] = [
            Body("follower", (self.follower_edge, *outside)).turned(locked_angle(mechanism, theta)),
            Disc("crank-disc", centre, self.crank_disc_radius),
        ]
        if not mechanism.internal:
            shaft = min(0.12, 0.5 * (self.slot_end - self.half_slot))
            found.append(Disc("follower-shaft", 0.0, shaft))
        if self.locks:
            disc = Body("locking-disc", (locking_disc(self),))
            found.append(disc.turned(self.side * theta, centre))
        shaft = 0.12 if mechanism.internal else min(0.14, 0.5 * (centre - self.rim_radius))
        found.append(Disc("driver-shaft", centre, shaft))
        for k in range(mechanism.pins or 1):
            turn = np.exp(1j * self.side * (theta - k * mechanism.cell_angle))
            found.append(Disc(f"pin-{k}", complex(centre + self.side * turn), self.pin_radius))
        return found

    def _land(self) -> ComplexArray:
        """From slot 0 to slot 1, the corners left out."""
        middle = self.mechanism.follower_step / 2.0
        rim = self.rim_radius
        corner = math.asin(self.half_slot / rim)
        if not self.locks:
            return _arc(rim, corner, 2.0 * middle - corner, 61)[1:-1]
        axis = self.mechanism.centre_distance
        cosine = (rim**2 + axis**2 - self.lock_radius**2) / (2.0 * rim * axis)
        horn = math.acos(cosine)
        spread = abs(np.angle(self.side * (rim * np.exp(1j * horn) - axis)))
        lock = axis + self.side * _arc(
            self.lock_radius, -self.side * spread, self.side * spread, 61
        )
        before = _arc(rim, corner, middle - horn, 9)
        after = _arc(rim, middle + horn, 2.0 * middle - corner, 9)
        return np.concatenate([before[1:], lock[1:-1] * np.exp(1j * middle), after[:-1]])

    def clearance(self, points: ComplexArray) -> FloatArray:
        """How far points of the follower's plane lie outside its body, at least.

        Positive outside, negative inside; never more than the true distance.
        """
        step = self.mechanism.follower_step
        folded = points * np.exp(-1j * step * np.round(np.angle(points) / step))
        x, y = folded.real, np.abs(folded.imag)
        nearest = np.minimum(x, self.slot_end) if self.side > 0 else np.maximum(x, self.slot_end)
        slot = self.half_slot - np.hypot(x - nearest, y)
        rim = -self.side * (np.abs(folded) - self.rim_radius)
        outside: FloatArray = np.maximum(slot, rim)
        if self.locks:
            centre = self.mechanism.centre_distance * np.exp(1j * step / 2.0)
            outside = np.maximum(outside, self.lock_radius - np.abs(x + 1j * y - centre))
        return outside


@lru_cache(maxsize=32)
def locking_disc(outline: GenevaOutline) -> ComplexArray:
    """Closed edge of the driver's locking disc about its axis, pin 0 at dead centre.

    An external wheel leaves a disc with a hollow for each pin, an internal one
    a crescent opposite the pin. Every ray from the driver's axis is followed
    until the turning wheel, in any of its positions, comes within the gap.
    """
    mechanism, side = outline.mechanism, outline.side
    positions = _POSITIONS[mechanism.internal]
    theta = np.linspace(mechanism.breaks[0], mechanism.breaks[-1], positions)
    to_follower = np.exp(-1j * mechanism.follower_angle(theta))
    turned = np.exp(1j * side * theta) * to_follower
    axis = mechanism.centre_distance * to_follower
    rays = side * np.exp(1j * np.linspace(0.0, np.pi, _RAYS // 2 + 1))
    edge = outline.lock_radius - 1.2 * outline.gap
    radius = np.full(rays.size, edge if mechanism.internal else 0.0)
    for _ in range(_MARCHES):
        points = axis[:, None] + turned[:, None] * (radius * rays)
        free = outline.clearance(points).min(axis=0) - outline.gap
        before, radius = radius, np.clip(radius - side * free, 0.0, edge)
        if np.abs(radius - before).max() < _SETTLED:
            break
    radius = np.concatenate([radius, radius[-2:0:-1]])
    rays = np.concatenate([rays, rays[-2:0:-1].conj()])
    if mechanism.internal:
        solid = radius < edge - 1e-6
        return closed(np.concatenate([edge * rays[solid], (radius * rays)[solid][::-1]]))
    pins = mechanism.pins or 1
    hollows = [np.roll(radius, k * _RAYS // pins) for k in range(pins)]
    return closed(np.min(hollows, axis=0) * rays)


def _arc(radius: float, start: float, stop: float, points: int) -> ComplexArray:
    """Points of a circle about the origin, from angle to angle [rad]."""
    arc: ComplexArray = radius * np.exp(1j * np.linspace(start, stop, points))
    return arc
