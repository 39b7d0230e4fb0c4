"""Bodies of a mechanism: discs, and closed chains of lines and arcs."""

import cmath
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.mechanisms.kind import Wheel
from escapement.outlines.curves import ComplexArray, Curve, FloatArray, chain

Land = tuple[list[complex], list[float]]


class Disc(NamedTuple):
    """A round body, or the pitch circle of a gear."""

    name: str
    centre: complex
    radius: float


class Body(NamedTuple):
    """A body that lies between closed curves.

    Attributes
    ----------
    name : str
        Name of the body, for example "follower".
    edges : tuple of Curve
        Curves with the body on their left: a hole runs the other way round.
    """

    name: str
    edges: tuple[Curve, ...]

    def rotated(self, angle: float, about: complex = 0.0) -> "Body":
        """The body with its own origin moved to `about`, and turned by `angle` [rad]."""
        turn = cmath.exp(1j * angle)
        return Body(self.name, tuple(edge.moved(turn, about) for edge in self.edges))


def arc(radius: float, start: float, stop: float, points: int = 361) -> ComplexArray:
    """Points of a circle about the origin, from angle to angle [rad]; clockwise if falling."""
    return np.asarray(radius * np.exp(1j * np.linspace(start, stop, points)))


def slotted_edge(
    rim: float,
    slot_end: float,
    half_slot: float,
    land: Land | None,
    angles: FloatArray,
    offsets: ArrayLike = 0.0,
) -> Curve:
    """Edge of a wheel with slots, each in its own place.

    Parameters
    ----------
    rim : float
        Distance of the corners at the slots' mouths from the axis.
    slot_end : float
        Distance at which the slots end: where their round ends have their centres. Beyond the
        rim it makes a ring, whose slots open inwards.
    half_slot : float
        Half the width of a slot.
    land : tuple of two lists, optional
        Corners between slot 0 and the next one of a perfect wheel without those at the mouths,
        and the angles by which the ways to, between and from them turn. Default: the mouths have
        their corners in common.
    angles : ndarray, shape (slots,)
        Direction of each slot [rad], falling from slot 0 on.
    offsets : array_like, shape (slots,)
        How far the line of each slot runs ahead of the axis.
    """
    corner, away = math.asin(half_slot / rim), math.copysign(math.pi, slot_end - rim)
    pitch = 2.0 * math.pi / angles.size - 2.0 * corner
    ahead = np.broadcast_to(offsets, angles.shape)[::-1, None]
    sides = ahead + half_slot * np.array([-1.0, -1.0, 1.0, 1.0])
    along = np.sqrt(rim**2 - sides**2)
    along[:, 1:3] = slot_end
    slots = (along + 1j * sides) * np.exp(1j * angles[::-1])[:, None]
    corners, turns = list[complex](), list[float]()
    for slot, following in zip(slots.tolist(), np.roll(slots, -1, 0).tolist(), strict=True):
        if land is None:
            corners, turns = corners + slot[:3], [*turns, 0.0, away, 0.0]
            continue
        # the land between two slots is drawn out to reach from one to the other
        whole = cmath.phase(following[0] / slot[-1]) % (2.0 * math.pi)
        shares = [(cmath.phase(z) - corner) / pitch for z in land[0]]
        turned = [slot[-1] / abs(slot[-1]) * cmath.exp(1j * share * whole) for share in shares]
        corners += slot + [abs(z) * turn for z, turn in zip(land[0], turned, strict=True)]
        rims = [shares[0] * whole, land[1][1], (1.0 - shares[1]) * whole] if shares else [whole]
        turns += [0.0, away, 0.0, *rims]
    edge = chain(corners, turns)
    # the round ends are beyond the slots, seen from the mouths
    return edge.reversed() if away > 0.0 else edge


def pins_and_rollers(mechanism: Wheel, places: Iterable[complex], radius: float) -> list[Disc]:
    """Every "pin-k" at its place, and "roller-k" about it where pins have rollers.

    radius : of the pin or roller that touches the slot, in the unit of the places.
    """
    found = []
    for k, place in enumerate(places):
        inner = radius
        if mechanism.roller_radius:
            found.append(Disc(f"roller-{k}", place, radius))
            inner *= mechanism.pin_radius / mechanism.roller_radius
        found.append(Disc(f"pin-{k}", place, inner))
    return found
