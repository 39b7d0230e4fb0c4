"""The gear-driven Geneva wheel: a pin on a planet traces a cycloid, coaxial with the wheel."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from escapement.errors import InvalidValue
from escapement.lazy import Lazy
from escapement.mechanisms._gear_train import GearTrain
from escapement.mechanisms.gear_equation import lobe_ratios
from escapement.units import degrees

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike

    from escapement.mechanisms import slotted
    from escapement.model import FloatArray
    from escapement.scene import Path
else:
    np, slotted = Lazy("numpy"), Lazy("escapement.mechanisms.slotted")

_LENGTHS = ("carrier", "arm", "entry_radius", "closest_radius")


@dataclass(frozen=True)
class GearDriven(GearTrain):
    """Geneva wheel driven by pins on a planet that rolls in or on a fixed gear.

    Parameters
    ----------
    stations : int
        Stations n, >= 3: the wheel turns by 2 pi/n at each step.
    lobes : int, Fraction, float or str
        Unreal lobes m that fit between two neighbouring lobes of the pin's path
        [-], rational, 0 to 100 000, its denominator at most 1000: 2, 1/2 or "1/2". A
        float within 1e-12 (1 + m) of such a number is that number.
    curve : str
        "hypocycloid" (protracted, k > 2), "epicycloid" (k < 0), or the cognates
        that trace the same paths: "contracted-hypocycloid" (1 < k < 2) and
        "pericycloid" (0 < k < 1).
    pins : int
        Equally spaced pins on the planet. With pins * V0 = 1 one is always engaged.
    unused_lobes : int
        Lobes that find no slot between two that do, at most 100 000; fewer slots,
        longer dwell.
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

    kind = "gear-driven"
    summary = "such a wheel, pins on a planet gear (Dijksman)"
    report_units: ClassVar[dict[str, str]] = dict.fromkeys(("planet_radius", *_LENGTHS), "length")

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

    @property
    def breaks(self) -> tuple[float, float, float]:
        """Pin entry, dead centre and pin exit [rad]."""
        half = self.alpha / 2.0
        return -half, 0.0, half

    @property
    def turns_with_driver(self) -> bool:
        """Whether wheel and carrier turn the same way."""
        if self.through_centre:
            return self.arms.rate_1 + self.arms.rate_2 > 0.0
        return self._step_turn > 0

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
    def path(self) -> Path:
        """The pin path, as kernels evaluate it.

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
        return slotted.two_vector_path(
            first, rate_1, second, rate_2, self._forward, self.breaks[-1]
        )

    def transmission(self, theta: ArrayLike) -> slotted.Transmission:
        """Transmission at driver angles from dead centre [rad], pin engaged.

        Through the wheel's centre g is constant and u infinite at the ends.
        """
        if not self.through_centre:
            return slotted.transmission(self.path, theta)
        angles = np.asarray(theta, dtype=float)
        half = 0.5 * (self.arms.rate_1 - self.arms.rate_2)
        with np.errstate(divide="ignore"):
            slide = np.where(
                np.abs(angles) >= self.alpha / 2.0,
                -np.copysign(np.inf, half * angles),
                -half * np.tan(half * angles),
            )
        return slotted.Transmission(
            np.full_like(angles, self._uniform), slide, np.zeros_like(angles)
        )

    def jerk(self, theta: ArrayLike) -> FloatArray:
        """g'' at driver angles from dead centre [rad], pin engaged [-]."""
        found = self.transmission(theta)
        return np.zeros_like(found.g) if self.through_centre else slotted.jerk(self.path, found)

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

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI, and that of every other solution."""
        count = len(lobe_ratios(self.stations, self.lobes, self.curve))
        solutions = [self._with_solution(place)._geometry() for place in range(1, count + 1)]
        return self._geometry() | self._lengths() | {"solutions": solutions}

    def _with_solution(self, place: int) -> GearDriven:
        """Another solution with the same pins and lobes, or with one pin where these do not fit."""
        try:
            return replace(self, solution=place)
        except InvalidValue:
            return replace(self, solution=place, pins=1, unused_lobes=0)

    def _geometry(self) -> dict[str, Any]:
        return {
            "stations": self.stations,
            **self.wheel_report(),
            "gear_ratio": float(self.gear_ratio),
            "alpha_deg": degrees(self.alpha),
            **{f"{name}_over_fixed": getattr(self, f"{name}_over_fixed") for name in _LENGTHS},
            "turns_with_driver": self.turns_with_driver,
        }

    def _lengths(self) -> dict[str, float]:
        """Its lengths [m], where the size of the fixed gear is known."""
        if self.fixed_radius is None:
            return {}
        planet = self.fixed_radius / abs(float(self.gear_ratio))
        others = {
            name: getattr(self, f"{name}_over_fixed") * self.fixed_radius for name in _LENGTHS
        }
        return {"planet_radius": planet} | others
