"""The Geneva wheel, external or internal, with as many pins as fit."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.mechanisms.slotted import Transmission, radius, transmission, two_vector_path
from escapement.model import FloatArray
from escapement.scene import Path

MOST_SLOTS = 1_000_000


@dataclass(frozen=True)
class Geneva:
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
        Distance of the pins from the driver's axis [m]; only contact forces
        need it.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.

    Source: Meyer (1973), eqs. 1-1 to 1-8; Filemon (1960), eqs. 2 and 3.
    """

    slots: int
    pins: int | None = None
    internal: bool = False
    crank_radius: float | None = None

    def __post_init__(self) -> None:
        remedy = "a Geneva wheel has from 3 slots to some dozens"
        n = validate.integer("slots", self.slots, 3, remedy, maximum=MOST_SLOTS)
        internal = validate.truth("internal", self.internal)
        most = 1 if internal else (2 * n) // (n - 2)
        if self.pins is None:
            pins = most if not internal and (2 * n) % (n - 2) == 0 else 1
        else:
            pins = validate.integer("pins", self.pins, 1, "give the number of crank pins")
        if pins > most:
            kind = "an internal wheel" if internal else f"{n} slots"
            raise validate.fail(
                "pins", f"at most {most} for {kind}", pins, "fewer pins, or leave it out"
            )
        # a study over the slots keeps a number of pins that was given, and no other
        object.__setattr__(self, "given", () if self.pins is None else ("pins",))
        object.__setattr__(self, "slots", n)
        object.__setattr__(self, "pins", pins)
        object.__setattr__(self, "internal", internal)
        if self.crank_radius is not None:
            length = validate.positive(
                "crank_radius", self.crank_radius, "give the crank radius in m"
            )
            object.__setattr__(self, "crank_radius", length)

    @property
    def continuous(self) -> bool:
        """Whether a pin is always engaged: no dwell (Meyer 1-3)."""
        return not self.internal and self.pins * (self.slots - 2) == 2 * self.slots  # type: ignore[operator]

    @property
    def centre_distance(self) -> float:
        """Distance of the axes in crank radii, 1/sin(pi/n) (Meyer 1-2)."""
        return 1.0 / math.sin(math.pi / self.slots)

    @property
    def cell_angle(self) -> float:
        """Driver angle from one pin's entry to the next one's [rad]."""
        return 2.0 * math.pi / self.pins  # type: ignore[operator]

    @property
    def engagement_angle(self) -> float:
        """Driver angle over which one pin moves the follower [rad]."""
        if self.continuous:
            return self.cell_angle
        turn = 2.0 * math.pi / self.slots
        return math.pi + turn if self.internal else math.pi - turn

    @property
    def motion_ratio(self) -> float:
        """Moving share of the cell [-]; 1 for continuous engagement."""
        return self.engagement_angle / self.cell_angle

    @property
    def breaks(self) -> tuple[float, float, float]:
        """Pin entry, dead centre and pin exit [rad]."""
        half = self.engagement_angle / 2.0
        return -half, 0.0, half

    @property
    def follower_step(self) -> float:
        """Follower angle per cell, 2 pi/n [rad]."""
        return 2.0 * math.pi / self.slots

    @cached_property
    def path(self) -> Path:
        """The pin path, as kernels evaluate it."""
        crank = 1.0 if self.internal else -1.0
        exit_ = self.breaks[-1]
        return two_vector_path(self.centre_distance, 0.0, crank, crank, forward=1.0, rest=exit_)

    def transmission(self, theta: ArrayLike) -> Transmission:
        """Transmission at driver angles from dead centre [rad], pin engaged."""
        return transmission(self.path, theta)

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle [rad], zero at dead centre (Meyer 1-6)."""
        angles = np.asarray(theta, dtype=float)
        sign = 1.0 if self.internal else -1.0
        return np.arctan2(np.sin(angles), self.centre_distance + sign * np.cos(angles))

    def radius(self, theta: ArrayLike) -> FloatArray:
        """Distance of the pin from the follower's axis, in crank radii."""
        return radius(self.path, theta)
