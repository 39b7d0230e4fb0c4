"""Bodies of a Geneva drive in crank radii.

The kinematics need little more than points and lines, while pictures and parts need bodies. A
pin has the radius it was given, or one chosen here; other widths are chosen here so that no
two bodies collide in any position: slots end where the pin turns back, locking arcs stay
clear of slots, and the driver's locking disc has round hollows, which the turning wheel clears.
"""

import cmath
import math
from functools import lru_cache

import numpy as np

from escapement.mechanisms import Geneva
from escapement.outlines.bodies import Body, Disc, Land, pins_and_rollers, slotted_edge
from escapement.outlines.curves import ComplexArray, Curve, FloatArray, chain
from escapement.outlines.imperfect_edges import each, scaled_errors

_POSITIONS = 721  # positions of the wheel that are tried against the locking disc
_CHORD = math.radians(0.5)
_HOLLOWS = 400  # number of centres of hollows that are tried


class GenevaOutline:
    """Proportions and bodies of a Geneva drive.

    All lengths are in crank radii. The follower's axis is the origin, the driver's lies on
    the positive real axis, and so does slot 0 when the follower angle is zero.

    Parameters
    ----------
    mechanism : Geneva
        What to draw, with its errors.
    exaggerate : float
        Factor on its errors.
    lock_radius : float, optional
        Radius of the locking arcs. Default: beside each slot 0.1 of the wheel is left, or half
        of the material there.

    Attributes
    ----------
    mechanism, perfect : Geneva
        The wheel with these errors, and without any.
    side : float
        +1 where slots are entered outwards (internal), -1 inwards.
    centre : float
        Distance of the axes.
    slot_end : float
        Distance of a pin from the follower's axis at dead centre, for the pin that goes in
        farthest.
    pin_radius, half_slot : float
        Radius of a pin, or of the roller on it, and half the slot width: larger by half the
        clearance if a radius was given, otherwise by a little clearance.
    rim_radius : float
        Radius of the rim; a pin enters as its centre crosses the mouth.
    locks : bool
        Whether there are locking arcs: not without a dwell, nor if wide slots leave no space.
    lock_radius : float
        Radius of the locking arcs.
    gap : float
        Clearance between the locking disc and the wheel: the clearance of the slots, if they have
        one; at the hollows half of it.
    follower_radius, crank_disc_radius : float
        Outer radii of the follower and of the disc that carries the pins.
    driver_shaft, follower_shaft : float
        Radii of the shafts; 0 for the follower of an internal wheel, which is a ring.
    follower_edge : Curve
        Edge of the follower that faces the driver.
    plane : tuple
        The follower, and the bodies that move in its plane.
    """

    meshing = False

    def __init__(
        self, mechanism: Geneva, exaggerate: float = 1.0, lock_radius: float | None = None
    ) -> None:
        self.mechanism = scaled_errors(mechanism, exaggerate)
        self.perfect = scaled_errors(mechanism, 0.0)
        unit, internal = mechanism.crank_radius or 1.0, mechanism.internal
        centre, self.side = mechanism.centre_distance, 1.0 if internal else -1.0
        self.centre = centre + self.mechanism.centre_distance_error / unit
        self.cranks = 1.0 + each(self.mechanism.crank_radius_errors, mechanism.pins) / unit
        self.slot_end = self.centre + self.side * self.cranks.max()
        chosen = 0.08 if internal else min(0.08, 0.4 * self.slot_end)
        self.pin_radius = mechanism.contact_radius or chosen
        gap, given = mechanism.clearance / unit, mechanism.contact_radius
        self.half_slot = given + 0.5 * gap if given else 1.08 * chosen
        self.rim_radius, suited = _radii(mechanism, self.half_slot)
        self.lock_radius = suited if lock_radius is None else lock_radius
        room = self.lock_radius - abs(centre - self.rim_radius)
        self.locks = not mechanism.continuous and room > 0.0
        self.gap = min(gap or 0.02, 0.2 * abs(centre - self.rim_radius))
        ring = self.slot_end + self.half_slot + 0.18
        self.follower_radius = ring if internal else self.rim_radius
        self.crank_disc_radius = 1.0 + self.pin_radius + 0.07
        narrow = 0.5 * (centre - self.rim_radius)
        self.driver_shaft = 0.12 if internal else min(0.14, narrow)
        self.follower_shaft = 0.0 if internal else min(0.12, 0.5 * (self.slot_end - self.half_slot))
        # the driver's shaft ends behind an internal wheel
        beside = ("pin", "roller", "locking-disc", *(() if internal else ("driver-shaft",)))
        self.plane = "follower", beside
        self.follower_edge = slotted_edge(
            *(self.rim_radius, self.slot_end, self.half_slot, self._land()),
            *(self.slot_angles(), self.slot_offsets()),
        )

    def bodies(self, theta: float, phi: float | None = None) -> list[Body | Disc]:
        """Everything that is drawn, where it stands at a driver angle.

        The follower stands at its angle `phi` [rad], or where slots without clearance would hold
        it. "follower", "crank-disc", "driver-shaft" and "pin-k" with k counted from 0 are always
        there; "locking-disc" only with a dwell and space for it, "follower-shaft" only in an
        external wheel, "roller-k" only if pins have rollers.
        """
        centre, follower = self.centre, Body("follower", self.follower_edges)
        angle = float(self.mechanism.follower_angle(theta)) if phi is None else phi
        found: list[Body | Disc] = [follower.rotated(angle)]
        if edge := self.locking_edge:
            found.append(Body("locking-disc", (edge,)).rotated(self.side * theta, centre))
        found.append(Disc("crank-disc", centre, self.crank_disc_radius))
        found.append(Disc("driver-shaft", centre, self.driver_shaft))
        if self.follower_shaft:
            found.append(Disc("follower-shaft", 0.0, self.follower_shaft))
        return found + pins_and_rollers(self.mechanism, self.pin_centres(theta), self.pin_radius)

    def pin_centres(self, theta: float) -> ComplexArray:
        """Positions of the pins at a driver angle, shape (pins,)."""
        delays = each(self.mechanism.pin_angle_errors, self.mechanism.pins)
        angles = theta - delays - np.arange(delays.size) * self.mechanism.cell_angle
        return np.asarray(self.centre + self.side * self.cranks * np.exp(1j * self.side * angles))

    @property
    def follower_edges(self) -> tuple[Curve, ...]:
        """Edges of the follower: that which faces the driver, and the outer one of a ring."""
        ring = (Curve.circle(self.follower_radius),) if self.mechanism.internal else ()
        return self.follower_edge, *ring

    @property
    def locking_edge(self) -> Curve | None:
        """Edge of the locking disc, where there is one; see `locking_disc`."""
        return locking_disc(self.perfect, self.lock_radius) if self.locks else None

    def slot_angles(self) -> FloatArray:
        """Angles of the slots' centre lines while the follower is at zero, slot 0 first [rad].

        The follower turns with growing angles, so the next slot is behind.
        """
        leads = each(self.mechanism.slot_angle_errors, self.mechanism.slots)
        return np.asarray(leads - np.arange(leads.size) * self.mechanism.follower_step)

    def slot_offsets(self) -> FloatArray:
        """How far each slot's centre line runs ahead of the axis."""
        unit = self.mechanism.crank_radius or 1.0
        return each(self.mechanism.slot_offsets, self.mechanism.slots) / unit

    def _land(self) -> Land:
        """From slot 0 to slot 1: corners and turns, the corners at the mouths left out."""
        middle, rim = self.mechanism.follower_step / 2.0, self.rim_radius
        corner = math.asin(self.half_slot / rim)
        if not self.locks:
            return [], [2.0 * (middle - corner)]
        axis = self.mechanism.centre_distance
        horn = math.acos((rim**2 + axis**2 - self.lock_radius**2) / (2.0 * rim * axis))
        tip = rim * cmath.exp(1j * horn)
        wide = abs(cmath.phase(self.side * (tip - axis)))
        along, before = cmath.exp(1j * middle), middle - horn - corner
        return [tip.conjugate() * along, tip * along], [before, self.side * 2.0 * wide, before]


def _radii(mechanism: Geneva, half_slot: float) -> tuple[float, float]:
    """Radii of the rim and of the locking arcs."""
    wall = 1.0 - half_slot
    rim = math.hypot(mechanism.centre_distance * math.cos(math.pi / mechanism.slots), half_slot)
    return rim, wall - min(0.1, 0.5 * wall)


def sizes(mechanism: Geneva) -> dict[str, float]:
    """Sizes of the follower by name, in crank radii; for thin pins if no radius is known.

    "wheel_radius" of the rim, "slot_depth" from the rim to the round end's bottom, and, where it
    has them, "closest_radius" of a slot from the axis, and "locking_radius" of the locking arcs.
    """
    gap = mechanism.clearance / mechanism.crank_radius if mechanism.crank_radius else 0.0
    half = mechanism.contact_radius + 0.5 * gap
    rim, lock = _radii(mechanism, half)
    deepest = mechanism.centre_distance + (1.0 + half if mechanism.internal else -1.0 - half)
    found = {"wheel_radius": rim, "slot_depth": abs(rim - deepest)}
    if not mechanism.internal:
        found["closest_radius"] = deepest
    if not mechanism.continuous:
        found["locking_radius"] = lock
    return found


@lru_cache(maxsize=32)
def locking_disc(mechanism: Geneva, lock_radius: float | None = None) -> Curve | None:
    """Edge of the driver's locking disc about its axis, pin 0 at dead centre.

    An external wheel leaves a disc with a round hollow for each pin, an internal one a crescent
    opposite the pin; None where no locking arc is left between the hollows. Of all hollows with
    their centre on the line to the pin that clear the turning wheel, it is the one that leaves
    most of the locking arc. The arguments are those of `GenevaOutline`.
    """
    outline = GenevaOutline(mechanism, lock_radius=lock_radius)
    edge = outline.lock_radius - outline.gap
    swept = _swept(outline, edge + 0.5 * outline.gap)
    hub = 0.0 if mechanism.internal else outline.driver_shaft + outline.gap
    centres = np.geomspace(0.05, 20.0, _HOLLOWS)
    radii = np.array([np.abs(swept - centre).max() for centre in centres]) + 0.5 * outline.gap
    # a hollow meets the locking arc at this angle from the pin
    cosine = (edge**2 + centres**2 - radii**2) / (2.0 * edge * centres)
    allowed = (np.abs(cosine) < 1.0) & (mechanism.internal | (centres - radii > hub))
    if not allowed.any():
        return None
    best = int(np.argmax(np.where(allowed, cosine, -2.0)))
    centre, aside = float(centres[best]), math.acos(cosine[best])
    pins = mechanism.pins or 1
    left = 2.0 * (math.pi / pins - aside)
    if left <= 0.0:
        return None
    corner = edge * np.exp(1j * aside)
    hollow = -2.0 * float(np.angle((centre - corner).conjugate()))
    pin_centres = outline.side * np.exp(2j * np.pi * np.arange(pins) / pins)
    corners = pin_centres[:, None] * np.array([corner.conjugate(), corner])
    return chain(corners.ravel(), np.tile([hollow, left], pins))


def _swept(outline: GenevaOutline, radius: float) -> ComplexArray:
    """Points of the turning wheel within a radius about the driver's axis, the pin at 1.

    They are those of its edge, and where their paths enter that circle.
    """
    mechanism, centre = outline.mechanism, outline.mechanism.centre_distance
    edge = outline.follower_edge.drawn(_CHORD)
    # the others never come so close
    facing = np.abs(np.angle(edge)) < 1.5 * mechanism.follower_step
    edge = edge[facing & (np.abs(np.abs(edge) - centre) < radius)]
    theta = np.linspace(mechanism.breaks[0], mechanism.breaks[-1], _POSITIONS)[:, None]
    world = edge * np.exp(1j * mechanism.follower_angle(theta)) - centre
    points = outline.side * world * np.exp(-1j * outline.side * theta)
    off = np.abs(points) - radius
    inside = off <= 0.0
    row, column = np.nonzero(inside[1:] != inside[:-1])
    share = off[row, column] / (off[row, column] - off[row + 1, column])
    step = points[row + 1, column] - points[row, column]
    return np.concatenate([points[inside], points[row, column] + share * step])
