"""The equation of motion with dual numbers: how a motion changes with the model's parameters.

A dual has one slope for each parameter that varies. After them come its slopes by the squared
speed w and by the driver angle, at the indices `SPEED` and `ANGLE`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebval

from escapement.dynamics import law as dynamics
from escapement.mechanisms import slotted
from escapement.mechanisms.path import EDGES, PIECES, TERMS, Path
from escapement.model.escapement import Escapement
from escapement.model.natural import natural
from escapement.model.numbers import full_torque
from escapement.model.scene import Scene
from escapement.model.train import numbers_of_trains, referred
from escapement.tolerance.dual import Dual, slopes_of, uncompiled, value_of
from escapement.tolerance.dual_engagements import Part, parts_of

SPEED, ANGLE = -2, -1
"""Indices of the slopes by w and by the driver angle."""


@dataclass(frozen=True)
class Law:
    """An escapement whose numbers vary."""

    escapement: Escapement
    names: tuple[str, ...]

    @property
    def count(self) -> int:
        """Number of slopes: one for each number that varies, and those by w and driver angle."""
        return len(self.names) + 2

    def seeded(self, value: Any, index: int) -> Dual:
        """Values with the slope 1 at an index and 0 at all others."""
        slopes = np.zeros((*np.shape(value), self.count))
        slopes[..., index] = 1.0
        return Dual(value, slopes)

    @cached_property
    def values(self) -> dict[str, Any]:
        """The numbers by their names [SI], with slopes, as they act on driver and follower.

        Trains between barrel and driver, or follower and load, have been applied to them.
        """
        escapement, inertia = self.escapement, self.escapement.inertia
        known = {"driver_inertia": inertia.driver, "follower_inertia": inertia.follower}
        known |= vars(escapement) | {"torque": full_torque(escapement)}
        known |= numbers_of_trains(escapement.trains)
        known |= escapement.mechanism.lengths | escapement.mechanism.errors
        return referred(known | {n: self.seeded(known[n], i) for i, n in enumerate(self.names)})

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The engagements of imperfect parts; empty for perfect ones."""
        mechanism: Any = self.escapement.mechanism
        return parts_of(mechanism, self.values) if mechanism.errors else ()

    @cached_property
    def scenes(self) -> tuple[Scene, ...]:
        """The scene of each pair."""
        numbers = natural(self.values, self.escapement.scene.path.table)
        rest = np.array([0.0, 0.0, 1.0]), 0.0
        if self.parts:
            made = (Scene(p.path, (p.entry,), 0.0, *rest, **numbers) for p in self.parts)  # type: ignore[arg-type]
            return tuple(made)
        return tuple(Scene(*m[:3], *rest, **numbers) for m in self.escapement.pairs)

    def exit_of(self, pair: int) -> Any:
        """Driver angle in the cell at which an engagement ends."""
        end = float(self.escapement.scenes[pair].edges[-1])
        if self.parts:
            angle = self.parts[pair].leaves - self.parts[pair].delay
            if abs(float(angle) - end) < 1e-12:
                return angle
        return end

    def impact(self, pair: int) -> Any:
        """Share of the speed that is left after the impact at the start of an engagement.

        It is 1 if the engagement begins without an impact.
        """
        strikes = bool(self.parts) and self.parts[pair].strikes
        return _law["left_by_impact"](self.scenes[pair]) if strikes else 1.0

    def clock(self) -> Any:
        """Natural unit of time [s]."""
        return np.sqrt(self.values["follower_inertia"] / self.values["torque"])

    def plain(self, number: Any) -> Dual:
        """A number with its slopes by the numbers alone."""
        return Dual(value_of(number), slopes_of(number, self.count)[..., :SPEED])

    def state(self, angle: Any, w: Any) -> tuple[Dual, Dual]:
        """Driver angles in the cell and squared speeds, each with its slope."""
        return self.seeded(angle, ANGLE), self.seeded(w, SPEED)

    def at(self, pair: int, side: float, angle: Dual, w: Dual, *signs: float) -> Point:
        """The law while a side of the slot carries the force; the side is 0 in a dwell.

        `signs` are those of the sliding speed and of g; they are needed where one of these is 0.
        """
        if self.parts and isinstance(delay := self.parts[pair].delay, Dual):
            angle = angle - Dual(0.0, delay.slopes)
        return Point(self.scenes[pair], side, angle, w, *signs)


@dataclass(frozen=True)
class Point:
    """The law evaluated at driver angles and squared speeds, in natural units."""

    scene: Scene
    side: float
    angle: Dual
    w: Dual
    slide_sign: float = 0.0
    ratio_sign: float = 0.0

    @cached_property
    def pose(self) -> tuple[Any, ...]:
        """g, c, k, u and R."""
        if self.side == 0.0:
            return 0.0, 0.0, 0.0, 0.0, 0.0
        g, u, dg, radius = _pose(self.scene.path, self.angle)
        c = _law["friction_ratio"](
            g, u, radius, self.side, self.scene, self.slide_sign, self.ratio_sign
        )
        return g, c, _law["dragged_slope"](g, dg, self.scene, self.ratio_sign), u, radius

    @cached_property
    def _drive(self) -> tuple[Any, Any]:
        return 1.0 - self.scene.bearing, _law["root_of"](self.w, self.scene)

    @cached_property
    def acceleration(self) -> Any:
        """theta_ddot, half of dw/dtheta."""
        g, c, k, _u, _r = self.pose
        pull, root = self._drive
        torque = _law["net_torque"](g, c, k, pull, self.w, root, self.scene)
        return torque / _law["reduced_inertia"](g, c, self.scene)

    @cached_property
    def contact(self) -> Any:
        """X, which is zero at a pin reversal."""
        g, _c, k, _u, _r = self.pose
        pull, root = self._drive
        return _law["contact"](g, k, pull, self.w, root, self.scene)

    @property
    def slide(self) -> Any:
        """The sliding speed v; where it is zero, the contact point reverses its sliding."""
        g, _c, _k, u, radius = self.pose
        return _law["slide_at"](g, u, radius, self.side, self.scene)

    @property
    def moment(self) -> Any:
        """Moment N h on the follower."""
        if self.side == 0.0:
            return 0.0 * self.w
        g, c, *_ = self.pose
        return self.contact / _law["reduced_inertia"](g, c, self.scene)

    @property
    def force(self) -> Any:
        """Contact force N."""
        if self.side == 0.0:
            return 0.0 * self.w
        g, _c, _k, u, radius = self.pose
        return (
            self.moment
            / _law["grip"](g, u, radius, self.side, self.scene, self.slide_sign, self.ratio_sign)[1]
        )

    @property
    def follower_acceleration(self) -> Any:
        """phi_ddot."""
        g, _c, k, *_ = self.pose
        dg = k - self.scene.follower_drag * (g * abs(g))
        return g * self.acceleration + dg * self.w


def _pose(path: Path, angle: Dual) -> Any:
    """`pose_at` with duals."""
    if not path.table:
        return _slotted["pose_at"](path, angle)
    # the angles may lie in several pieces of a table, and its slopes are series too
    pieces, terms = int(path.numbers[PIECES]), int(path.numbers[TERMS])
    edges, rest = np.split(path.numbers[EDGES:], [pieces + 1])
    series = rest[: pieces * terms].reshape(pieces, terms)
    index = np.clip(np.searchsorted(edges, angle.value, side="right") - 1, 0, pieces - 1)
    scale = 2.0 / (edges[index + 1] - edges[index])
    x = (angle.value - edges[index]) * scale - 1.0
    found: list[Any] = []
    piece: Any = series[index]
    for k in range(3):
        found.append(chebval(x, np.moveaxis(piece, -1, 0), tensor=False) * scale**k)
        piece = chebder(piece, axis=-1)
    g, dg = (Dual(found[k], found[k + 1][..., None] * angle.slopes) for k in range(2))
    return g, g, dg, 1.0


_law, _slotted = uncompiled(dynamics), uncompiled(slotted)
