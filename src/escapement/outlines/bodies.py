"""Bodies of a mechanism: discs, and closed chains of lines and arcs."""

import cmath
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from escapement.mechanisms.kind import Wheel
from escapement.outlines.curves import ComplexArray, Curve, chain

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
    rim: float, slot_end: float, half_slot: float, land: Land | None, slots: int
) -> Curve:
    """Edge of a wheel with radial slots, slot 0 on the real axis.

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
        Corners between slot 0 and slot 1 without those at the mouths, and the angles by which the
        ways to, between and from them turn. Default: the mouths have their corners in common.
    slots : int
        Number of slots.
    """
    corner = rim * cmath.exp(1j * math.asin(half_slot / rim))
    # the round end is beyond the slot, seen from the mouth
    away = math.copysign(1.0, slot_end - rim)
    end = complex(slot_end, half_slot)
    corners, turns = [corner.conjugate(), end.conjugate(), end], [0.0, away * math.pi, 0.0]
    if land is not None:
        corners, turns = [*corners, corner, *land[0]], [*turns, *land[1]]
    places = np.exp(2j * np.pi * np.arange(slots) / slots)
    edge = chain((places[:, None] * np.array(corners)).ravel(), np.tile(turns, slots))
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
