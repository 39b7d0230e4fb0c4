"""Bodies of a Geneva drive in crank radii.

The kinematics need little more than points and lines, while a picture needs bodies. A pin
has the radius it was given, or one chosen here; other widths are chosen here so that no
two bodies collide in any position: slots end where the pin turns back, locking arcs stay
clear of slots, and the driver's locking disc is cut by the envelope of the wheel that
turns past it.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from escapement import validate
from escapement.errors import InvalidValue
from escapement.fitting import IMPERFECT
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

    Parameters
    ----------
    mechanism : Geneva
        What to draw, with its errors.
    exaggerate : float
        By what its errors are multiplied.

    Attributes
    ----------
    mechanism, perfect : Geneva
        The wheel with these errors, and without any.
    side : float
        +1 where slots are entered outwards (internal), -1 inwards.
    centre : float
        Distance of the axes.
    slot_end : float
        Distance of a pin from the follower's axis at dead centre, the greatest way in of all.
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

    def __init__(self, mechanism: Geneva, exaggerate: float = 1.0) -> None:
        self.mechanism = scaled_errors(mechanism, exaggerate)
        self.perfect = scaled_errors(mechanism, 0.0)
        unit, internal = mechanism.crank_radius or 1.0, mechanism.internal
        centre, self.side = mechanism.centre_distance, 1.0 if internal else -1.0
        self.centre = centre + self.mechanism.centre_distance_error / unit
        self.cranks = 1.0 + _each(self.mechanism.crank_radius_errors, mechanism.pins) / unit
        self.slot_end = self.centre + self.side * self.cranks.max()
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
        if self.mechanism.perfect:
            self.follower_edge = slotted_edge(*edge, 25, self._land(), mechanism.slots)
        else:
            self.follower_edge = self._imperfect_edge()

    def bodies(self, theta: float) -> list[Body | Disc]:
        """Everything that is drawn, where it stands at a driver angle.

        "follower", "crank-disc", "driver-shaft" and "pin-k" with k counted from 0 are always
        there; "locking-disc" only with a dwell and room for it, "follower-shaft" only of an
        external wheel, "roller-k" only where pins have rollers.
        """
        mechanism, centre = self.mechanism, self.centre
        outside = (arc(self.follower_radius, 2.0 * np.pi, 0.0),) if mechanism.internal else ()
        follower = Body("follower", (self.follower_edge, *outside))
        found: list[Body | Disc] = [follower.turned(self.follower_at(theta))]
        if self.locks and (edge := locking_disc(self.perfect)).size:
            found.append(Body("locking-disc", (edge,)).turned(self.side * theta, centre))
        shaft = 0.12 if mechanism.internal else min(0.14, 0.5 * (centre - self.rim_radius))
        discs: dict[str, tuple[complex, float]] = {}
        discs |= {"crank-disc": (centre, self.crank_disc_radius), "driver-shaft": (centre, shaft)}
        if not mechanism.internal:
            discs["follower-shaft"] = 0.0, min(0.12, 0.5 * (self.slot_end - self.half_slot))
        found += [Disc(name, *round_) for name, round_ in discs.items()]
        late = _each(mechanism.pin_angle_errors, mechanism.pins)
        turned = theta - late - np.arange(late.size) * mechanism.cell_angle
        places = centre + self.side * self.cranks * np.exp(1j * self.side * turned)
        return found + pins_and_rollers(mechanism, places.tolist(), self.pin_radius)

    def follower_at(self, theta: float) -> float:
        """Follower angle [rad] at any driver angle; it rests from a pin's exit to the next one."""
        mechanism = self.mechanism
        if mechanism.perfect:
            return locked_angle(mechanism, theta)
        rows, cell = mechanism.meetings, mechanism.cell_angle
        near = math.floor((theta - mechanism.breaks[0]) / cell)
        # the last engagement that has begun
        begun = [
            k for k in range(near - 1, near + 2)
            if k * cell + rows[k % len(rows)].late + rows[k % len(rows)].edges[0] <= theta
        ]  # fmt: skip
        k = max(begun, default=near - 1)
        row = rows[k % len(rows)]
        local = min(theta - k * cell - row.late, float(row.edges[-1]))
        return k * mechanism.follower_step + float(row.turned(np.array([local]))[0])

    def slot_angles(self) -> FloatArray:
        """Angles of the slots' centre lines while the follower is at zero, slot 0 first [rad].

        The follower turns with growing angles, so that the next slot to be met stands behind.
        """
        ahead = _each(self.mechanism.slot_angle_errors, self.mechanism.slots)
        return np.asarray(ahead - np.arange(ahead.size) * self.mechanism.follower_step)

    def slot_offsets(self) -> FloatArray:
        """How far each slot's centre line runs ahead of the axis."""
        unit = self.mechanism.crank_radius or 1.0
        return _each(self.mechanism.slot_offsets, self.mechanism.slots) / unit

    def _imperfect_edge(self) -> ComplexArray:
        """Closed edge of the follower with each slot in its own place, counter-clockwise."""
        half, rim, end = self.half_slot, self.rim_radius, self.slot_end
        turn = np.linspace(-0.5, 0.5, 25) * np.pi
        floor = end + half * (math.copysign(1.0, end - rim) * np.cos(turn) + 1j * np.sin(turn))
        angles, offsets = self.slot_angles()[::-1], self.slot_offsets()[::-1]
        slots, land, corner = [], self._land(), math.asin(half / rim)
        for angle, offset in zip(angles, offsets, strict=True):
            sides = np.array([offset - half, offset + half])
            mouth = np.sqrt(rim**2 - sides**2) + 1j * sides
            slots.append(np.concatenate([mouth[:1], floor + 1j * offset, mouth[1:]]))
            slots[-1] = slots[-1] * np.exp(1j * angle)
        pieces, turned = [], np.angle(land)
        for slot, following in zip(slots, [*slots[1:], slots[0]], strict=True):
            # the land between two slots is drawn out to reach from one to the other
            start, stop = np.angle(slot[-1]), np.angle(following[0] / slot[-1])
            share = (turned - corner) / (self.mechanism.follower_step - 2.0 * corner)
            bent = start + share * np.mod(stop, 2.0 * np.pi)
            pieces += [slot, np.abs(land) * np.exp(1j * bent)]
        return closed(np.concatenate(pieces))

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


def scaled_errors(mechanism: Geneva, factor: float) -> Geneva:
    """The wheel with all errors times a factor, or InvalidValue where it then could not turn."""
    factor = validate.number("exaggerate", factor, remedy := "give a factor, 1 for true scale")
    if factor < 0.0:
        raise validate.fail("exaggerate", "at least 0", factor, remedy)
    if factor == 1.0 and not mechanism.misfit:
        return mechanism
    given = {name: getattr(mechanism, name) for name in IMPERFECT}
    larger: dict[str, Any] = {
        name: tuple(factor * x for x in value) if isinstance(value, tuple) else factor * value
        for name, value in given.items()
    }
    found = replace(mechanism, **larger)
    if found.misfit and factor != 1.0:
        raise validate.fail("exaggerate", "small enough for pins to meet slots", factor, remedy)
    if found.misfit:
        raise InvalidValue(found.misfit)
    return found


def _each(errors: Sequence[float], count: int | None) -> FloatArray:
    """Errors of pins or slots, zeros where there are none."""
    return np.array(errors or (0.0,) * (count or 1), dtype=float)


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
