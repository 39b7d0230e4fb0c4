"""Outlines: the bodies of a mechanism as closed curves, for drawings and checks.

Points are complex numbers x + iy, in the unit of length that each outline names.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from escapement.mechanisms.kind import Wheel

ComplexArray = NDArray[np.complex128]


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
        What the body is called, for example "follower".
    edges : tuple of arrays, each of shape (points,)
        Curves that end where they start. A hole runs the other way round than what it is
        cut out of.
    """

    name: str
    edges: tuple[ComplexArray, ...]

    def turned(self, angle: float, about: complex = 0.0) -> "Body":
        """The body after its own origin was put at `about` and it was turned by `angle` [rad]."""
        turn = np.exp(1j * angle)
        return Body(self.name, tuple(about + edge * turn for edge in self.edges))


def arc(radius: float, start: float, stop: float, points: int = 361) -> ComplexArray:
    """Points of a circle about the origin, from angle to angle [rad]; clockwise if falling."""
    return np.asarray(radius * np.exp(1j * np.linspace(start, stop, points)))


def slotted_edge(
    rim: float, slot_end: float, half_slot: float, points: int, land: ComplexArray, slots: int
) -> ComplexArray:
    """Closed edge of a wheel with radial slots, counter-clockwise; slot 0 on the real axis.

    Parameters
    ----------
    rim : float
        Distance of the corners at the slots' mouths from the axis.
    slot_end : float
        Distance at which the slots end: where their round ends have their centres.
    half_slot : float
        Half the width of a slot.
    points : int
        Points of the round end of a slot.
    land : ndarray
        Points between slot 0 and slot 1, without the corners.
    slots : int
        Number of slots.
    """
    corner = rim * np.exp(1j * math.asin(half_slot / rim))
    turn = np.linspace(-0.5, 0.5, points) * np.pi
    # the round end is beyond the slot, seen from the mouth
    away = math.copysign(1.0, slot_end - rim)
    end = slot_end + half_slot * (away * np.cos(turn) + 1j * np.sin(turn))
    sector = np.concatenate([[corner.conjugate()], end, [corner], land])
    turns = np.exp(2j * np.pi * np.arange(slots) / slots)
    return closed((turns[:, None] * sector).ravel())


def pins_and_rollers(mechanism: Wheel, places: Iterable[complex], radius: float) -> list[Disc]:
    """Every "pin-k" at its place, and "roller-k" about it where pins have rollers.

    radius : of what touches the slot, in the unit of the places.
    """
    found = []
    for k, place in enumerate(places):
        inner = radius
        if mechanism.roller_radius:
            found.append(Disc(f"roller-{k}", place, radius))
            inner *= mechanism.pin_radius / mechanism.roller_radius
        found.append(Disc(f"pin-{k}", place, inner))
    return found


def closed(edge: ComplexArray) -> ComplexArray:
    """A curve that ends where it starts."""
    return np.append(edge, edge[0])


def locked_angle(mechanism: Wheel, theta: float) -> float:
    """Follower angle [rad] at any driver angle from a pin's dead centre.

    It counts on through engagements, and stands still between the exit of one pin and the
    entry of the next.
    """
    entry, leaving = mechanism.breaks[0], mechanism.breaks[-1]
    engagement = math.floor((theta - entry) / mechanism.cell_angle)
    local = min(theta - engagement * mechanism.cell_angle, leaving)
    return float(engagement * mechanism.follower_step + mechanism.follower_angle(local))
