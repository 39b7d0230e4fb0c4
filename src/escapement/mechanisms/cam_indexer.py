"""An indexer with a cam: the follower moves by a law of motion, and rests on a circle."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, NamedTuple

from escapement.base import validate
from escapement.base.quantity import Choice, Setting, declared, quantity, setting
from escapement.mechanisms.kind import CELL, ArrayLike, Engaging, Kind, np, table
from escapement.mechanisms.path import Path
from escapement.mechanisms.protocol import FloatArray

_ABOVE = 1e-15  # share of the greatest g, more than the rounding error of its series


class Law(NamedTuple):
    """A law of motion y(s), from 0 to 1 over s from 0 to 1, with y(1 - s) = 1 - y(s).

    corners : where it is not analytic, in the first half.
    position, slope : y and y' in the first half, 0 <= s <= 1/2.
    """

    corners: tuple[float, ...]
    position: Callable[[FloatArray], FloatArray]
    slope: Callable[[FloatArray], FloatArray]


def _of_quarters(rise: float, even: float, fall: float, *corners: float) -> Law:
    """A law whose y'' rises as a quarter of a sine, stays, and falls as a quarter of a cosine.

    It does so over half of each of these shares of s, which add up to 1.
    """
    rising, falling = rise / math.pi, fall / math.pi

    def parts(s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        last = np.maximum(s - 0.5 * (rise + even), 0.0)
        return np.minimum(s, 0.5 * rise), np.clip(s - 0.5 * rise, 0.0, 0.5 * even), last

    def turned(begun: FloatArray, flat: FloatArray, last: FloatArray) -> FloatArray:
        start = rising * (begun - rising * np.sin(begun / rising)) + (rising + 0.5 * flat) * flat
        return start + (rising + flat) * last + falling**2 * (1.0 - np.cos(last / falling))

    # y is 1/2 at the middle
    middle = rising * (0.5 * rise - rising) + 0.5 * (rising + 0.25 * even) * even
    most = 0.5 / (middle + 0.5 * (rising + 0.5 * even) * fall + falling**2)

    def slope(s: FloatArray) -> FloatArray:
        begun, flat, last = parts(s)
        start = 2.0 * rising * np.sin(0.5 * begun / rising) ** 2
        return np.asarray(most * (start + flat + falling * np.sin(last / falling)))

    return Law(corners, lambda s: most * turned(*parts(s)), slope)


LAWS = {
    "cycloidal": _of_quarters(0.5, 0.0, 0.5),
    "modified-sine": _of_quarters(0.25, 0.0, 0.75, 0.125),
    "modified-trapezoid": _of_quarters(0.25, 0.5, 0.25, 0.125, 0.375),
    "polynomial-345": Law(
        (),
        lambda s: s**3 * (10.0 + s * (-15.0 + 6.0 * s)),
        lambda s: 30.0 * (s * (1.0 - s)) ** 2,
    ),
}
"""Laws of motion by name."""


@dataclass(frozen=True, repr=False)
class CamIndexer(Engaging, Kind):
    """A cam that turns the follower by one station in each of its turns.

    The follower moves by the law within `index_angle` and rests for the remainder of the turn. Its
    losses are given by an efficiency.

    Parameters
    ----------
    stations : int
        Steps in a turn of the follower, >= 1.
    index_angle : float
        Driver angle in which it moves [rad], > 0 and at most 2 pi.
    law : str
        One of `LAWS`.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.

    Source of the laws: R. L. Norton, *Cam Design and Manufacturing Handbook*, chapter 3.
    """

    kind: ClassVar[str] = "cam-indexer"
    summary: ClassVar[str] = "indexer with a cam, by a law of motion"
    meshed: ClassVar[bool] = True
    without_parts: ClassVar[bool] = True
    reported: ClassVar[tuple[str, ...]] = (*CELL, "stations", "transmission_max")

    stations: int = field(metadata=quantity(
        "stations of the follower", minimum=1, maximum=1e6, whole=True, metavar="N",
        remedy="give the number of steps in a turn",
    ))  # fmt: skip
    index_angle: float = field(metadata=quantity(
        "driver angle in which the follower moves", "angle", exclusive=True, metavar="DEG",
        remedy="give the angle",
    ))  # fmt: skip
    law: str = field(default="modified-sine", metadata=setting(Choice(
        long_name=f"law of motion: {', '.join(LAWS)}", allowed=tuple(LAWS), metavar="NAME",
    )))  # fmt: skip

    @classmethod
    def options(cls) -> dict[str, Setting]:
        """The options of the command line, where the angle is in degrees."""
        known = declared(cls)
        return known | {"index_angle": replace(known["index_angle"], unit="degrees")}

    def __post_init__(self) -> None:
        self.check_fields()
        if not self.index_angle <= 2.0 * math.pi * (1.0 + 1e-12):
            raise validate.fail(
                "index_angle", "at most a turn, 2 pi rad", self.index_angle, "give a smaller angle"
            )

    @property
    def cell_angle(self) -> float:
        """One turn of the cam [rad]."""
        return 2.0 * math.pi

    @property
    def follower_step(self) -> float:
        """Angle of one step of the follower [rad]."""
        return 2.0 * math.pi / self.stations

    @property
    def motion_ratio(self) -> float:
        """Share of the turn in which the follower moves [-]."""
        return min(self.index_angle / self.cell_angle, 1.0)

    @cached_property
    def breaks(self) -> tuple[float, ...]:
        """Begin of the index, corners of the law, and its end, from its middle [rad]."""
        corners = LAWS[self.law].corners
        shares = (0.0, *corners, *(1.0 - share for share in reversed(corners)), 1.0)
        return tuple(self.index_angle * (share - 0.5) for share in shares)

    def _share(self, theta: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Share s of the index at driver angles of one, and its distance to an end."""
        share = np.clip(np.asarray(theta) / self.index_angle + 0.5, 0.0, 1.0)
        return share, np.minimum(share, 1.0 - share)

    def _angle_at(self, theta: FloatArray) -> FloatArray:
        share, near = self._share(theta)
        position = LAWS[self.law].position(near)
        return self.follower_step * (np.where(share <= 0.5, position, 1.0 - position) - 0.5)

    def _ratio(self, theta: ArrayLike) -> FloatArray:
        slope = LAWS[self.law].slope(self._share(theta)[1])
        return np.asarray(self.follower_step / self.index_angle * slope)

    @cached_property
    def path(self) -> Path:
        """The law as Chebyshev series, as kernels evaluate it."""
        edges, rows = table.resolved(self._ratio, self.breaks)
        # g is zero at both ends, with its slope; rounding must not make it negative near them
        rows[:, 0] += _ABOVE * self.transmission_max
        return table.table_path(edges, rows)

    @property
    def transmission_max(self) -> float:
        """Greatest transmission, in the middle of the index [-]."""
        return float(self._ratio(0.0))
