"""The gear-driven Geneva wheel: a pin on a planet traces a cycloid, coaxial with the wheel."""

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement import _validate
from escapement._curves import COGNATES, CURVES
from escapement.errors import InvalidValue
from escapement.mechanisms._slotted import Transmission, transmission, two_vector_path
from escapement.mechanisms.gear_equation import arm_length, gear_ratio, lobe_ratios
from escapement.model import FloatArray


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
class GearDriven:
    """Geneva wheel driven by pins on a planet that rolls in or on a fixed gear.

    Parameters
    ----------
    stations : int
        Stations n, >= 3: the wheel turns by 2 pi/n at each step.
    lobes : int, Fraction, float or str
        Unreal lobes m that fit between two neighbouring lobes of the pin's path
        [-], rational, >= 0: 2, 1/2 or "1/2".
    curve : str
        "hypocycloid" (protracted, k > 2), "epicycloid" (k < 0), or the cognates
        that trace the same paths: "contracted-hypocycloid" (1 < k < 2) and
        "pericycloid" (0 < k < 1).
    pins : int
        Equally spaced pins on the planet. With pins * V0 = 1 one is always engaged.
    unused_lobes : int
        Lobes that find no slot between two that do; fewer slots, longer dwell.
    solution : int
        Which mechanism, counted from 1 in order of alpha, where there are several.
    fixed_radius : float, optional
        Radius R0 of the fixed gear [m]; only contact forces need it.

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

    stations: int
    lobes: Any
    curve: str = CURVES[0]
    pins: int = 1
    unused_lobes: int = 0
    solution: int = 1
    fixed_radius: float | None = None

    def __post_init__(self) -> None:
        checked: dict[str, Any] = {
            "stations": _validate.integer(
                "stations", self.stations, 3, "the wheel needs 3 stations or more"
            ),
            "lobes": _validate.rational(
                "lobes", self.lobes, "give a whole number or a fraction such as 1/2"
            ),
            "curve": _validate.choice("curve", self.curve, CURVES),
            "pins": _validate.integer("pins", self.pins, 1, "give the number of pins"),
            "unused_lobes": _validate.integer(
                "unused_lobes", self.unused_lobes, 0, "give 0 to use every lobe"
            ),
            "solution": _validate.integer("solution", self.solution, 1, "they count from 1"),
        }
        if self.fixed_radius is not None:
            checked["fixed_radius"] = _validate.positive(
                "fixed_radius", self.fixed_radius, "give the radius of the fixed gear in m"
            )
        for name, value in checked.items():
            object.__setattr__(self, name, value)
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
            raise _validate.fail(
                "solution", f"at most {len(found)} here", self.solution, "leave it out"
            )

    def _check_pins(self) -> None:
        most = math.floor(1.0 / self.lobe_ratio * (1.0 + 1e-12))
        if self.pins > most:
            rule = f"at most {most} for a ratio of times of {self.lobe_ratio:.6g} a pin"
            raise _validate.fail("pins", rule, self.pins, "or two would be engaged at once")
        if self.through_centre and self.unused_lobes:
            rule = "0 for a path through the wheel's centre"
            remedy = "the wheel turns uniformly and would start and stop with a jump"
            raise _validate.fail("unused_lobes", rule, self.unused_lobes, remedy)
        # in the locked wheel's frame an unused lobe sweeps the angle of one station
        slots, station = self.slots, Fraction(1, self.stations)
        for lobe in range(1, self.unused_lobes + 1):
            last = self._slot_turn(lobe)
            if math.floor(last * slots) >= math.ceil((last - station) * slots):
                raise InvalidValue(
                    "unused_lobes must leave the pin without a slot until it is wanted, got "
                    f"{self.unused_lobes}: of the {slots} slots it then needs, one stands where "
                    f"lobe {lobe} passes; choose another number"
                )

    def _slot_turn(self, lobes: int) -> Fraction:
        """Turns of the wheel's frame from one slot to where a pin enters this many lobes later."""
        return (lobes * (self.lobes + 1) + self.pins) / Fraction(self.pins * self.stations)

    # ------------------------------------------------------------------ gears

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
        source = self if self.curve in CURVES[:2] else self.cognate
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
        """Slots g the wheel needs (16) [-]; unused lobes and more pins change it."""
        return self._slot_turn(self.unused_lobes + 1).denominator

    @property
    def cognate(self) -> "GearDriven":
        """The other mechanism with the same pin path; its carrier turns 1 - k times as far.

        Without its size: its fixed gear is k MC as large as this one's R0.
        """
        return GearDriven(
            self.stations,
            self.lobes,
            COGNATES[self.curve],
            self.pins,
            self.unused_lobes,
            self.solution,
        )

    # ----------------------------------------------------------------- motion

    @property
    def engagement_angle(self) -> float:
        """Driver angle over which one pin moves the follower, alpha [rad]."""
        return self.alpha

    @property
    def continuous(self) -> bool:
        """Whether a pin is always engaged: no dwell."""
        return self.motion_ratio > 1.0 - 1e-12

    @property
    def motion_ratio(self) -> float:
        """Ratio of times V, the moving share of the cell [-]."""
        return self.pins * self.lobe_ratio / (self.unused_lobes + 1)

    @property
    def cell_angle(self) -> float:
        """Driver angle from one engagement's entry to the next one's [rad]."""
        lobe = 2.0 * math.pi / abs(float(self.gear_ratio))
        return lobe * (self.unused_lobes + 1) / self.pins

    @cached_property
    def breaks(self) -> tuple[float, float, float]:
        """Pin entry, dead centre and pin exit [rad].

        A few roundings inside alpha where the computed g would else be below zero:
        a wheel at rest must not be taken for one that is pushed back.
        """
        half = self.alpha / 2.0
        if not self.through_centre:
            while float(transmission(self.path, half).g) < 0.0:
                half = math.nextafter(half, 0.0)
        return -half, 0.0, half

    @property
    def turns_with_driver(self) -> bool:
        """Whether wheel and carrier turn the same way."""
        if self.through_centre:
            return self.arms.rate_1 + self.arms.rate_2 > 0.0
        return self.curve == "contracted-hypocycloid"

    @property
    def follower_step(self) -> float:
        """Follower angle per cell [rad]: 2 pi/n.

        An epicycloid through the wheel's centre turns it by 2 pi - 2 pi/n instead.
        """
        if self.through_centre:
            return self._uniform * self.alpha
        return 2.0 * math.pi / self.stations

    @property
    def _uniform(self) -> float:
        """|g| of a path through the wheel's centre, |1 - k/2|."""
        return 0.5 * abs(self.arms.rate_1 + self.arms.rate_2)

    @property
    def _forward(self) -> float:
        return 1.0 if self.turns_with_driver else -1.0

    @cached_property
    def path(self) -> FloatArray:
        """Flat numbers of the pin path for the kernels.

        Raises
        ------
        InvalidValue
            For a path through the wheel's centre: the pin's sliding, relative to its
            distance, and the friction with it grow beyond all bounds there.
        """
        if self.through_centre:
            raise InvalidValue(
                f"stations {self.stations}, lobes {self.lobes}, curve {self.curve!r}: the pin "
                "passes through the wheel's centre, where sliding under friction is singular; "
                f"the wheel turns uniformly, g = {self._uniform:.6g}, and has no dynamics here; "
                "choose another number of lobes"
            )
        first, rate_1, second, rate_2 = self.arms
        return two_vector_path(first, rate_1, second, rate_2, self._forward)

    def transmission(self, theta: ArrayLike) -> Transmission:
        """Transmission at driver angles from dead centre [rad], pin engaged.

        Through the wheel's centre g is constant and u infinite at the ends.
        """
        if not self.through_centre:
            return transmission(self.path, theta)
        angles = np.asarray(theta, dtype=float)
        half = 0.5 * (self.arms.rate_1 - self.arms.rate_2)
        with np.errstate(divide="ignore"):
            slide = np.where(
                np.abs(angles) >= self.alpha / 2.0,
                -np.copysign(np.inf, half * angles),
                -half * np.tan(half * angles),
            )
        return Transmission(np.full_like(angles, self._uniform), slide, np.zeros_like(angles))

    def jerk(self, theta: ArrayLike) -> FloatArray:
        """g'' at driver angles from dead centre [rad], pin engaged [-].

        With q = C'/C: q' = a b + i (a + b) q - q^2 on a path of two vectors, and
        g'' is the derivative of g' = u (a + b - 2 g).
        """
        found = self.transmission(theta)
        if self.through_centre:
            return np.zeros_like(found.g)
        total = self._forward * (self.arms.rate_1 + self.arms.rate_2)
        product = self.arms.rate_1 * self.arms.rate_2
        slope = product - total * found.g - found.u**2 + found.g**2
        return slope * (total - 2.0 * found.g) - 2.0 * found.u * found.dg

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle [rad], zero at dead centre."""
        angles = np.asarray(theta, dtype=float)
        if self.through_centre:
            return self._uniform * angles
        first, rate_1, second, rate_2 = self.arms
        if abs(first) < abs(second):  # about the longer vector nothing winds
            first, rate_1, second, rate_2 = second, rate_2, first, rate_1
        if first < 0.0:
            first, second = -first, -second
        turned = (rate_2 - rate_1) * angles
        aside = np.arctan2(second * np.sin(turned), first + second * np.cos(turned))
        return self._forward * (rate_1 * angles + aside)

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
