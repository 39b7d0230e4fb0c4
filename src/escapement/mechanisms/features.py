"""What one body can touch another with: the lines, arcs and corners of its outline.

Source: the formulation of two bodies with outlines in docs/theory.md.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LINE = 0
CONVEX = 1
HOLLOW = -1


class Features(NamedTuple):
    """The features of one body in its own frame, of one sector of a body that repeats.

    Shapes: six arrays of shape ``(n,)``. Lengths are in units of the mechanism's unit of length,
    angles in rad, counterclockwise.

    Attributes:
        kind: ``LINE``, ``CONVEX`` (an arc with the material inside; a corner is one of radius
            zero, a pin one of half width pi) or ``HOLLOW`` (an arc with the material outside).
        x, y: The start of a line, which has the material on its left; the centre of an arc.
        direction: The direction of a line; of an arc, the direction of its middle from its
            centre.
        extent: The length of a line; of an arc, half of the angle that it spans.
        radius: The radius of an arc; zero of a line.
        fold: How many times the sector repeats in a turn.
    """

    kind: NDArray[np.int64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    direction: NDArray[np.float64]
    extent: NDArray[np.float64]
    radius: NDArray[np.float64]
    fold: int
