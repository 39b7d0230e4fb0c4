"""The escape wheel: pointed teeth, of which pallets let one at a time go by."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from escapement.base import validate
from escapement.base.lazy import Lazy
from escapement.base.quantity import quantity
from escapement.base.spoken import as_spoken
from escapement.mechanisms.kind import np
from escapement.mechanisms.two_bodies import TwoBodies, angle

if TYPE_CHECKING:
    from escapement.mechanisms import chains
    from escapement.mechanisms.protocol import FloatArray
else:
    chains = Lazy("escapement.mechanisms.chains")

MOST_TEETH = 1000
_SAMPLES = 64


def length(text: str, **rule: Any) -> dict[str, Any]:
    """Declaration of a length."""
    return quantity(text, "length", remedy="give the length", **rule)


@dataclass(frozen=True, repr=False)
class EscapeWheel(TwoBodies):
    """Base of the kinds with an escape wheel as the driver, and a verge with two pallets.

    Tooth 0 points along the x axis at wheel angle 0; entry is the pallet below the line of
    centres, exit the one above. A verge angle > 0 lifts the entry pallet out of the wheel.
    """

    teeth: int = field(metadata=quantity(
        "teeth of the escape wheel", whole=True, minimum=3, maximum=MOST_TEETH, metavar="N",
        remedy="give the number of teeth"
    ))  # fmt: skip
    wheel_radius: float = field(metadata=length("radius of the wheel's tips", exclusive=True))
    tooth_depth: float = field(metadata=length("depth of the teeth", exclusive=True))
    lead: float = field(metadata=angle(
        "angle of the teeth's leading face to the radius, > 0 where its root is ahead of its tip",
        minimum=-80.0 * math.pi / 180.0, maximum=80.0 * math.pi / 180.0,
    ))  # fmt: skip
    back: float = field(metadata=angle(
        "angle of the trailing face to the radius, > 0 where its root is behind its tip",
        minimum=-80.0 * math.pi / 180.0, maximum=80.0 * math.pi / 180.0,
    ))  # fmt: skip
    tip_radius: float = field(metadata=length("radius of the tips' rounding, 0 for sharp tips"))

    @property
    def crank_radius(self) -> float:
        """Unit of length, the wheel's radius [m]."""
        return self.wheel_radius

    @property
    def driver_fold(self) -> int:
        """The teeth."""
        return self.teeth

    @cached_property
    def _tooth(self) -> tuple[complex, ...]:
        """Corners of a tooth over the wheel's radius: trailing root, both ends of the tip's arc,
        leading root."""
        tip = self.tip_radius / self.wheel_radius
        back, lead = cmath.exp(1j * self.back), -cmath.exp(-1j * self.lead)
        ends = 1.0 - tip - 1j * tip * back, 1.0 - tip - 1j * tip * lead
        root = 1.0 - self.tooth_depth / self.wheel_radius
        behind, ahead = _onto(ends[0], -back, root), _onto(ends[1], lead, root)
        return behind, *ends, ahead

    def check_teeth(self) -> None:
        """Raise InvalidValue for teeth that cannot be made."""
        deep, tip, size = self.tooth_depth, self.tip_radius, self.wheel_radius
        if not deep < size:
            raise validate.fail(
                "tooth_depth", f"less than wheel_radius, {as_spoken(size, 'length')}",
                as_spoken(deep, "length"), "give shallower teeth",
            )  # fmt: skip
        if not 2.0 * tip < deep:
            raise validate.fail(
                "tip_radius", f"less than half of tooth_depth, {as_spoken(0.5 * deep, 'length')}",
                as_spoken(tip, "length"), "give sharper tips",
            )  # fmt: skip
        if not self.lead + self.back > 0.0:
            least = -math.degrees(self.lead)
            rule = f"greater than minus that of the leading face, {least:.6g} deg"
            raise validate.fail(
                "back", rule, f"{math.degrees(self.back):.6g} deg", "a tooth tapers to its tip"
            )
        behind, *_, ahead = self._tooth
        wide = cmath.phase(ahead) - cmath.phase(behind)
        if not wide < self.pitch:
            rule = f"narrower at their roots than the pitch, {math.degrees(self.pitch):.6g} deg"
            raise validate.fail(
                "teeth",
                rule,
                f"{math.degrees(wide):.6g} deg",
                "give fewer, slimmer or shallower teeth",
            )

    @cached_property
    def driver_chains(self) -> list[chains.Chain]:
        """A tooth and the root circle up to the next one."""
        behind, first, last, ahead = self._tooth
        following = behind * cmath.exp(1j * self.pitch)
        tip, gap = math.pi - self.lead - self.back, cmath.phase(following / ahead)
        bulges = [0.0, math.tan(0.25 * tip), 0.0, math.tan(0.25 * gap)]
        return [chains.open_chain([behind, first, last, ahead, following], bulges)]

    def tooth_angles(self, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Polar angles of tooth 0's trailing and leading side at radii from the root to 1."""
        _, first, last, _ = self._tooth
        tip = self.tip_radius / self.wheel_radius
        middle = 1.0 - tip
        cosine = (radius**2 + middle**2 - tip**2) / (2.0 * middle * radius)
        rounded = np.arccos(np.clip(cosine, -1.0, 1.0))
        ways = -cmath.exp(1j * self.back), -cmath.exp(-1j * self.lead)
        sides = [
            np.where(radius > abs(end), side * rounded, np.angle(_onto(end, way, radius)))
            for end, way, side in zip((first, last), ways, (-1.0, 1.0), strict=True)
        ]
        return sides[0], sides[1]

    def blocked(self, phi: FloatArray) -> FloatArray:
        """Wheel angles between which a pallet stands in the way of a tooth, shape (n, 2, 2).

        For each verge angle and pallet it gives the first and the last, of one tooth; nan for a
        pallet outside the wheel, and infinite ones for one that reaches the roots.
        """
        root, found = 1.0 - self.tooth_depth / self.wheel_radius, []
        for chain in self.follower_chains:
            points = self.axes_distance + chain.sampled(_SAMPLES) * np.exp(1j * phi)[:, None]
            radius, angles = np.abs(points), np.angle(points)
            trailing, leading = self.tooth_angles(np.clip(radius, root, 1.0))
            ends = []
            for side, far, least in ((leading, np.inf, np.min), (trailing, -np.inf, np.max)):
                free = np.where(radius <= 1.0, angles - side, far)
                ends.append(least(np.where(radius < root, -far, free), axis=1))
            found.append(np.stack(ends, axis=1))
        between = np.stack(found, axis=1)
        return np.where(np.isinf(between[..., :1]) & (between[..., :1] > 0.0), np.nan, between)

    @cached_property
    def start(self) -> tuple[float, float]:
        """Angles of wheel and verge from which a motion starts [rad]."""
        phi = self.follower_start or 0.0
        theta = self.driver_start
        return (self._middle(phi) if theta is None else theta), phi

    def _middle(self, phi: float) -> float:
        """Middle of the widest range of wheel angles that is free at a verge angle [rad]."""
        blocked = self.blocked(np.array([phi]))[0]
        spans = sorted((low % self.pitch, high - low) for low, high in blocked if low == low)
        reach = max((low + wide for low, wide in spans), default=self.pitch) - self.pitch
        gaps = []
        for low, wide in spans or [(self.pitch, 0.0)]:
            gaps.append((low - reach, 0.5 * (low + reach)))
            reach = max(reach, low + wide)
        free, middle = max(gaps)
        if not free > 0.0:
            rule = "an angle at which a tooth fits between the pallets"
            raise validate.fail(
                "follower_start", rule, f"{math.degrees(phi):.6g} deg", "choose another one"
            )
        return float(middle)


def _onto(start: complex, way: complex, radius: Any) -> Any:
    """Where a straight line from a point outside a circle about the origin first meets it."""
    along = (start.conjugate() * way).real
    beyond = along**2 - abs(start) ** 2 + radius**2
    return start - way * (along + np.sqrt(np.maximum(beyond, 0.0)))
