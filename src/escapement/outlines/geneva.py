"""Bodies of a Geneva drive in crank radii.

The kinematics need little more than points and lines, while a picture needs bodies. A pin
has the radius it was given, or one chosen here; other widths are chosen here so that no
two bodies collide in any position: slots end where the pin turns back, locking arcs stay
clear of slots, and the driver's locking disc is cut by the envelope of the wheel that
turns past it.
"""

import math
from functools import lru_cache

import numpy as np

from escapement.mechanism import FloatArray
from escapement.mechanisms import Geneva
from escapement.outlines import (
    Body,
    ComplexArray,
    Disc,
    arc,
    closed,
    locked_angle,
    pins_and_rollers,
    slotted_edge,
)

# Rays of the locking disc; the number is twice a multiple of every possible number of pins.
_RAYS = 720
# Positions of the wheel; an internal one needs more, because its corners sweep further.
_POSITIONS = {False: 361, True: 721}
_MARCHES = 40
_SETTLED = 1e-5


class GenevaOutline:
    """Proportions and bodies of a Geneva drive.

    All lengths are in crank radii. The follower's axis is the origin, the driver's lies on
    the positive real axis, and so does slot 0 when the follower angle is zero.

    Attributes
    ----------
    side : float
        +1 where slots are entered outwards (internal), -1 inwards.
    slot_end : float
        Distance of a pin from the follower's axis at dead centre.
    pin_radius, half_slot : float
        Radius of a pin, or of the roller on it, and half the slot width: the same where a
        radius was given, with a little play where it was not.
    rim_radius : float
        Radius of the rim; a pin enters as its centre crosses the mouth.
    locks : bool
        Whether there are locking arcs: not without a dwell, nor where wide slots leave no room.
    lock_radius : float
        Radius of the locking arcs; 0.1 of wheel is left beside each slot, or half of what
        there is.
    gap : float
        Play between the locking disc and the wheel.
    follower_radius, crank_disc_radius : float
        Outer radii of the follower and of the disc that carries the pins.
    follower_edge : ndarray, shape (points,), complex
        Closed edge of the follower that faces the driver.
    """

    def __init__(self, mechanism: Geneva) -> None:
        self.mechanism, internal = mechanism, mechanism.internal
        centre, self.side = mechanism.centre_distance, 1.0 if internal else -1.0
        self.slot_end = centre + self.side
        chosen = 0.08 if internal else min(0.08, 0.4 * self.slot_end)
        self.pin_radius = mechanism.contact_radius or chosen
        self.half_slot = mechanism.contact_radius or 1.08 * chosen
        self.rim_radius = math.hypot(centre * math.cos(math.pi / mechanism.slots), self.half_slot)
        wall = 1.0 - self.half_slot
        self.lock_radius = wall - min(0.1, 0.5 * wall)
        room = self.lock_radius - abs(centre - self.rim_radius)
        self.locks = not mechanism.continuous and room > 0.0
        self.gap = min(0.02, 0.2 * abs(centre - self.rim_radius))
        ring = self.slot_end + self.half_slot + 0.18
        self.follower_radius = ring if internal else self.rim_radius
        self.crank_disc_radius = 1.0 + self.pin_radius + 0.07
        edge = self.rim_radius, self.slot_end, self.half_slot
        self.follower_edge = slotted_edge(*edge, 25, self._land(), mechanism.slots)

    def bodies(self, theta: float) -> list[Body | Disc]:
        """Everything that is drawn, where it stands at a driver angle.

        "follower", "crank-disc", "driver-shaft" and "pin-k" with k counted from 0 are always
        there; "locking-disc" only with a dwell and room for it, "follower-shaft" only of an
        external wheel, "roller-k" only where pins have rollers.
        """
        mechanism, centre = self.mechanism, self.mechanism.centre_distance
        outside = (arc(self.follower_radius, 2.0 * np.pi, 0.0),) if mechanism.internal else ()
        follower = Body("follower", (self.follower_edge, *outside))
        found: list[Body | Disc] = [follower.turned(locked_angle(mechanism, theta))]
        if self.locks and (edge := locking_disc(mechanism)).size:
            found.append(Body("locking-disc", (edge,)).turned(self.side * theta, centre))
        shaft = 0.12 if mechanism.internal else min(0.14, 0.5 * (centre - self.rim_radius))
        discs: dict[str, tuple[complex, float]] = {}
        discs |= {"crank-disc": (centre, self.crank_disc_radius), "driver-shaft": (centre, shaft)}
        if not mechanism.internal:
            discs["follower-shaft"] = 0.0, min(0.12, 0.5 * (self.slot_end - self.half_slot))
        found += [Disc(name, *round_) for name, round_ in discs.items()]
        turned = theta - np.arange(mechanism.pins or 1) * mechanism.cell_angle
        places = centre + self.side * np.exp(1j * self.side * turned)
        return found + pins_and_rollers(mechanism, places.tolist(), self.pin_radius)

    def _land(self) -> ComplexArray:
        """From slot 0 to slot 1, the corners left out."""
        middle, rim = self.mechanism.follower_step / 2.0, self.rim_radius
        corner = math.asin(self.half_slot / rim)
        if not self.locks:
            return arc(rim, corner, 2.0 * middle - corner, 61)[1:-1]
        axis = self.mechanism.centre_distance
        horn = math.acos((rim**2 + axis**2 - self.lock_radius**2) / (2.0 * rim * axis))
        wide = self.side * abs(np.angle(self.side * (rim * np.exp(1j * horn) - axis)))
        lock = axis + self.side * arc(self.lock_radius, -wide, wide, 61)
        before = arc(rim, corner, middle - horn, 9)
        after = arc(rim, middle + horn, 2.0 * middle - corner, 9)
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
def locking_disc(mechanism: Geneva) -> ComplexArray:
    """Closed edge of the driver's locking disc about its axis, pin 0 at dead centre.

    An external wheel leaves a disc with a hollow for each pin, an internal one
    a crescent opposite the pin, or nothing where wide slots leave no room for it. Every
    ray from the driver's axis is followed until the turning wheel, in any of its
    positions, comes within the gap.
    """
    outline, side = GenevaOutline(mechanism), 1.0 if mechanism.internal else -1.0
    ends = mechanism.breaks[0], mechanism.breaks[-1]
    theta = np.linspace(*ends, _POSITIONS[mechanism.internal])
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
        if not solid.any():
            return rays[:0]
        return closed(np.concatenate([edge * rays[solid], (radius * rays)[solid][::-1]]))
    pins = mechanism.pins or 1
    hollows = [np.roll(radius, k * _RAYS // pins) for k in range(pins)]
    return closed(np.min(hollows, axis=0) * rays)
