"""The cell of 90 degrees in which Meyer's program ran every wheel, as a mechanism."""

import math
from dataclasses import dataclass
from functools import cached_property

from numpy.typing import ArrayLike

from escapement import validate
from escapement.mechanisms import Geneva
from escapement.model import FloatArray
from escapement.scene import Path

_SLOTS = (3, 4, 6)


@dataclass(frozen=True)
class PublishedCell:
    """A Geneva wheel in the 90-degree cell Meyer's listing gives all of them.

    The pin enters where it should, at -pi/pins, and is replaced by the next one
    90 degrees later, wherever the follower then is. Only for 4 slots is that a
    mechanism. With 3 slots the pin stays past its exit and the transmission
    turns negative; with 6 slots it leaves early; in both the transmission jumps
    at the handoff while the driver's speed does not, so energy jumps there.

    Parameters
    ----------
    slots : int
        3, 4 or 6.

    Source: Meyer (1973), Appendix B, card X.
    """

    slots: int

    def __post_init__(self) -> None:
        if self.slots not in _SLOTS:
            raise validate.fail("slots", "3, 4 or 6", self.slots, "use Geneva for other wheels")

    @cached_property
    def geneva(self) -> Geneva:
        """The real mechanism."""
        return Geneva(self.slots)

    @property
    def cell_angle(self) -> float:
        """90 degrees [rad]."""
        return math.pi / 2.0

    @property
    def breaks(self) -> tuple[float, float, float]:
        """Pin entry, dead centre and end of the cell [rad]."""
        entry = self.geneva.breaks[0]
        return entry, 0.0, entry + self.cell_angle

    @property
    def follower_step(self) -> float:
        """Net turn of the follower over the cell [rad]."""
        # the pin neither enters nor leaves where this cell ends, except with 4 slots
        start, end = self.follower_angle([self.breaks[0], self.breaks[-1]])
        return float(end - start)

    @property
    def path(self) -> Path:
        """The pin path, as kernels evaluate it."""
        return self.geneva.path

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle [rad], zero at dead centre (Meyer 1-6)."""
        return self.geneva.follower_angle(theta)
