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
from escapement.base.units import degrees
from escapement.mechanisms.kind import np
from escapement.mechanisms.two_bodies import TwoBodies, angle

if TYPE_CHECKING:
    from escapement.mechanisms import alternation, chains
    from escapement.mechanisms.protocol import FloatArray
else:
    alternation = Lazy("escapement.mechanisms.alternation")
    chains = Lazy("escapement.mechanisms.chains")

MOST_TEETH = 1000
_ALL = 1e3  # wheel angle that is more than a pitch [rad]
_STEEPEST = math.radians(80.0)
_FACES = 150  # points of each line and arc where the direction of a face matters
_SAMPLES = 48  # points of each line and arc of a pallet
_SWING = 1.5  # depths of the teeth by which pallets are moved to see where they leave the wheel


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
        minimum=-math.inf,
    ))  # fmt: skip
    back: float = field(metadata=angle(
        "angle of the trailing face to the radius, > 0 where its root is behind its tip",
        minimum=-math.inf,
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

    @property
    def _wide(self) -> float:
        """Angle of a tooth at its root [rad]."""
        return cmath.phase(self._tooth[-1]) - cmath.phase(self._tooth[0])

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
        for name in ("lead", "back"):
            value = getattr(self, name)
            if not abs(value) < _STEEPEST:
                rule = f"between -{math.degrees(_STEEPEST):g} and {math.degrees(_STEEPEST):g} deg"
                raise validate.fail(name, rule, f"{math.degrees(value):.6g} deg", "give less")
        if not self.lead + self.back > 0.0:
            least = -math.degrees(self.lead)
            rule = f"greater than minus that of the leading face, {least:.6g} deg"
            raise validate.fail(
                "back", rule, f"{math.degrees(self.back):.6g} deg", "a tooth tapers to its tip"
            )
        if not (wide := self._wide) < self.pitch:
            rule = f"narrower at their roots than the pitch, {math.degrees(self.pitch):.6g} deg"
            raise validate.fail(
                "teeth",
                rule,
                f"{math.degrees(wide):.6g} deg",
                "give fewer, slimmer or shallower teeth",
            )

    def check_span(self, span: float) -> None:
        """Raise InvalidValue for a span that does not let the teeth by in turns."""
        most = 0.5 * self.teeth
        if not (span % 1.0 == 0.5 and span < most):
            rule = f"a whole number and a half, less than {most:g}, half of the teeth"
            raise validate.fail("span", rule, span, "give for example 2.5")

    @cached_property
    def alternation(self) -> alternation.Alternation:
        """How the pallets let one tooth after the other go by; InvalidValue if they do not."""
        arms = [np.abs(chain.points).min() for chain in self.follower_chains]
        most = _SWING * self.tooth_depth / self.wheel_radius / min(arms)
        return alternation.alternation(self.blocked, self.innermost, self.pitch, most)

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI; angles in degrees."""
        found = {"teeth": self.teeth, **super().report()}
        found |= {"centre_distance_over_wheel_radius": self.axes_distance}
        found |= {"root_gap_deg": degrees(self.pitch - self._wide)}
        return found | {f"{k}_deg": degrees(x) for k, x in self.alternation._asdict().items()}

    @cached_property
    def driver_chains(self) -> list[chains.Chain]:
        """A tooth and the root circle up to the next one."""
        behind, first, last, ahead = self._tooth
        following = behind * cmath.exp(1j * self.pitch)
        tip, gap = math.pi - self.lead - self.back, cmath.phase(following / ahead)
        rounded = [(last, math.tan(0.25 * tip))] * (self.tip_radius > 0.0)
        points = [behind, *(first for _ in rounded), last, ahead, following]
        bulges = [0.0, *(bulge for _, bulge in rounded), 0.0, math.tan(0.25 * gap)]
        return [chains.Chain.of(points, bulges)]

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

    @cached_property
    def _pallets(self) -> list[list[chains.Segment]]:
        """The lines and arcs of both pallets."""
        return [chains.segments_of(chain) for chain in self.follower_chains]

    def pushed(self, pallet: int, phi: FloatArray) -> tuple[Any, Any]:
        """Where a tooth pushes a pallet at ascending verge angles, and the normal; complex."""
        apart = self.axes_distance
        points = apart + chains.sampled(self._pallets[pallet], _FACES) * np.exp(1j * phi)[:, None]
        radius = np.abs(points)
        side = self.tooth_angles(np.minimum(radius, 1.0))[1]
        ahead = np.where(radius <= 1.0, np.angle(points) - side, np.inf)
        first = np.argmin(ahead, axis=1)[:, None]
        place, theta = (np.take_along_axis(x, first, axis=1)[:, 0] for x in (points, ahead))
        # the normal goes through the point that both bodies move alike
        normal = place * (1.0 - np.gradient(theta, phi)) - apart
        return place, normal / np.abs(normal)

    def innermost(self, pallet: int, phi: float) -> complex:
        """The point of a pallet that is nearest to the wheel's axis at a verge angle."""
        turn, apart = cmath.exp(1j * phi), self.axes_distance
        return complex(apart + turn * chains.nearest(self._pallets[pallet], -apart / turn))

    def blocked(self, phi: FloatArray, samples: int) -> FloatArray:
        """Wheel angles between which a pallet stands in the way of a tooth, shape (n, 2, 2).

        For each verge angle and pallet it gives the first and the last, of one tooth; nan for a
        pallet outside the wheel, and infinite ones for one that reaches the roots. `samples`
        points of each line and arc of a pallet are compared with the teeth.
        """
        root, found = 1.0 - self.tooth_depth / self.wheel_radius, []
        for pallet in self._pallets:
            points = (
                self.axes_distance + chains.sampled(pallet, samples) * np.exp(1j * phi)[:, None]
            )
            radius, angles = np.abs(points), np.angle(points)
            trailing, leading = self.tooth_angles(np.clip(radius, root, 1.0))
            crossing, ends = _across_rim(points), []
            for side, far, least in ((leading, np.inf, np.min), (trailing, -np.inf, np.max)):
                free = np.where(radius <= 1.0, angles - side, far)
                free = np.where(radius < root, -far, free)
                ends.append(least([free, np.where(np.isnan(crossing), far, crossing)], axis=(0, 2)))
            found.append(np.stack(ends, axis=1))
        between = np.stack(found, axis=1)
        return np.where(np.isinf(between[..., :1]) & (between[..., :1] > 0.0), np.nan, between)

    @property
    def default_start(self) -> float:
        """Verge angle from which a motion starts if none is given [rad]."""
        return 0.0

    @cached_property
    def start(self) -> tuple[float, float]:
        """Angles of wheel and verge from which a motion starts [rad]."""
        given = self.follower_start
        phi = self.default_start if given is None else given
        theta = self.driver_start
        return (self._middle(phi) if theta is None else theta), phi

    def _middle(self, phi: float) -> float:
        """Middle of the widest range of wheel angles that is free at a verge angle [rad]."""
        blocked = self.blocked(np.array([phi]), _SAMPLES)[0]
        # a pallet that reaches the roots blocks the whole pitch
        ends = [(max(low, -_ALL), min(high, _ALL)) for low, high in blocked if low == low]
        spans = sorted((low % self.pitch, high - low) for low, high in ends)
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


def _across_rim(points: Any) -> FloatArray:
    """Polar angles where the chord from each point to the next crosses the unit circle, or nan."""
    along = np.roll(points, -1, axis=1) - points
    outside, middle = np.abs(points) ** 2 - 1.0, (points.conj() * along).real
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(middle**2 - np.abs(along) ** 2 * outside)
        share = (-middle - np.copysign(root, outside)) / np.abs(along) ** 2
    crosses = (share >= 0.0) & (share <= 1.0)
    return np.where(crosses, np.angle(points + np.where(crosses, share, 0.0) * along), np.nan)


def _onto(start: complex, way: complex, radius: Any) -> Any:
    """Where a straight line from a point outside a circle about the origin first meets it."""
    along = (start.conjugate() * way).real
    beyond = along**2 - abs(start) ** 2 + radius**2
    return start - way * (along + np.sqrt(np.maximum(beyond, 0.0)))
