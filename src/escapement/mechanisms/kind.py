"""Base classes of mechanisms, with what files, the command line and reports need of them."""

from __future__ import annotations

import math
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from escapement.base import validate
from escapement.base.errors import UnknownArgument
from escapement.base.lazy import ArrayLike, FloatArray, Lazy, np
from escapement.base.quantity import Declared, Setting, declared, quantity
from escapement.base.spoken import spoken_length
from escapement.mechanisms.other_sizes import OtherSize, diameters, numbers_of_sizes
from escapement.mechanisms.path import Path
from escapement.mechanisms.protocol import CELL, Mechanism
from escapement.mechanisms.wheel_checks import check_lengths

if TYPE_CHECKING:
    from escapement.mechanisms import slotted, table
else:
    slotted, table = Lazy("escapement.mechanisms.slotted"), Lazy("escapement.mechanisms.table")

# the files of the kinds import from here modules that must be loaded only when they are used
__all__ = [
    "CELL",
    "WHEEL",
    "Arms",
    "ArrayLike",
    "Engaging",
    "Kind",
    "Wheel",
    "np",
    "slotted",
    "table",
]

WHEEL = (*CELL, "slots", "pins", "continuous", "dwell_deg", "transmission_max")
"""Keys that every wheel reports besides its stations."""


class Kind(Declared, Mechanism):
    """Base of the mechanisms that a file or the command line can describe.

    In addition to what `mechanisms.protocol` asks for, a kind has its declared fields and the
    attributes below. Its file is imported to list its options, so it
    loads nothing heavy: NumPy and kernels come through `escapement.base.lazy`.
    """

    section: ClassVar[str] = "mechanism"
    kind: ClassVar[str]
    """Its name, a key of `escapement.mechanisms.KINDS`."""
    summary: ClassVar[str]
    """Description, a line of help."""
    meshed: ClassVar[bool] = False
    """Whether it has no slots, and its losses are given by an efficiency."""
    motion_ratio: Any = 1.0
    """Share of the cell during which the follower moves: 1 without a dwell."""
    given: Any = ()
    """Names of settings that a study keeps although the mechanism would choose the same."""

    def __new__(cls, *args: Any, **keywords: Any) -> Self:
        """As of `Declared`; tells how to give a size that the class has no argument for."""
        try:
            return super().__new__(cls, *args, **keywords)
        except UnknownArgument:
            for name in keywords.keys() & cls.other_sizes():
                other, named = cls.other_sizes()[name].of, cls.__name__
                remedy = f"give {other}, or {named}.from_options({name}=...)"
                raise UnknownArgument(f"{named} has no argument {name!r}; {remedy}") from None
            raise

    @classmethod
    @cache
    def other_sizes(cls) -> dict[str, OtherSize]:
        """Sizes that stand for its numbers on the command line and in files, by name."""
        return diameters(declared(cls))

    @classmethod
    def options(cls) -> dict[str, Setting]:
        """Settings for the command line, by the name of the option."""
        return declared(cls) | {name: size.entry for name, size in cls.other_sizes().items()}

    @classmethod
    def from_options(cls, **given: Any) -> Self:
        """The mechanism of its numbers in SI, and of sizes in place of them, by name."""
        return cls(**numbers_of_sizes(cls.other_sizes(), given))


def pin_radius() -> dict[str, Any]:
    """Declaration of the pin's radius."""
    return quantity("radius of the pins", "length", remedy="give the radius, 0 for a thin pin")


def roller_radius() -> dict[str, Any]:
    """Declaration of the roller's radius."""
    return quantity(
        "radius of rollers on the pins", "length", note="; friction is then that inside the roller",
        remedy="give the outer radius, 0 for none",
    )  # fmt: skip


def clearance() -> dict[str, Any]:
    """Declaration of the clearance between pin and slot."""
    return quantity(
        "slot width minus pin diameter", "length", metavar="C",
        remedy="give how much wider the slot is, 0 for none",
    )  # fmt: skip


def cells_of(mechanism: Any, theta: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Number of the cell that holds each driver angle, and the angle from its dead centre [rad].

    Both ends of the first engagement belong to cell 0, although without a dwell its end is where
    the next cell begins.
    """
    angles, (entry, *_, exit_) = np.asarray(theta, dtype=float), mechanism.breaks
    cells = np.floor((angles - entry) / mechanism.cell_angle)
    cells = np.where((angles >= entry) & (angles <= exit_), 0.0, cells)
    return cells, angles - cells * mechanism.cell_angle


class Engaging(Mechanism):
    """Base of mechanisms whose follower moves in each cell from entry to exit, and then rests."""

    def transmission(self, theta: ArrayLike) -> slotted.Transmission:
        """Transmission at driver angles of any size from dead centre [rad]; zero in a dwell."""
        _cells, local, moves = self._in_engagement(theta)
        found = self._engaged(local)
        slide = np.zeros_like(found.u) if self.meshed else found.u
        return slotted.Transmission(*(np.where(moves, x, 0.0) for x in (found.g, slide, found.dg)))

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle at driver angles of any size [rad], zero at dead centre.

        It grows by `follower_step` in each cell, and rests in a dwell.
        """
        cells, local, _moves = self._in_engagement(theta)
        return np.asarray(cells * self.follower_step + self._angle_at(local))

    def _in_engagement(self, theta: ArrayLike) -> tuple[FloatArray, FloatArray, Any]:
        """Cells, driver angles in them, exits for a dwell, and which are in no dwell."""
        cells, local = cells_of(self, theta)
        exit_ = self.breaks[-1]
        continuous = self.motion_ratio > 1.0 - 1e-12
        return cells, np.minimum(local, exit_), (local <= exit_) | continuous

    def _engaged(self, theta: ArrayLike) -> slotted.Transmission:
        """Transmission at driver angles between entry and exit [rad]."""
        return slotted.transmission(self.path, theta)

    def _angle_at(self, theta: FloatArray) -> FloatArray:
        """Follower angle at driver angles between entry and exit [rad]."""
        raise NotImplementedError


class Arms(NamedTuple):
    """Pin path C = first exp(i rate_1 theta) + second exp(i rate_2 theta).

    The origin is the follower's axis, and theta is counted from dead centre. The vectors
    are in the mechanism's unit of length, with the sign that they have at dead centre.
    """

    first: float
    rate_1: float
    second: float
    rate_2: float


class Wheel(Engaging, Kind):
    """Base of the wheels with slots that pins drive: the motion follows from the pin's path."""

    stations: Any
    arms: Any
    engagement_angle: Any

    @property
    def contact_radius(self) -> float:
        """Radius of the pin or roller that touches the slot [-]; 0 if none is given."""
        outer = self.roller_radius or self.pin_radius
        return float(outer / self.crank_radius) if outer else 0.0

    @property
    def widest_pin(self) -> float:
        """Radius of a pin or roller at which no wall is left between two slots [-]."""
        # the slots come closest to each other where the pin is closest to the axis
        closest = float(self.radius(np.array([0.0, self.engagement_angle / 2.0])).min())
        return closest * math.sin(math.pi / self.slots)

    def check_pin(self) -> None:
        """Raise InvalidValue for a pin or a roller that is too thick for the wheel."""
        pin, roller = self.pin_radius, self.roller_radius
        if roller and not 0.0 < pin < roller:
            rule = f"greater than pin_radius, {spoken_length(pin)}, and that greater than 0"
            raise validate.fail("roller_radius", rule, spoken_length(roller), "give both radii")
        name = "roller_radius" if roller else "pin_radius"
        outer = roller or pin
        gap = self.clearance
        if not (outer or gap):
            return
        check_lengths({name: outer, "clearance": gap}, self.crank_radius, self.plain_crank)
        widest = self.crank_radius * self.widest_pin
        most, given, remedy = widest - 0.5 * gap, outer, "choose a thinner pin or a larger wheel"
        if outer < widest <= outer + 0.5 * gap:
            name, most, given = "clearance", 2.0 * (widest - outer), gap
            remedy = "choose a smaller clearance or a larger wheel"
        if not given < most:
            rule = f"less than {spoken_length(most)}, where neighbouring slots meet"
            raise validate.fail(name, rule, spoken_length(given), remedy)

    @cached_property
    def breaks(self) -> tuple[float, ...]:
        """Pin entry, the angles where sliding reverses on either wall, and exit [rad].

        For a pin without a radius sliding reverses at dead centre on both walls.
        """
        half = self.engagement_angle / 2.0
        if pin := self.contact_radius:
            ends = np.array([-half, half])
            return tuple(slotted.slide_edges(self.path, pin, ends).tolist())
        return -half, 0.0, half

    @property
    def follower_step(self) -> float:
        """Follower angle per cell, 2 pi over the stations [rad]."""
        return 2.0 * math.pi / self.stations  # type: ignore[no-any-return]

    @property
    def continuous(self) -> bool:
        """Whether a pin is always engaged: no dwell (Meyer 1-3)."""
        return bool(self.motion_ratio > 1.0 - 1e-12)

    @property
    def dwell(self) -> float:
        """Driver angle of the cell in which the follower is locked [rad]."""
        return self.cell_angle * (1.0 - self.motion_ratio)  # type: ignore[no-any-return]

    @property
    def transmission_max(self) -> float:
        """Greatest transmission, at dead centre [-]."""
        return float(self._engaged(0.0).g)

    @property
    def _forward(self) -> float:
        """Sign with which the follower's angle grows along the path: that of g at dead centre."""
        first, rate_1, second, rate_2 = self.arms
        return math.copysign(1.0, (first * rate_1 + second * rate_2) * (first + second))

    @cached_property
    def path(self) -> Path:
        """The pin path, as kernels evaluate it."""
        arms: Arms = self.arms
        return slotted.two_vector_path(*arms, self._forward, self.engagement_angle / 2.0)

    def jerk(self, theta: ArrayLike) -> FloatArray:
        """g'' at driver angles of any size from dead centre [rad]; zero in a dwell [-]."""
        _cells, local, moves = self._in_engagement(theta)
        return np.where(moves, slotted.jerk(self.path, self._engaged(local)), 0.0)

    def radius(self, theta: ArrayLike) -> FloatArray:
        """Distance of the pin from the follower's axis, in the unit of the arms [-].

        It is that of the pin which is at dead centre at angle 0, engaged or not.
        """
        first, rate_1, second, rate_2 = self.arms
        half = 0.5 * (rate_1 - rate_2) * np.asarray(theta, dtype=float)
        # hypot of the sum along and across the bisector keeps accuracy near the centre
        along, across = (first + second) * np.cos(half), (first - second) * np.sin(half)
        return np.asarray(np.hypot(along, across))

    def direction(self, theta: ArrayLike) -> FloatArray:
        """Direction of the same pin from the follower's axis [rad], zero at dead centre.

        While the pin is engaged it is the follower's angle (Meyer 1-6).
        """
        angles = np.asarray(theta, dtype=float)
        first, rate_1, second, rate_2 = self.arms
        if abs(first) < abs(second):  # the sum does not wind about the longer vector
            first, rate_1, second, rate_2 = second, rate_2, first, rate_1
        if first < 0.0:
            first, second = -first, -second
        driver_angle = (rate_2 - rate_1) * angles
        aside = np.arctan2(second * np.sin(driver_angle), first + second * np.cos(driver_angle))
        return np.asarray(self._forward * (rate_1 * angles + aside))

    _angle_at = direction
