"""Two bodies of the user's own, from their outlines and the distance of their axes."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from escapement.base import validate
from escapement.base.lazy import Lazy
from escapement.base.quantity import InputFile, Numbers, Setting, declared, quantity, setting
from escapement.base.units import factor
from escapement.mechanisms.kind import np
from escapement.mechanisms.two_bodies import TwoBodies

if TYPE_CHECKING:
    from escapement.mechanisms import chains
else:
    chains = Lazy("escapement.mechanisms.chains")

_MOST_FOLD = 1000

Rows = Sequence[Sequence[Sequence[float]]]
"""Chains of rows x, y and bulge."""


class ChainSetting(Numbers):
    """Chains of lines and arcs; a row is a point [m] and the bulge of what begins there."""

    def check(self, label: str, value: Any) -> Any:
        """`value` as tuples of chains of rows of three numbers."""
        rule = "a list of chains, each of two rows x, y or x, y, bulge or more"
        found = []
        try:
            for chain in value:
                rows = [[float(number) for number in row] for row in chain]
                if len(rows) < 2 or not all(2 <= len(row) <= 3 for row in rows):
                    raise ValueError
                found.append(tuple((*row, 0.0)[:3] for row in rows))
        except (TypeError, ValueError):
            raise validate.fail(label, rule, type(value).__name__, self.remedy) from None
        if not found or not np.isfinite(np.concatenate(found)).all():
            raise validate.fail(label, f"{rule}, of finite numbers", len(found), self.remedy)
        return tuple(found)

    read = check

    def to_si(self, values: Any) -> Any:
        """Chains that were read, in SI."""
        scale = factor("length", self.system)
        return tuple(tuple((x * scale, y * scale, b) for x, y, b in rows) for rows in values)


def _chains(body: str) -> dict[str, Any]:
    return setting(ChainSetting(
        long_name=f"outline of the {body}: chains of rows x, y, bulge", unit="length",
        remedy="give for example [[(0, 0), (1, 0), (0, 1), (0, 0)]]", required=True,
    ))  # fmt: skip


class Fold(Setting):
    """How many equal sectors a body has; a drawing tells it by itself."""

    def check(self, label: str, value: Any) -> int:
        """`value` as a whole number."""
        return validate.integer(label, value, 1, self.remedy, _MOST_FOLD)


def _fold(body: str) -> dict[str, Any]:
    return setting(Fold(
        long_name=f"equal sectors of the {body}, of which one is given",
        remedy="give the number, 1 for a whole body",
    ))  # fmt: skip


@dataclass(frozen=True, repr=False)
class Outlines(TwoBodies):
    """Two bodies of one's own that turn about parallel axes and touch anywhere.

    A chain is a list of rows x, y and the bulge of the line or arc that begins there, as in DXF:
    the tangent of a quarter of the angle by which an arc turns, 0 for a line. It has the material
    on its left, and is closed if it ends where it starts.

    Parameters
    ----------
    driver, follower : sequence of chains
        Outlines [m], each about its own axis.
    centre_distance : float
        Distance of the axes [m]; the follower's lies on the x axis of the driver.
    driver_fold, follower_fold : int
        Equal sectors of a body, of which the chains describe one. A chain that ends where the
        next sector begins goes on there.
    driver_start, follower_start : float, optional
        Angles from which a motion starts [rad]. Default: 0.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule. `motion_check` tells whether the bodies overlap at the
        start.
    """

    kind: ClassVar[str] = "outlines"
    summary: ClassVar[str] = "two bodies of one's own, from a drawing of their outlines"

    driver: Rows = field(metadata=_chains("driver"))
    follower: Rows = field(metadata=_chains("follower"))
    centre_distance: float = field(metadata=quantity(
        "distance of the axes", "length", exclusive=True, remedy="give the distance"
    ))  # fmt: skip
    driver_fold: int = field(default=1, metadata=_fold("driver"))
    follower_fold: int = field(default=1, metadata=_fold("follower"))

    def __post_init__(self) -> None:
        self.check_fields()
        reach = [
            max(math.hypot(x, y) for rows in each for x, y, _ in rows)
            for each in (self.driver, self.follower)
        ]
        if not sum(reach) > self.centre_distance:
            raise validate.fail(
                "centre_distance", f"less than {sum(reach):.6g} m, where the bodies meet",
                self.centre_distance, "give it in m",
            )  # fmt: skip

    def _shown(self) -> list[tuple[str, Any, str]]:
        # a study file identifies such a mechanism by its repr, so different outlines must have
        # different ones
        rows = [row for row in super()._shown() if row[0] not in ("driver", "follower")]
        text = repr((self.driver, self.follower)).encode()
        return [*rows, ("checksum", f"{zlib.crc32(text):08x}", "")]

    @classmethod
    def options(cls) -> dict[str, Setting]:
        """The options of the command line: a drawing instead of the outlines."""
        file = InputFile(
            name="drawing", key="drawing", metavar="FILE.dxf", required=True,
            long_name="drawing with the layers DRIVER and FOLLOWER, and a point at each axis",
        )  # fmt: skip
        left_out = ("driver", "follower", "centre_distance", "driver_fold", "follower_fold")
        known = {name: entry for name, entry in declared(cls).items() if name not in left_out}
        return {"drawing": file, **known}

    @classmethod
    def from_options(cls, **given: Any) -> Outlines:
        """The mechanism of a drawing, and of the numbers that were typed with it."""
        from escapement.mechanisms.drawing_files import read_outlines

        return cls(*read_outlines(given.pop("drawing")), **given)

    @property
    def crank_radius(self) -> float:
        """Unit of length, the distance of the axes [m]."""
        return self.centre_distance

    @property
    def axes_distance(self) -> float:
        """Distance of the axes in that unit."""
        return 1.0

    @cached_property
    def driver_chains(self) -> list[chains.Chain]:
        """The driver's outline over the distance of the axes."""
        return [chains.from_rows(rows, self.centre_distance) for rows in self.driver]

    @cached_property
    def follower_chains(self) -> list[chains.Chain]:
        """The follower's outline over the distance of the axes."""
        return [chains.from_rows(rows, self.centre_distance) for rows in self.follower]

    @property
    def start(self) -> tuple[float, float]:
        """Angles of driver and follower from which a motion starts [rad]."""
        return self.driver_start or 0.0, self.follower_start or 0.0
