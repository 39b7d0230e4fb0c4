"""The Geneva wheel, external or internal, with as many pins as fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, ClassVar

from escapement.base import validate
from escapement.base.quantity import Truth, quantity, setting
from escapement.mechanisms.imperfect import ImperfectWheel, centre_distance_error, each
from escapement.mechanisms.kind import WHEEL, Arms, clearance, pin_radius, roller_radius
from escapement.mechanisms.other_sizes import (
    OtherSize,
    crank_from_centre_distance,
    crank_from_wheel_diameter,
    crank_from_wheel_radius,
    other_size,
)

MOST_SLOTS = 1_000_000


@dataclass(frozen=True, repr=False)
class Geneva(ImperfectWheel):
    """Geneva wheel driven by pins on a crank, entering along the slots.

    Parameters
    ----------
    slots : int
        Slots n of the follower, from 3 to a million.
    pins : int, optional
        Equally spaced pins of the driver. Default: 2n/(n-2) where that is
        whole (3, 4 and 6 slots: continuous engagement, Meyer 1-3), else 1.
        At most floor(2n/(n-2)); an internal wheel has 1.
    internal : bool
        Slots open towards the follower's axis, driver inside.
    crank_radius : float, optional
        Distance of the pins from the driver's axis [m]; contact forces and all other lengths
        need it.
    pin_radius : float
        Radius of the pins [m].
    roller_radius : float
        Outer radius of rollers that turn on the pins and roll in the slots [m], 0 for none.
        Friction then acts between roller and pin.
    clearance : float
        Slot width minus pin diameter [m]. With it the pin crosses from wall to wall and strikes,
        see `escapement.engines.contact`; without it pins fit their slots exactly.
    centre_distance_error : float
        By how much the axes are too far apart [m]; negative where they are too close.
    pin_angle_errors, slot_angle_errors : sequence of float
        For each pin, by how much it crosses the line of centres late; for each slot, by how much
        it stands ahead in the direction of rotation [rad]. Pin 0 meets slot 0 first.
    crank_radius_errors, slot_offsets : sequence of float
        For each pin, by how much its crank is too long; for each slot, how far its line passes
        ahead of the follower's axis [m].

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.

    Source: Meyer (1973), eqs. 1-1 to 1-8; Filemon (1960), eqs. 2 and 3.
    """

    kind = "geneva"
    takes_clearance = True
    summary = "wheel with radial slots, pins on a crank"
    report_units: ClassVar[dict[str, str]] = {"centre_distance": "length"}
    reported = ("stations", *WHEEL)

    slots: int = field(metadata=quantity(
        "slots of the follower", whole=True, minimum=3, maximum=MOST_SLOTS, metavar="N",
        typical=4, remedy="a Geneva wheel has from 3 slots to some dozens"
    ))  # fmt: skip
    pins: int | None = field(default=None, metadata=quantity(
        "pins of the driver", whole=True, minimum=1, metavar="P",
        note=" (default: 1; geneva: the number with continuous engagement, if it exists)",
        remedy="give the number of crank pins"
    ))  # fmt: skip
    internal: bool = field(
        default=False, metadata=setting(Truth(long_name="internal wheel, driver inside"))
    )
    crank_radius: float | None = field(default=None, metadata=quantity(
        "crank radius, from the driver's axis to a pin", "length", exclusive=True, axis=False,
        remedy="give the crank radius"
    ))  # fmt: skip

    pin_radius: float = field(default=0.0, metadata=pin_radius())
    roller_radius: float = field(default=0.0, metadata=roller_radius())
    clearance: float = field(default=0.0, metadata=clearance())
    centre_distance_error: float = centre_distance_error("")
    pin_angle_errors: Sequence[float] = each("pin", "angle error", "angle")
    crank_radius_errors: Sequence[float] = each("pin", "error of the crank radius", "length")
    slot_angle_errors: Sequence[float] = each("slot", "angle error", "angle")
    slot_offsets: Sequence[float] = each("slot", "distance from the follower's axis", "length")

    def __post_init__(self) -> None:
        self.check_fields()
        n = self.slots
        most, rest = (1, 0) if self.internal else divmod(2 * n, n - 2)
        # a study over the slots keeps the number of pins only if it was given
        vars(self)["given"] = () if self.pins is None else ("pins",)
        if self.pins is None:
            vars(self)["pins"] = 1 if rest else most
        elif self.pins > most:
            kind = "an internal wheel" if self.internal else f"{n} slots"
            raise validate.fail(
                "pins", f"at most {most} for {kind}", self.pins, "fewer pins, or leave it out"
            )
        self.check_pin()
        self.check_errors()

    @classmethod
    @cache
    def other_sizes(cls) -> dict[str, OtherSize]:
        """Diameters, the distance of the axes, and the radius or diameter of the rim."""
        reads = ("slots", "pin_radius", "roller_radius", "clearance")
        rows = (
            ("centre_distance", "distance of the axes", crank_from_centre_distance, reads[:1]),
            ("wheel_radius", "radius of the follower's rim", crank_from_wheel_radius, reads),
            ("wheel_diameter", "diameter of the follower's rim", crank_from_wheel_diameter, reads),
        )
        found = super().other_sizes()
        for name, text, convert, needed in rows:
            found = found | other_size(name, text, "crank_radius", convert, needed)
        return found

    @property
    def centre_distance(self) -> float:
        """Distance of the axes in crank radii, 1/sin(pi/n) (Meyer 1-2)."""
        return 1.0 / math.sin(math.pi / self.slots)

    @property
    def cell_angle(self) -> float:
        """Driver angle from one pin's entry to the next one's [rad]."""
        return 2.0 * math.pi / self.pins  # type: ignore[operator]

    @property
    def motion_ratio(self) -> float:
        """Share of the cell in which the follower moves [-]; exactly 1 for continuous
        engagement."""
        more = 2 if self.internal else -2
        return self.pins * (self.slots + more) / (2 * self.slots)  # type: ignore[operator]

    @property
    def engagement_angle(self) -> float:
        """Driver angle over which one pin moves the follower [rad]."""
        if self.continuous:
            return self.cell_angle
        return math.pi + (self.follower_step if self.internal else -self.follower_step)

    @property
    def stations(self) -> int:
        """Stops in a turn of the follower, one for each slot."""
        return self.slots

    @property
    def arms(self) -> Arms:
        """Line of centres and crank, in crank radii: the follower turns about the origin."""
        crank = 1.0 if self.internal else -1.0
        return Arms(self.centre_distance, 0.0, crank, crank)

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI; the centre distance with its error."""
        apart = self.centre_distance + self.centre_distance_error / (self.crank_radius or 1.0)
        record = super().report() | {"centre_distance_over_crank_radius": apart}
        if self.crank_radius is not None:
            record["centre_distance"] = apart * self.crank_radius
        return record
