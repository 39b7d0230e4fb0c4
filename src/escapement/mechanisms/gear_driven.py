"""The gear-driven Geneva wheel: a pin on a planet traces a cycloid, coaxial with the wheel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar, Self

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Choice, quantity, setting
from escapement.mechanisms import gear_equation
from escapement.mechanisms.gear_equation import COGNATES, CURVES, MOST_LOBES
from escapement.mechanisms.imperfect import ImperfectWheel, centre_distance_error, each
from escapement.mechanisms.kind import (
    WHEEL,
    Arms,
    ArrayLike,
    np,
    pin_radius,
    roller_radius,
    slotted,
)
from escapement.mechanisms.path import Path
from escapement.mechanisms.protocol import FloatArray

_SIZELESS: dict[str, Any] = {
    "fixed_radius": None, "pin_radius": 0.0, "roller_radius": 0.0, "centre_distance_error": 0.0,
    "slot_offsets": (),
}  # fmt: skip
_LENGTHS = ("carrier", "arm", "entry_radius", "closest_radius")


@dataclass(frozen=True, repr=False)
class GearDriven(ImperfectWheel):
    """Geneva wheel driven by pins on a planet that rolls in or on a fixed gear.

    Parameters
    ----------
    stations : int
        Stations n, >= 3: the wheel turns by 2 pi/n at each step.
    lobes : int, Fraction, float or str
        Number m of further lobes that would fit between two neighbouring lobes of the pin's path
        [-], rational, 0 to 100 000, its denominator at most 1000: 2, 1/2 or "1/2". A float within
        1e-12 (1 + m) of such a number is that number.
    curve : str
        "hypocycloid" (protracted, k > 2), "epicycloid" (k < 0), or the cognates
        that trace the same paths: "contracted-hypocycloid" (1 < k < 2) and
        "pericycloid" (0 < k < 1).
    pins : int
        Equally spaced pins on the planet. With pins * V0 = 1 one is always engaged.
    unused_lobes : int
        Lobes without a slot between two lobes with one, at most 100 000; they give fewer slots
        and a longer dwell.
    solution : int
        Number of the mechanism, counted from 1 in order of alpha, if there are several.
    fixed_radius : float, optional
        Radius R0 of the fixed gear [m]; contact forces and all other lengths need it.
    pin_radius, roller_radius : float
        As in `Geneva` [m].
    centre_distance_error : float
        By how much the axes of planet and fixed gear are too far apart, which is the error of
        the carrier's length [m]; negative where they are too close.
    slot_offsets : sequence of float
        For each slot, in the order in which pins meet them, how far its line passes ahead of the
        wheel's axis in the direction in which the wheel turns [m].

    Raises
    ------
    InvalidValue
        When no such mechanism exists.

    Notes
    -----
    The driver is the carrier. One pin is engaged over alpha, and again after
    2 pi/|k| for the next lobe. From equation (8) g has one sign over an engagement:
    (g, u) runs monotonically along a circle from dead centre to g = 0 at the exit,
    so no such wheel ever turns back.

    Source: Dijksman (1974), eqs. 1 to 16.
    """

    kind = "gear-driven"
    plain_crank = False
    summary = "wheel with radial slots, pins on a planet gear (Dijksman)"
    report_units: ClassVar[dict[str, str]] = dict.fromkeys(("planet_radius", *_LENGTHS), "length")
    reported = (
        *("stations", *WHEEL, "gear_ratio", "alpha_deg"),
        *(f"{name}_over_fixed" for name in _LENGTHS),
        "turns_with_driver",
    )

    stations: int = field(metadata=quantity(
        "stations of the follower", whole=True, minimum=3, metavar="N",
        remedy="the wheel needs 3 stations or more"
    ))  # fmt: skip
    lobes: Any = field(metadata=quantity(
        "further lobes that would fit between two lobes of the path", fraction=True, metavar="M",
        maximum=MOST_LOBES, note=", a whole number or a fraction",
        remedy="give a whole number or a fraction such as '1/2'"
    ))  # fmt: skip
    curve: str = field(default=CURVES[0], metadata=setting(
        Choice(long_name=f"pin's path: {', '.join(CURVES)}", allowed=CURVES, metavar="NAME",
        required=True)
    ))  # fmt: skip
    pins: int = field(default=1, metadata=quantity(
        "pins on the planet", whole=True, minimum=1, metavar="P", remedy="give the number of pins"
    ))  # fmt: skip
    unused_lobes: int = field(default=0, metadata=quantity(
        "lobes without a slot between two lobes with a slot", whole=True, maximum=MOST_LOBES,
        metavar="J", remedy="give 0 to use every lobe"
    ))  # fmt: skip
    solution: int = field(default=1, metadata=quantity(
        "place of the mechanism in order of alpha", whole=True, minimum=1, metavar="I",
        note=", if there are several", remedy="they count from 1"
    ))  # fmt: skip
    fixed_radius: float | None = field(default=None, metadata=quantity(
        "radius of the fixed gear", "length", exclusive=True, axis=False,
        remedy="give the radius of the fixed gear"
    ))  # fmt: skip

    pin_radius: float = field(default=0.0, metadata=pin_radius())
    roller_radius: float = field(default=0.0, metadata=roller_radius())
    centre_distance_error: float = centre_distance_error(" of planet and fixed gear")
    slot_offsets: Sequence[float] = each("slot", "distance from the wheel's axis", "length")

    def __post_init__(self) -> None:
        self.check_fields()
        count = len(self._ratios)
        if not count:
            _ = self.gear_ratio  # this refuses too many lobes with a message of its own
            raise InvalidValue(
                f"no mechanism corresponds to stations {self.stations}, lobes {self.lobes} and "
                f"curve {self.curve!r}: equation (8) has no root with alpha <= pi - gamma and "
                "V0 <= 1; choose another number of lobes"
            )
        if self.solution > count:
            raise validate.fail("solution", f"at most {count} here", self.solution, "leave it out")
        most = math.floor(1.0 / self.lobe_ratio * (1.0 + 1e-12))
        if self.pins > most:
            rule = f"at most {most}, as each drives for a share {self.lobe_ratio:.6g} of a cycle"
            remedy = f"give {most}{' or fewer' if most > 1 else ''}, or two will be engaged at once"
            raise validate.fail("pins", rule, self.pins, remedy)
        self._check_unused_lobes()
        self.check_pin()
        self.check_errors()

    def _check_unused_lobes(self) -> None:
        if self.through_centre and self.unused_lobes:
            rule = "0 for a path through the wheel's centre"
            remedy = "the wheel turns uniformly and would start and stop with a jump"
            raise validate.fail("unused_lobes", rule, self.unused_lobes, remedy)
        # in the locked wheel's frame an unused lobe sweeps the angle of one station
        slots = self.slots
        for lobe in range(1, self.unused_lobes + 1):
            first, last = sorted((lobe * self._lobe_turn, lobe * self._lobe_turn - self._step_turn))
            if math.floor(last * slots) >= math.ceil(first * slots):
                raise InvalidValue(
                    "unused_lobes must let the pin pass between slots at its unused lobes, got "
                    f"{self.unused_lobes}: one of the {slots} slots that this needs is where "
                    f"lobe {lobe} passes; choose another number"
                )

    @property
    def _lobe_turn(self) -> Fraction:
        """Turns of the carrier until the next pin passes along the same path."""
        return 1 / (self.pins * abs(self.gear_ratio))

    @property
    def _step_turn(self) -> Fraction:
        """Turns of the wheel at a step, positive with the carrier.

        A wheel that turns by 1 - 1/n through its centre is left in the same position.
        """
        return Fraction(1 if self.curve == "contracted-hypocycloid" else -1, self.stations)

    @cached_property
    def gear_ratio(self) -> Fraction:
        """k = R0/R, fixed gear over planet, negative on the outside (12a-d) [-]."""
        return gear_equation.gear_ratio(self.stations, self.lobes, self.curve)

    @cached_property
    def _ratios(self) -> list[float]:
        """V0 of this mechanism and the other solutions, in order of alpha."""
        return gear_equation.lobe_ratios(self.stations, self.lobes, self.curve)

    @property
    def lobe_ratio(self) -> float:
        """Ratio of times V0 with one pin and every lobe used (9) [-]."""
        return self._ratios[self.solution - 1]

    @property
    def alpha(self) -> float:
        """Driver angle over which one pin moves the wheel (8) [rad]."""
        return 2.0 * math.pi * self.lobe_ratio / abs(float(self.gear_ratio))

    engagement_angle = alpha

    @property
    def through_centre(self) -> bool:
        """Whether the pin passes through the wheel's centre: V0 = 1, wheel in uniform motion."""
        return self.lobe_ratio == 1.0

    @cached_property
    def arms(self) -> Arms:
        """Carrier and the planet's arm, in radii of the fixed gear."""
        source = self.curve if self.curve in CURVES[:2] else COGNATES[self.curve]
        k = float(gear_equation.gear_ratio(self.stations, self.lobes, source))
        alpha = 2.0 * math.pi * self.lobe_ratio / abs(k)
        carrier = arm = 1.0 - 1.0 / k
        if not self.through_centre:
            arm = gear_equation.arm_length(k, alpha, 2.0 * math.pi / self.stations)
        if source != self.curve:
            # the cognate's carrier is the other vector; its fixed gear has the radius k MC
            carrier, arm = 1.0 / k, carrier / (k * arm)
        return Arms(carrier, 1.0, arm, 1.0 - float(self.gear_ratio))

    @property
    def carrier_over_fixed(self) -> float:
        """Length of the carrier, |R0 - R|/R0 [-]."""
        return abs(self.arms.first)

    @property
    def arm_over_fixed(self) -> float:
        """Distance of the pins from the planet's axis, |MC|/R0 [-]."""
        return abs(self.arms.second)

    @property
    def entry_radius_over_fixed(self) -> float:
        """Distance M0C of a pin from the wheel's axis at entry, over R0 [-]."""
        return 0.0 if self.through_centre else float(self.radius(self.alpha / 2.0))

    @property
    def closest_radius_over_fixed(self) -> float:
        """Least distance of the whole pin path from the wheel's axis, over R0 [-]."""
        return abs(abs(self.arms.first) - abs(self.arms.second))

    @property
    def reach_over_fixed(self) -> float:
        """Radius of the circle that holds both gears and the pin path, over R0 [-]."""
        planet = abs(1.0 / float(self.gear_ratio))
        return max(1.0, self.carrier_over_fixed + max(self.arm_over_fixed, planet))

    @property
    def slots(self) -> int:
        """Slots g the wheel needs (16) [-]; unused lobes and more pins change it.

        They stand where pins enter, every (j + 1)/(p |k|) turns of the carrier less the
        wheel's step: n/gcd(n, m + 2) for one pin that uses every lobe.
        """
        return ((self.unused_lobes + 1) * self._lobe_turn - self._step_turn).denominator

    @property
    def cognate(self) -> Self:
        """The other mechanism with the same pin path; its carrier turns 1 - k times as far.

        It has no size: its fixed gear is k MC times as large as this one's R0. The paths of
        several pins are the same curve turned by 1/(p |k|) of a turn from pin to pin, which the
        cognate's k changes: it can need another number of slots.

        Raises
        ------
        InvalidValue
            If one of the cognate's slots is where an unused lobe passes.
        """
        return replace(self, curve=COGNATES[self.curve], **_SIZELESS)

    @property
    def crank_radius(self) -> float | None:
        """Unit of the arms [m], which contact forces need; None where it is unknown."""
        return self.fixed_radius

    @property
    def motion_ratio(self) -> float:
        """Ratio of times V, the moving share of the cell [-]."""
        return self.pins * self.lobe_ratio / (self.unused_lobes + 1)

    @property
    def cell_angle(self) -> float:
        """Driver angle from one engagement's entry to the next one's [rad]."""
        lobe = 2.0 * math.pi / abs(float(self.gear_ratio))
        return lobe * (self.unused_lobes + 1) / self.pins

    @property
    def turns_with_driver(self) -> bool:
        """Whether wheel and carrier turn the same way."""
        return self._forward > 0.0

    @property
    def follower_step(self) -> float:
        """Follower angle per cell [rad]: 2 pi/n.

        An epicycloid through the wheel's centre turns it by 2 pi - 2 pi/n instead.
        """
        return self._uniform * self.alpha if self.through_centre else super().follower_step

    @property
    def _uniform(self) -> float:
        """|g| of a path through the wheel's centre, |1 - k/2|."""
        return 0.5 * abs(self.arms.rate_1 + self.arms.rate_2)

    @cached_property
    def path(self) -> Path:
        """The pin path, as kernels evaluate it.

        Raises
        ------
        InvalidValue
            For a path through the wheel's centre: there the pin's sliding relative to its
            distance, and with it the effect of friction, is unbounded.
        """
        if self.through_centre:
            raise InvalidValue(
                f"stations {self.stations}, lobes {self.lobes}, curve {self.curve!r}, solution "
                f"{self.solution}: the pin passes through the wheel's centre, where sliding under "
                f"friction is singular; the wheel turns uniformly, g = {self._uniform:.6g}, and "
                "has no dynamics here; "
                "choose another number of lobes, or another solution"
            )
        return super().path

    def _engaged(self, theta: ArrayLike) -> slotted.Transmission:
        """As in `Wheel`; through the wheel's centre g is constant, and u infinite at the ends."""
        if not self.through_centre:
            return super()._engaged(theta)
        angles = np.asarray(theta, dtype=float)
        half = 0.5 * (self.arms.rate_1 - self.arms.rate_2)
        ends = -np.copysign(np.inf, half * angles)
        inside = np.abs(angles) < self.alpha / 2.0
        slide = np.where(inside, -half * np.tan(half * angles), ends)
        g = np.full_like(angles, self._uniform)
        return slotted.Transmission(g, slide, np.zeros_like(angles))

    def jerk(self, theta: ArrayLike) -> FloatArray:
        """As in `Wheel`."""
        return np.zeros(np.shape(theta)) if self.through_centre else super().jerk(theta)

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """As in `Wheel`."""
        if self.through_centre:
            return self._uniform * np.asarray(theta, dtype=float)
        return super().follower_angle(theta)

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI, and that of every other solution."""
        record = self._geometry()
        if self.fixed_radius is not None:
            record["planet_radius"] = self.fixed_radius / abs(float(self.gear_ratio))
            record |= {name: record[f"{name}_over_fixed"] * self.fixed_radius for name in _LENGTHS}
        numbers = range(1, len(self._ratios) + 1)
        return record | {"solutions": [self._with_solution(i)._geometry() for i in numbers]}

    def _with_solution(self, number: int) -> GearDriven:
        """Another solution with the same pins and lobes, or with one pin where these do not fit."""
        try:
            return replace(self, solution=number, **_SIZELESS)
        except InvalidValue:
            return replace(self, solution=number, pins=1, unused_lobes=0, **_SIZELESS)

    def _geometry(self) -> dict[str, Any]:
        """As `report`; the length of the carrier with its error."""
        longer = self.centre_distance_error / (self.fixed_radius or 1.0)
        given = {"gear_ratio": float(self.gear_ratio)}
        return super().report() | given | {"carrier_over_fixed": self.carrier_over_fixed + longer}
