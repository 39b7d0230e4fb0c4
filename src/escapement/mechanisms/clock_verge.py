"""Escapements of clocks: an escape wheel, and an anchor that swings with a pendulum or balance."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from escapement.base import validate
from escapement.base.lazy import Lazy
from escapement.base.quantity import quantity
from escapement.mechanisms.escape_wheel import EscapeWheel
from escapement.mechanisms.two_bodies import angle

if TYPE_CHECKING:
    from escapement.mechanisms import chains
else:
    chains = Lazy("escapement.mechanisms.chains")

_LOCKING = 1.5  # length of the locking faces in depths of the teeth


@dataclass(frozen=True, repr=False)
class Deadbeat(EscapeWheel):
    """Deadbeat escapement of Graham: the locking faces are arcs about the verge's axis.

    The wheel stands still while the pendulum swings on. All faces are designed for teeth that end
    in a point.

    Parameters
    ----------
    teeth, wheel_radius, tooth_depth, lead, back, tip_radius
        As of `Runaway`.
    span : float
        Teeth between the pallets, a whole number and a half.
    lift : float
        Angle by which the verge turns while a tooth drives it along an impulse face [rad], > 0.
    lock : float
        Verge angle from the drop of a tooth onto a locking face to the face's end [rad].
    drop : float
        Wheel angle free after each tooth [rad].
    driver_start, follower_start : float, optional
        Angles from which a motion starts [rad]. By default the verge stands at the sum of lift
        and lock.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """

    kind: ClassVar[str] = "deadbeat"
    summary: ClassVar[str] = "deadbeat escapement of a clock, with a pendulum or a balance"

    span: float = field(metadata=quantity(
        "teeth that the verge spans", metavar="S", exclusive=True, half=True,
        remedy="give a whole number and a half, such as 7.5"
    ))  # fmt: skip
    lift: float = field(metadata=angle(
        "verge angle while a tooth drives it", exclusive=True
    ))  # fmt: skip
    lock: float = field(metadata=angle("verge angle of the lock"))
    drop: float = field(metadata=angle("wheel angle free after each tooth"))

    def __post_init__(self) -> None:
        self.check_fields()
        self.check_teeth()
        self.check_span(self.span)
        if not self.drop < 0.5 * self.pitch:
            rule = f"less than half a pitch, {math.degrees(0.5 * self.pitch):.6g} deg"
            raise validate.fail("drop", rule, f"{math.degrees(self.drop):.6g} deg", "give less")
        _ = self.alternation

    @property
    def default_start(self) -> float:
        """Verge angle from which a motion starts if none is given [rad]."""
        return self.lift + self.lock

    @property
    def axes_distance(self) -> float:
        """Distance of the axes over the wheel's radius: the verge's faces lie on its tangents."""
        return 1.0 / math.cos(0.5 * self.span * self.pitch)

    def _corner(self, side: float, inner: bool) -> complex:
        """Corner of an impulse face: side -1 of the entry pallet, +1 of the exit pallet."""
        apart, between = self.axes_distance, math.floor(self.span)
        pitches = (
            between * self.pitch + self.drop if inner else (between + 1) * self.pitch - self.drop
        )
        radius = math.sqrt(apart**2 + 1.0 - 2.0 * apart * math.cos(0.5 * pitches))
        beside = math.acos((apart**2 + radius**2 - 1.0) / (2.0 * apart * radius))
        half = 0.5 * (self.lift + self.lock)
        # the tooth leaves the face at the corner that reaches deepest into the wheel
        deep = half if inner is (side < 0.0) else self.lock - half
        return cmath.rect(radius, math.pi - side * (beside - deep))

    def _base(self, side: float, corner: complex, locks: bool) -> complex:
        """Where the face ends that begins at a corner, outside of the wheel."""
        return corner * cmath.exp(-1j * side * self._reach / abs(corner))

    @property
    def _reach(self) -> float:
        return _LOCKING * self.tooth_depth / self.wheel_radius

    @cached_property
    def follower_chains(self) -> list[chains.Chain]:
        """The entry pallet and the exit pallet."""
        found = []
        for side in (-1.0, 1.0):
            inner, outer = self._corner(side, True), self._corner(side, False)
            bases = self._base(side, outer, side < 0.0), self._base(side, inner, side > 0.0)
            points = [outer, bases[0], bases[1], inner]
            bulges = [_bulge(outer, bases[0]), 0.0, _bulge(bases[1], inner), 0.0]
            chain = chains.Chain.of(points, bulges)
            found.append(chain if side < 0.0 else chain.reversed())
        return found


def _bulge(start: complex, end: complex) -> float:
    """Bulge of the arc about the origin between two points; of a line if they are not on one."""
    if not math.isclose(abs(start), abs(end), rel_tol=1e-12):
        return 0.0
    return math.tan(0.25 * cmath.phase(end / start))


@dataclass(frozen=True, repr=False)
class Recoil(Deadbeat):
    """Recoil escapement: an anchor with straight locking faces, which push the wheel back.

    Parameters
    ----------
    teeth, wheel_radius, tooth_depth, lead, back, tip_radius, span, lift, lock, drop
        As of `Deadbeat`.
    recoil_angle : float
        Angle between a locking face and the arc about the verge's axis [rad], > 0.
    """

    kind: ClassVar[str] = "recoil"
    summary: ClassVar[str] = "recoil escapement of a clock, with a pendulum or a balance"

    recoil_angle: float = field(metadata=angle(
        "angle of the locking faces to arcs about the verge's axis", exclusive=True
    ))  # fmt: skip

    def _base(self, side: float, corner: complex, locks: bool) -> complex:
        if not locks:
            return super()._base(side, corner, locks)
        way = -1j * side * cmath.exp(-1j * self.recoil_angle)
        return corner + self._reach * way * corner / abs(corner)
