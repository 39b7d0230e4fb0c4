"""What an outline is made of: round bodies, and bodies with closed edges.

Points are complex numbers x + iy, in the unit of length that each outline names.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from escapement.mechanisms.kind import Wheel

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class Disc:
    """A round body, or the pitch circle of a gear."""

    name: str
    centre: complex
    radius: float


@dataclass(frozen=True)
class Body:
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


def circle_edge(radius: float) -> ComplexArray:
    """A circle about the origin, clockwise."""
    edge: ComplexArray = radius * np.exp(-1j * np.linspace(0.0, 2.0 * np.pi, 361))
    return edge


def locked_angle(mechanism: Wheel, theta: float) -> float:
    """Follower angle [rad] at any driver angle from a pin's dead centre.

    It counts on through engagements, and stands still between the exit of one pin and the
    entry of the next.
    """
    entry, leaving = mechanism.breaks[0], mechanism.breaks[-1]
    engagement = math.floor((theta - entry) / mechanism.cell_angle)
    local = min(theta - engagement * mechanism.cell_angle, leaving)
    turned = engagement * mechanism.follower_step + mechanism.follower_angle(local)
    return float(turned)
