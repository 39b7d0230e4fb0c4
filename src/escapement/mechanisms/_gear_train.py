"""Which gears, pins and slots a gear-driven Geneva wheel has, and the path of its pin."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from escapement import validate
from escapement.errors import InvalidValue
from escapement.lazy import Lazy
from escapement.mechanisms.gear_equation import (
    COGNATES,
    CURVES,
    MOST_LOBES,
    arm_length,
    gear_ratio,
    lobe_ratios,
)
from escapement.mechanisms.kind import Wheel
from escapement.quantity import Choice, quantity, setting

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike

    from escapement.model import FloatArray
else:
    np = Lazy("numpy")


class Arms(NamedTuple):
    """Pin path C = first exp(i rate_1 theta) + second exp(i rate_2 theta).

    The first vector is the carrier (rate 1), the second the planet's arm; both in
    fixed-gear radii, with the sign they have at dead centre.
    """

    first: float
    rate_1: float
    second: float
    rate_2: float


@dataclass(frozen=True)
class GearTrain(Wheel):
    """A gear-driven wheel but for its motion; fields and errors as `GearDriven`."""

    stations: int = field(metadata=quantity(
        "stations of the follower", whole=True, minimum=3, metavar="N",
        remedy="the wheel needs 3 stations or more"
    ))  # fmt: skip
    lobes: Any = field(metadata=quantity(
        "unreal lobes between two lobes of the pin's path", fraction=True, metavar="M",
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
        "lobes without a slot between two that have one", whole=True, maximum=MOST_LOBES,
        metavar="J", remedy="give 0 to use every lobe"
    ))  # fmt: skip
    solution: int = field(default=1, metadata=quantity(
        "place of the mechanism in order of alpha", whole=True, minimum=1, metavar="I",
        note=", where there are several", remedy="they count from 1"
    ))  # fmt: skip
    fixed_radius: float | None = field(default=None, metadata=quantity(
        "radius of the fixed gear", "length", exclusive=True, axis=False,
        remedy="give the radius of the fixed gear"
    ))  # fmt: skip

    def __post_init__(self) -> None:
        self.check_fields()
        self._choose()
        self._check_pins()

    def _choose(self) -> None:
        found = lobe_ratios(self.stations, self.lobes, self.curve)
        if not found:
            raise InvalidValue(
                f"no mechanism corresponds to stations {self.stations}, lobes {self.lobes} and "
                f"curve {self.curve!r}: equation (8) has no root with alpha <= pi - gamma and "
                "V0 <= 1; choose another number of lobes"
            )
        if self.solution > len(found):
            raise validate.fail(
                "solution", f"at most {len(found)} here", self.solution, "leave it out"
            )

    def _check_pins(self) -> None:
        most = math.floor(1.0 / self.lobe_ratio * (1.0 + 1e-12))
        if self.pins > most:
            rule = f"at most {most} for a ratio of times of {self.lobe_ratio:.6g} a pin"
            remedy = f"give {most}{' or fewer' if most > 1 else ''}: two would be engaged at once"
            raise validate.fail("pins", rule, self.pins, remedy)
        if self.through_centre and self.unused_lobes:
            rule = "0 for a path through the wheel's centre"
            remedy = "the wheel turns uniformly and would start and stop with a jump"
            raise validate.fail("unused_lobes", rule, self.unused_lobes, remedy)
        # in the locked wheel's frame an unused lobe sweeps the angle of one station
        slots = self.slots
        for lobe in range(1, self.unused_lobes + 1):
            first, last = sorted((self._lobe_turn(lobe), self._slot_turn(lobe)))
            if math.floor(last * slots) >= math.ceil(first * slots):
                raise InvalidValue(
                    "unused_lobes must leave the pin without a slot until it is wanted, got "
                    f"{self.unused_lobes}: of the {slots} slots it then needs, one stands where "
                    f"lobe {lobe} passes; choose another number"
                )

    def _lobe_turn(self, lobes: int) -> Fraction:
        """Turns of the carrier until a pin passes in the same way this many lobes later."""
        return lobes / (self.pins * abs(self.gear_ratio))

    def _slot_turn(self, lobes: int) -> Fraction:
        """Turns of the wheel's frame from one slot to where a pin enters this many lobes later."""
        return self._lobe_turn(lobes) - self._step_turn

    @property
    def _step_turn(self) -> Fraction:
        """Turns of the wheel at a step, positive with the carrier.

        A wheel that turns by 1 - 1/n through its centre is left in the same position.
        """
        return Fraction(1 if self.curve == "contracted-hypocycloid" else -1, self.stations)

    @property
    def gear_ratio(self) -> Fraction:
        """k = R0/R, fixed gear over planet, negative on the outside (12a-d) [-]."""
        return gear_ratio(self.stations, self.lobes, self.curve)

    @cached_property
    def lobe_ratio(self) -> float:
        """Ratio of times V0 with one pin and every lobe used (9) [-]."""
        return lobe_ratios(self.stations, self.lobes, self.curve)[self.solution - 1]

    @property
    def alpha(self) -> float:
        """Driver angle over which one pin moves the wheel (8) [rad]."""
        return 2.0 * math.pi * self.lobe_ratio / abs(float(self.gear_ratio))

    @property
    def through_centre(self) -> bool:
        """Whether the pin passes through the wheel's centre: V0 = 1, wheel in uniform motion."""
        return self.lobe_ratio == 1.0

    @cached_property
    def arms(self) -> Arms:
        """The two vectors of the pin's path, in radii of the fixed gear."""
        source = self if self.curve in CURVES[:2] else self._one_pin_cognate
        k, gamma = float(source.gear_ratio), 2.0 * math.pi / self.stations
        carrier, arm = 1.0 - 1.0 / k, arm_length(k, source.alpha, gamma)
        if self.through_centre:
            arm = carrier
        if source is self:
            return Arms(carrier, 1.0, arm, 1.0 - k)
        # the cognate's carrier is the other vector; its fixed gear has the radius k MC
        other = float(self.gear_ratio)
        return Arms(1.0 / k, 1.0, carrier / (k * arm), 1.0 - other)

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
        longest = self.carrier_over_fixed + max(self.arm_over_fixed, planet)
        return max(1.0, longest)

    @property
    def slots(self) -> int:
        """Slots g the wheel needs (16) [-]; unused lobes and more pins change it.

        They stand where pins enter, every (j + 1)/(p |k|) turns of the carrier less the
        wheel's step: n/gcd(n, m + 2) for one pin that uses every lobe.
        """
        return self._slot_turn(self.unused_lobes + 1).denominator

    @property
    def cognate(self) -> Self:
        """The other mechanism with the same pin path; its carrier turns 1 - k times as far.

        Without its size: its fixed gear is k MC as large as this one's R0. The paths of
        several pins are the same curve turned by 1/(p |k|) of a turn from pin to pin,
        which the cognate's k changes: it can need another number of slots.

        Raises
        ------
        InvalidValue
            Where one of the cognate's slots stands in the way of an unused lobe.
        """
        return replace(self, curve=COGNATES[self.curve], fixed_radius=None)

    @property
    def _one_pin_cognate(self) -> Self:
        """The cognate's gears, whether its slots leave room for unused lobes or not."""
        return replace(self, curve=COGNATES[self.curve], pins=1, unused_lobes=0)

    def radius(self, theta: ArrayLike) -> FloatArray:
        """Distance of the pin from the follower's axis, over R0 [-]."""
        first, rate_1, second, rate_2 = self.arms
        half = 0.5 * (rate_1 - rate_2) * np.asarray(theta, dtype=float)
        # hypot of the sum along and across the bisector keeps accuracy near the centre
        return np.hypot((first + second) * np.cos(half), (first - second) * np.sin(half))

    @property
    def crank_radius(self) -> float | None:
        """Unit of `radius` [m], which contact forces need; None where it is unknown."""
        return self.fixed_radius
