"""The torque of a drive over the driver angle that it has turned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from escapement.base import validate
from escapement.base.errors import InputFileError, InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.quantity import Quantity
from escapement.base.text import Shown

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]
else:
    np, FloatArray = Lazy("numpy"), Any

MOST_POINTS = 1000
MOST_KNOTS = 256
"""Points of a curve within one cell: each begins a piece of the motion."""


@dataclass(frozen=True, repr=False)
class TorqueCurve(Shown):
    """Torque over the driver angle turned, linear between points.

    Parameters
    ----------
    angle : sequence of float
        Driver angles turned since the start of the motion [rad], ascending from 0; at most 1000.
    torque : sequence of float
        Torque on the driver there [N m], >= 0 and somewhere > 0.
    periodic : bool
        Whether it repeats after the last angle, with whose torque it then begins again. Else
        the last torque holds beyond.

    Raises
    ------
    InvalidValue
        When the curve breaks a rule.
    """

    angle: Sequence[float]
    torque: Sequence[float]
    periodic: bool = False

    def __post_init__(self) -> None:
        remedy = "give a torque for each angle"
        angle, torque = (
            validate.numbers(f"{name} of the torque curve", values, remedy).reshape(-1)
            for name, values in (("angle", self.angle), ("torque", self.torque))
        )
        if angle.size != torque.size or not 2 <= angle.size <= MOST_POINTS:
            shown = f"{angle.size} angles and {torque.size} torques"
            rule = f"2 to {MOST_POINTS} angles and as many torques"
            raise InvalidValue(f"the torque curve must have {rule}, got {shown}; {remedy}")
        if angle[0] != 0.0 or (np.diff(angle) <= 0.0).any():
            remedy = "the motion starts at angle 0; leave out points that come twice"
            raise validate.fail("angle of the torque curve", "ascending from 0", angle, remedy)
        if (torque < 0.0).any() or not torque.any():
            remedy = "a drive that gives no more torque has 0"
            raise validate.fail(
                "torque of the torque curve", "at least 0, not all 0", torque, remedy
            )
        periodic = validate.truth("periodic", self.periodic)
        if periodic and torque[0] != torque[-1]:
            remedy = "end with the torque with which it begins"
            raise validate.fail(
                "torque of a periodic curve", "the same at both ends", torque, remedy
            )
        vars(self).update(angle=tuple(angle.tolist()), torque=tuple(torque.tolist()))
        vars(self).update(periodic=periodic)

    @classmethod
    def from_csv(cls, path: str | PathLike[str], periodic: bool = False) -> TorqueCurve:
        """Read a curve of two columns: angles [rad], and torques [N m].

        Parameters
        ----------
        path : path
            Columns apart by commas, semicolons, tabs or blanks. A line of headings may come
            first, without any number; angles are in degrees where theirs ends in deg. Lines
            that start with # are skipped.
        periodic : bool
            Whether the curve repeats.

        Raises
        ------
        MissingInput, InputFileError
            When the file is not there, or holds no such curve.
        """
        from escapement.base.columns import read_columns

        angle, torque = read_columns(path, "torque curve", by_order=True, default="rad").angles
        try:
            return cls(angle, torque, periodic)  # type: ignore[arg-type]
        except InvalidValue as error:
            raise InputFileError(f"torque curve {path}: {error}") from None

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> TorqueCurve:
        """The curve that a table of a study file gives, by its points or by a file."""
        keys = ("file",) if "file" in table else ("angle", "torque")
        validate.known_keys(table, (*keys, "periodic"), "in the table torque")
        periodic = table.get("periodic", False)
        if "file" in table:
            if not isinstance(table["file"], str | Path):
                raise validate.fail("torque.file", "a file name", table["file"], "put it in quotes")
            return cls.from_csv(table["file"], periodic)
        return cls(table.get("angle", ()), table.get("torque", ()), periodic)

    def as_table(self) -> dict[str, Any]:
        """The curve as `from_table` takes it, in types of JSON."""
        return {"angle": [*self.angle], "torque": [*self.torque], "periodic": self.periodic}

    def _shown(self) -> list[tuple[str, Any, str]]:
        span = f"{min(self.torque):.6g} to {self.greatest:.6g}"
        points = ("points", len(self.angle), ""), ("angle", self.angle[-1], "rad")
        return [*points, ("torque", span, "N m"), ("periodic", self.periodic, "")]

    def __mul__(self, factor: float) -> TorqueCurve:
        """The curve with its torque multiplied by a factor."""
        return TorqueCurve(self.angle, [factor * x for x in self.torque], self.periodic)

    def behind(self, ratio: float) -> TorqueCurve:
        """The curve as the driver sees it, which turns `ratio` times while a barrel turns once."""
        angles = [ratio * angle for angle in self.angle]
        torques = [torque / ratio for torque in self.torque]
        return TorqueCurve(angles, torques, self.periodic)

    @property
    def greatest(self) -> float:
        """Greatest torque [N m]."""
        return max(self.torque)

    @property
    def period(self) -> float:
        """Angle after which it repeats [rad], 0 where it does not."""
        return self.angle[-1] if self.periodic else 0.0

    def __call__(self, driver_angle: Any) -> Any:
        """Torque after driver angles turned [N m]."""
        return np.interp(driver_angle, self.angle, self.torque, period=self.period or None)

    @cached_property
    def _work(self) -> FloatArray:
        """Work up to each point [J]."""
        angle, torque = np.array(self.angle), np.array(self.torque)
        steps = 0.5 * np.diff(angle) * (torque[1:] + torque[:-1])
        return np.concatenate([[0.0], np.cumsum(steps)])

    def work(self, driver_angle: Any) -> Any:
        """Work of the drive over the angles turned [J]."""
        laps, rest = np.divmod(driver_angle, self.period) if self.periodic else (0.0, driver_angle)
        last = np.searchsorted(self.angle, rest, side="right") - 1
        since = rest - np.array(self.angle)[last]
        mean = 0.5 * (np.array(self.torque)[last] + self(rest))
        return laps * self._work[-1] + self._work[last] + since * mean

    def knots(self) -> FloatArray:
        """Period, angles and torques over the greatest one, as `Scene.torque` has them."""
        return np.array([self.period, *self.angle, *(x / self.greatest for x in self.torque)])

    def most_within(self, angle: float) -> int:
        """The most points that lie within a stretch of an angle [rad]."""
        angles = np.array(self.angle)
        if self.periodic:
            laps = np.arange(np.ceil(angle / self.period) + 1.0)[:, None]
            angles = (laps * self.period + angles).reshape(-1)
        within = np.searchsorted(angles, angles + angle, side="right") - np.arange(angles.size)
        return int(within.max())


class Torque(Quantity):
    """The torque of a drive: a number, or a `TorqueCurve`."""

    def check(self, label: str, value: Any) -> Any:
        """`value` as a number that obeys the rule, or the curve that it is."""
        return value if isinstance(value, TorqueCurve) else super().check(label, value)

    def parse(self, label: str, text: str) -> Any:
        """As `check`, of a word on the command line, which may name the file of a curve."""
        named = text.lower().endswith(".csv")
        return TorqueCurve.from_csv(text) if named else super().parse(label, text)
