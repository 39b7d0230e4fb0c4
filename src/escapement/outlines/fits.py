"""How parts are to be made: allowances, shafts and the width of a cut."""

import math
from dataclasses import dataclass, field
from typing import Any

from escapement.base import validate
from escapement.base.quantity import Choice, Declared, quantity, setting
from escapement.base.spoken import spoken_length


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
    bore : str
        Shape of the holes for shafts that turn with their part: "round", "D" or "square". A
        square shaft is as wide as its diameter. In parts that do not turn they are round.
    bore_flat : float
        Depth of the flat of a D [m]; 0 for a sixth of the diameter.
    dowel_radius : float
        Radius of two dowels that hold the locking disc on the driver of a `Geneva` [m]; 0 for
        none. They fit as pins do.
    washer_radius : float
        Outer radius of a washer that keeps the wheel of a `Geneva` on its pins [m]; 0 for none.
    screw_radius : float
        Radius of the screw holes of a base plate under a `Geneva`, and of its four feet [m]; 0
        for no base plate.
    coupon_step : float
        Step from size to size on a coupon that tests kerf and fits of a `Geneva` [m]; 0 for none.
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
    bore: str = field(default="round", metadata=setting(Choice(
        long_name="shape of bores for shafts", allowed=("round", "D", "square"),
        metavar="round|D|square",
    )))  # fmt: skip
    bore_flat: float = field(default=0.0, metadata=_length(
        "depth of the flat of a D bore", 0.0, ", 0 for a sixth of the diameter"
    ))  # fmt: skip
    dowel_radius: float = field(default=0.0, metadata=_length(
        "geneva: radius of two dowels through driver and locking disc", 0.0, ", 0 for none"
    ))  # fmt: skip
    washer_radius: float = field(default=0.0, metadata=_length(
        "geneva: radius of a washer on each pin", 0.0, ", 0 for none"
    ))  # fmt: skip
    screw_radius: float = field(default=0.0, metadata=_length(
        "geneva: radius of the screw holes of a base plate with four feet", 0.0, ", 0 for none"
    ))  # fmt: skip
    coupon_step: float = field(default=0.0, metadata=_length(
        "geneva: step of the sizes on a coupon that tests kerf and fits", 0.0, ", 0 for none"
    ))  # fmt: skip

    def __post_init__(self) -> None:
        self.check_fields()
        if self.bore_flat and self.bore != "D":
            rule = f"0 for a {self.bore} bore"
            raise validate.fail("bore_flat", rule, spoken_length(self.bore_flat), "choose D")
