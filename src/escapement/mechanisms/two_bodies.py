"""What the kinds of two bodies that touch with their outlines have in common."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.quantity import quantity
from escapement.base.units import degrees
from escapement.mechanisms.kind import Kind

if TYPE_CHECKING:
    from escapement.mechanisms import chains
    from escapement.mechanisms.features import Features
else:
    chains = Lazy("escapement.mechanisms.chains")


def angle(text: str, **rule: Any) -> dict[str, Any]:
    """Declaration of an angle, in degrees on the command line and in files."""
    return quantity(text, "degrees", metavar="DEG", remedy="give the angle", **rule)


def _start(body: str, note: str) -> dict[str, Any]:
    return angle(f"angle of the {body} at the start", minimum=-math.inf, note=note)


@dataclass(frozen=True, repr=False)
class TwoBodies(Kind):
    """Base of the kinds whose driver and follower turn about fixed axes and touch anywhere.

    Angles of both bodies are counted counterclockwise, and lengths are in units of
    `crank_radius`. A cell is one pitch of the driver.
    """

    takes_clearance: ClassVar[bool] = True
    report_units: ClassVar[dict[str, str]] = {"centre_distance": "length"}

    driver_start: float | None = field(
        default=None,
        kw_only=True,
        metadata=_start("driver", " (default: the middle of its free angle)"),
    )
    follower_start: float | None = field(
        default=None, kw_only=True, metadata=_start("follower", " (default: chosen by the kind)")
    )

    def _shown(self) -> list[tuple[str, Any, str]]:
        rows = super()._shown()
        return [(n, math.degrees(x) if unit == "deg" else x, unit) for n, x, unit in rows]

    @property
    def driver_chains(self) -> list[chains.Chain]:
        """The driver's outline in its own frame, one sector of it."""
        raise NotImplementedError

    @property
    def follower_chains(self) -> list[chains.Chain]:
        """The follower's outline in its own frame, one sector of it."""
        raise NotImplementedError

    @property
    def driver_fold(self) -> int:
        """Equal sectors of the driver."""
        return 1

    @property
    def follower_fold(self) -> int:
        """Equal sectors of the follower."""
        return 1

    @cached_property
    def driver_features(self) -> Features:
        """What the driver touches with, in its own frame."""
        return chains.features_of(self.driver_chains, self.driver_fold)

    @cached_property
    def follower_features(self) -> Features:
        """What the follower touches with, in its own frame."""
        return chains.features_of(self.follower_chains, self.follower_fold)

    @property
    def pitch(self) -> float:
        """Driver angle after which the driver looks the same [rad]."""
        return 2.0 * math.pi / self.driver_fold

    @property
    def path(self) -> Any:
        """There is none: InvalidValue for whatever asks for a transmission."""
        raise InvalidValue(
            f"mechanism must have a transmission function here, got {self.kind}, whose bodies "
            "touch anywhere; choose a kind with slots or gears"
        )

    follower_step = path

    def follower_angle(self, theta: Any) -> Any:
        """There is none, as there is no `path`."""
        return self.path

    @property
    def breaks(self) -> tuple[float, ...]:
        """Driver angles at which a cell begins and ends [rad]."""
        return 0.0, self.pitch

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI; angles in degrees."""
        found = {"pitch_deg": degrees(self.pitch)}
        found |= {"centre_distance": self.axes_distance * self.crank_radius}
        names = "driver_start_deg", "follower_start_deg"
        return found | dict(zip(names, map(degrees, self.start), strict=True))

    @property
    def cell_angle(self) -> float:
        """The pitch [rad]."""
        return self.pitch
