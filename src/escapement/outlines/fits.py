"""How parts are to be made: allowances, shafts and the width of a cut."""

import math
from dataclasses import dataclass, field
from typing import Any

from escapement.base.quantity import Declared, quantity


def _length(text: str, least: float = -math.inf, note: str = "") -> dict[str, Any]:
    return quantity(text, "length", minimum=least, note=note, remedy="give the length, 0 for none")


@dataclass(frozen=True, repr=False)
class Fits(Declared):
    """Numbers that a workshop needs in addition to the mechanism.

    Parameters
    ----------
    pin_fit, shaft_fit : float
        Diameter of the holes minus that of pins and shafts [m]; negative for a press fit.
    driver_shaft_radius, follower_shaft_radius : float
        Radii of the shafts [m]; 0 for one that suits the wheel.
    locking_radius : float
        Radius of the locking arcs of a `Geneva` with a dwell [m]; 0 for one that suits the wheel.
    clearance : float
        Slot width minus pin diameter of a gear-driven wheel [m]; a `Geneva` has its own
        clearance. Of a planetary drive with elliptical gears the backlash of their teeth.
    teeth : int
        Teeth of each elliptical gear; 0 for the fewest odd number that a rack does not undercut.
    kerf : float
        Width of the cut [m]: the path of the cutter is offset from the edges by half of it.
    """

    pin_fit: float = field(default=0.0, metadata=_length("diameter of pin holes minus pins'"))
    shaft_fit: float = field(default=0.0, metadata=_length("diameter of shaft holes minus shafts'"))
    driver_shaft_radius: float = field(default=0.0, metadata=_length(
        "radius of the driver's shaft", 0.0, ", 0 for one that suits the wheel"
    ))  # fmt: skip
    follower_shaft_radius: float = field(default=0.0, metadata=_length(
        "radius of the follower's shaft", 0.0, ", 0 for one that suits the wheel"
    ))  # fmt: skip
    locking_radius: float = field(default=0.0, metadata=_length(
        "geneva: radius of the locking arcs", 0.0, ", 0 for one that suits the wheel"
    ))  # fmt: skip
    clearance: float = field(default=0.0, metadata=_length("slot width minus pin diameter", 0.0))
    teeth: int = field(default=0, metadata=quantity(
        "elliptical-planetary: teeth of each elliptical gear", whole=True, minimum=0, maximum=500,
        metavar="Z", note=", 0 for the fewest odd number that is not undercut",
        remedy="give a whole number",
    ))  # fmt: skip
    kerf: float = field(default=0.0, metadata=_length("width of the cut", 0.0))

    def __post_init__(self) -> None:
        self.check_fields()
