"""The Geneva wheel, external or internal, with as many pins as fit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

from escapement import validate
from escapement.errors import InvalidValue
from escapement.fitting import IMPERFECT, check_lengths
from escapement.lazy import Lazy
from escapement.mechanisms.kind import WHEEL, Arms, Wheel, clearance, pin_radius, roller_radius
from escapement.quantity import Numbers, Truth, declared, quantity, setting
from escapement.scene import Meeting

MOST_SLOTS = 1_000_000
pattern: Any = Lazy("escapement.mechanisms.pattern")


def _each(part: str, error: str, unit: str = "ratio") -> Any:
    """Field with an error of each pin or slot."""
    remedy = f"give one number for each {part}, or leave it out"
    entry = Numbers(long_name=f"{error} of each {part}", unit=unit, remedy=remedy, metavar="X,X,..")
    return field(default=(), metadata=setting(entry))


@dataclass(frozen=True, repr=False)
class Geneva(Wheel):
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
        Friction is then that between roller and pin.
    clearance : float
        Slot width less pin diameter [m]. With it the pin goes from wall to wall in flights and
        blows, see `escapement.engines.contact`; without it pins fit their slots exactly.
    centre_distance_error : float
        By how much the axes are too far apart [m]; negative where they are too close.
    pin_angle_errors, slot_angle_errors : sequence of float
        Of each pin, by how much it crosses the line of centres late; of each slot, by how much
        it stands ahead in the sense of rotation [rad]. Pin 0 meets slot 0 first.
    crank_radius_errors, slot_offsets : sequence of float
        Of each pin, by how much its crank is too long; of each slot, how far its line runs
        ahead of the follower's axis [m].

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.

    Source: Meyer (1973), eqs. 1-1 to 1-8; Filemon (1960), eqs. 2 and 3.
    """

    kind = "geneva"
    summary = "wheel with radial slots, pins on a crank"
    report_units: ClassVar[dict[str, str]] = {"centre_distance": "length"}
    reported = ("stations", *WHEEL)

    slots: int = field(metadata=quantity(
        "slots of the follower", whole=True, minimum=3, maximum=MOST_SLOTS, metavar="N",
        typical=4, remedy="a Geneva wheel has from 3 slots to some dozens"
    ))  # fmt: skip
    pins: int | None = field(default=None, metadata=quantity(
        "pins of the driver", whole=True, minimum=1, metavar="P",
        note=" (default: 1; geneva, where it exists, continuous engagement)",
        remedy="give the number of crank pins"
    ))  # fmt: skip
    internal: bool = field(
        default=False, metadata=setting(Truth(long_name="internal wheel, driver inside"))
    )
    crank_radius: float | None = field(default=None, metadata=quantity(
        "distance of the pins from the driver's axis", "length", exclusive=True, axis=False,
        remedy="give the crank radius"
    ))  # fmt: skip

    pin_radius: float = field(default=0.0, metadata=pin_radius())
    roller_radius: float = field(default=0.0, metadata=roller_radius())
    clearance: float = field(default=0.0, metadata=clearance())
    centre_distance_error: float = field(default=0.0, metadata=quantity(
        "error of the centre distance", "length", minimum=-math.inf,
        note=", positive where it is too long", remedy="give the error, 0 for none"
    ))  # fmt: skip
    pin_angle_errors: Sequence[float] = _each("pin", "angle error [rad]")
    crank_radius_errors: Sequence[float] = _each("pin", "error of the crank radius", "length")
    slot_angle_errors: Sequence[float] = _each("slot", "angle error [rad]")
    slot_offsets: Sequence[float] = _each("slot", "distance from the follower's axis", "length")

    def __post_init__(self) -> None:
        self.check_fields()
        n = self.slots
        most, rest = (1, 0) if self.internal else divmod(2 * n, n - 2)
        # a study over the slots keeps a number of pins that was given, and no other
        vars(self)["given"] = () if self.pins is None else ("pins",)
        if self.pins is None:
            vars(self)["pins"] = 1 if rest else most
        elif self.pins > most:
            kind = "an internal wheel" if self.internal else f"{n} slots"
            raise validate.fail(
                "pins", f"at most {most} for {kind}", self.pins, "fewer pins, or leave it out"
            )
        self.check_pin()
        self._check_errors()

    def _check_errors(self) -> None:
        """Put tuples in the place of the errors of pins and slots; all zeros are none."""
        counts = {"pin": self.pins, "slot": self.slots}
        for name, entry in declared(Geneva).items():
            if not isinstance(entry, Numbers) or getattr(self, name) is entry.default:
                continue
            numbers = entry.read(name, getattr(self, name))
            part = name.partition("_")[0].replace("crank", "pin")
            if numbers and len(numbers) != counts[part]:
                rule = f"as long as there are {part}s, {counts[part]}"
                raise validate.fail(name, rule, len(numbers), entry.remedy)
            vars(self)[name] = numbers if any(numbers) else ()
        check_lengths(vars(self), self.crank_radius, self.plain_crank)

    @classmethod
    def counts(cls, given: Mapping[str, Any]) -> dict[str, int]:
        """How many errors of each kind a wheel has, by name; of numbers that make none, none."""
        numbers = {name: given[name] for name in ("slots", "pins", "internal") if name in given}
        try:
            wheel = cls(**numbers)
        except (TypeError, InvalidValue):
            return {}
        lists = [name for name, entry in declared(cls).items() if isinstance(entry, Numbers)]
        return {name: wheel.slots if name.startswith("slot") else wheel.pins for name in lists}  # type: ignore[misc]

    @cached_property
    def _laid_out(self) -> Any:
        """Its pattern and the first impossible engagement, as `pattern_of` gives them."""
        unit = self.crank_radius or 1.0
        none: Any = (0.0,)
        pins, slots = self.pins, self.slots
        return pattern.pattern_of(
            internal=self.internal,
            centre=self.centre_distance + self.centre_distance_error / unit,
            pin=(self.roller_radius or self.pin_radius) / unit,
            late=self.pin_angle_errors or none * pins,
            cranks=[1.0 + error / unit for error in self.crank_radius_errors or none * pins],
            ahead=self.slot_angle_errors or none * slots,
            offsets=[offset / unit for offset in self.slot_offsets or none * slots],
        )

    @cached_property
    def perfect(self) -> bool:
        """Whether it has no error."""
        return not any(getattr(self, name) for name in IMPERFECT)

    @property
    def pattern(self) -> Any:
        """The engagements after which pins and slots meet again, as `pattern_of` gives them."""
        return self._laid_out[0]

    @property
    def meetings(self) -> tuple[Meeting, ...]:
        """The engagements of its pattern."""
        return pattern.meetings_of(self.pattern)  # type: ignore[no-any-return]

    @cached_property
    def misfit(self) -> str:
        """Which pin cannot drive which slot, and where; "" where all can."""
        k = -1 if self.perfect else self._laid_out[1]
        if k < 0:
            return ""
        return (
            f"pin {k % self.pins} cannot drive slot {k % self.slots}, which it meets "  # type: ignore[operator]
            f"{math.degrees(k * self.cell_angle):.6g} degrees behind the first dead centre: the "
            "errors of the parts are too large; make them smaller"
        )

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
        """Moving share of the cell [-]; exactly 1 for continuous engagement."""
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
        """Stops in a turn of the follower, one a slot."""
        return self.slots

    @property
    def arms(self) -> Arms:
        """Line of centres and crank, in crank radii: the follower turns about the origin."""
        crank = 1.0 if self.internal else -1.0
        return Arms(self.centre_distance, 0.0, crank, crank)

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI."""
        record = super().report() | {"centre_distance_over_crank_radius": self.centre_distance}
        if self.crank_radius is not None:
            record["centre_distance"] = self.centre_distance * self.crank_radius
        return record
