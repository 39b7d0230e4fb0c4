"""The torque of a drive over the driver angle that it has turned, over its speed, or over both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

from escapement.base import validate
from escapement.base.errors import InputFileError, InvalidValue
from escapement.base.lazy import FloatArray, np
from escapement.base.quantity import Quantity
from escapement.base.text import Shown
from escapement.model.load_curve import work_up_to

MOST_POINTS = 1000
MOST_KNOTS = 256
"""Points of a curve within one cell: each begins a piece of the motion."""


@dataclass(frozen=True, repr=False)
class TorqueCurve(Shown):
    """Torque over the driver angle turned, over the driver speed, or over both.

    Over the angle it is linear between points. Over the speed a cubic spline goes through them.

    Parameters
    ----------
    angle : sequence of float
        Driver angles turned since the start of the motion [rad], ascending from 0; at most 1000.
        Without any the torque depends on the speed alone.
    torque : sequence of float
        Torque on the driver there [N m]; with angles and speeds a row for each angle. At rest it
        is >= 0 and somewhere > 0.
    periodic : bool
        Whether it repeats after the last angle, with whose torque it then begins again. Else
        the last torque holds beyond.
    speed : sequence of float
        Driver speeds [rad/s], ascending from 0; at most 1000. No motion may be faster than the
        last one. Without any the torque depends on the angle alone.

    Raises
    ------
    InvalidValue
        When the curve breaks a rule.
    """

    angle: Sequence[float] = ()
    torque: Sequence[Any] = ()
    periodic: bool = False
    speed: Sequence[float] = ()

    def __post_init__(self) -> None:
        given = len(self.speed) if hasattr(self.speed, "__len__") else 1
        by_angle = not (given and hasattr(self.angle, "__len__") and len(self.angle) == 0)
        angle = _axis("angle", self.angle) if by_angle else np.zeros(1)
        speed = _axis("speed", self.speed) if given else np.zeros(1)
        remedy = f"give a torque for each {'angle' if by_angle else 'speed'}"
        if by_angle and given:
            remedy = "give a row for each angle, with a torque for each speed"
        torque = _numbers("torque", self.torque, remedy)
        if torque.size != angle.size * speed.size:
            rule = f"2 to {MOST_POINTS} angles and as many torques"
            if given:
                rule = "a torque for each speed" + " at each angle" * by_angle
            counts = {"angles": angle.size * by_angle, "speeds": speed.size * (given > 0)}
            shown = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
            shown += f" and {torque.size} torques"
            raise InvalidValue(f"the torque curve must have {rule}, got {shown}; {remedy}")
        table = torque.reshape(angle.size, speed.size)
        if (table[:, 0] < 0.0).any() or not table[:, 0].any():
            remedy = "a drive that gives no more torque has 0"
            rule, at_rest = "at least 0, not all 0", " at rest" * (given > 0)
            raise validate.fail(f"torque of the torque curve{at_rest}", rule, torque, remedy)
        periodic = validate.truth("periodic", self.periodic)
        if periodic and (not by_angle or (table[0] != table[-1]).any()):
            remedy = "end with the torque with which it begins"
            raise validate.fail(
                "torque of a periodic curve", "the same at both ends", torque, remedy
            )
        rows = tuple(map(tuple, table.tolist()))
        flat = tuple(torque.reshape(-1).tolist())
        vars(self).update(angle=tuple(angle.tolist()) if by_angle else (), periodic=periodic)
        vars(self).update(speed=tuple(speed.tolist()) if given else ())
        vars(self).update(torque=rows if by_angle and given else flat)

    @classmethod
    def from_csv(cls, path: str | PathLike[str], periodic: bool = False) -> TorqueCurve:
        """Read a curve of two columns: angles [rad], and torques [N m].

        Parameters
        ----------
        path : path
            Columns apart by commas, semicolons, tabs or blanks. A line of headings may come
            first, without any number; angles are in degrees where theirs ends in deg. A column
            called speed holds driver speeds [rad/s], or in rpm where its heading ends so; it comes
            before the torque, and behind the angle if there is one, of which each then has a row
            for every speed. Lines that start with # are skipped.
        periodic : bool
            Whether the curve repeats.

        Raises
        ------
        MissingInput, InputFileError
            When the file is not there, or holds no such curve.
        """
        from escapement.base.columns import read_columns, read_speeds

        speeds = read_speeds(path, "torque curve")
        if speeds is None:
            given = read_columns(path, "torque curve", by_order=True, default="rad").angles
            angle, torque, speed = *given, ()
        else:
            angle, torque, speed = _grid(path, *speeds)
        try:
            return cls(angle, torque, periodic, speed)  # type: ignore[arg-type]
        except InvalidValue as error:
            raise InputFileError(f"torque curve {path}: {error}") from None

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> TorqueCurve:
        """The curve that a table of a study file gives, by its points or by a file."""
        keys = ("file",) if "file" in table else ("angle", "torque", "speed")
        validate.known_keys(table, (*keys, "periodic"), "in the table torque")
        periodic = table.get("periodic", False)
        if "file" in table:
            if not isinstance(table["file"], str | Path):
                raise validate.fail("torque.file", "a file name", table["file"], "put it in quotes")
            return cls.from_csv(table["file"], periodic)
        return cls(
            table.get("angle", ()), table.get("torque", ()), periodic, table.get("speed", ())
        )

    def as_table(self) -> dict[str, Any]:
        """The curve as `from_table` takes it, in types of JSON."""
        found = {"angle": [*self.angle], "torque": [*self.torque], "speed": [*self.speed]}
        return {name: x for name, x in found.items() if x} | {"periodic": self.periodic}

    def _shown(self) -> list[tuple[str, Any, str]]:
        span = f"{self.table.min():.6g} to {self.table.max():.6g}"
        ends = ("angle", self.angle, "rad"), ("speed", self.speed, "rad/s")
        axes = [(name, values[-1], unit) for name, values, unit in ends if values]
        points = "points", self.table.size, ""
        return [points, *axes, ("torque", span, "N m"), ("periodic", self.periodic, "")]

    @cached_property
    def table(self) -> FloatArray:
        """Its torques with a row for each angle and a column for each speed; one without any."""
        torques: FloatArray = np.array(self.torque)
        return torques.reshape(max(len(self.angle), 1), max(len(self.speed), 1))

    @property
    def at_rest(self) -> tuple[float, ...]:
        """Torques at rest, at its angles [N m]."""
        return tuple(self.table[:, 0].tolist())

    @property
    def at_start(self) -> float | TorqueCurve:
        """The torque at the first angle: over the speed where it depends on that."""
        return TorqueCurve((), self.table[0], speed=self.speed) if self.speed else self.at_rest[0]

    def __mul__(self, factor: float) -> TorqueCurve:
        """The curve with its torque multiplied by a factor."""
        return replace(self, torque=(factor * self.table).tolist())

    def behind(self, ratio: float) -> TorqueCurve:
        """The curve as the driver sees it, which turns `ratio` times while a barrel turns once."""
        angle, speed = ([ratio * x for x in axis] for axis in (self.angle, self.speed))
        return TorqueCurve(angle, (self.table / ratio).tolist(), self.periodic, speed)

    @property
    def greatest(self) -> float:
        """Greatest torque at rest [N m]."""
        return max(self.at_rest)

    @cached_property
    def _spline(self) -> Any:
        """The torque over the speed, as a share of the last one, at all angles."""
        from scipy.interpolate import CubicSpline  # it takes long to import

        x = np.array(self.speed) / self.speed[-1]
        return CubicSpline(x, self.table.T, extrapolate=False)

    @property
    def level_speeds(self) -> FloatArray:
        """Speeds at which a torque over the speed alone is greatest or least [rad/s]."""
        found = self._spline.derivative().roots(discontinuity=False, extrapolate=False)[0]
        return np.asarray(found[np.isfinite(found)] * self.speed[-1])

    def fall(self) -> FloatArray:
        """How much less torque there is at a speed than at rest, as `Scene.fall` has it."""
        coefficients = -np.moveaxis(self._spline.c, 0, 2) / self.greatest
        coefficients[:, :, 3] += np.array(self.at_rest) / self.greatest
        rows = np.moveaxis(coefficients, 1, 0).reshape(-1)
        return np.concatenate([[len(self.speed)], self._spline.x, rows])

    @property
    def period(self) -> float:
        """Angle after which it repeats [rad], 0 where it does not."""
        return self.angle[-1] if self.periodic else 0.0

    def __call__(self, driver_angle: Any, speed: Any = 0.0) -> Any:
        """Torque after driver angles turned, at driver speeds, NaN beyond the last [N m]."""
        rows = self._spline(np.asarray(speed) / self.speed[-1]) if self.speed else self.table[:, 0]
        if len(self.angle) < 2:
            return rows[..., 0] + 0.0 * np.asarray(driver_angle)
        if not self.speed:
            return np.interp(driver_angle, self.angle, rows, period=self.period or None)
        turned = np.mod(driver_angle, self.period) if self.periodic else np.asarray(driver_angle)
        last = np.clip(
            np.searchsorted(self.angle, turned, side="right") - 1, 0, len(self.angle) - 2
        )
        angle = np.array(self.angle)
        share = np.minimum((turned - angle[last]) / (angle[last + 1] - angle[last]), 1.0)
        before, after = (
            np.take_along_axis(rows, k[..., None], -1)[..., 0] for k in (last, last + 1)
        )
        return before + share * (after - before)

    def work(self, driver_angle: Any) -> Any:
        """Work of the torque at rest over the angles turned [J]."""
        return work_up_to(driver_angle, np.array(self.angle), self.table[:, 0], self.period)

    def knots(self) -> FloatArray:
        """Period, angles and torques over the greatest one, as `Scene.torque` has them."""
        return np.array([self.period, *self.angle, *(x / self.greatest for x in self.at_rest)])

    def most_within(self, angle: float) -> int:
        """The most points that lie within a stretch of an angle [rad]."""
        angles = np.array(self.angle)
        if self.periodic:
            laps = np.arange(np.ceil(angle / self.period) + 1.0)[:, None]
            angles = (laps * self.period + angles).reshape(-1)
        within = np.searchsorted(angles, angles + angle, side="right") - np.arange(angles.size)
        return int(within.max())


def _numbers(name: str, values: Any, remedy: str) -> FloatArray:
    """Numbers of a torque curve."""
    return validate.numbers(f"{name} of the torque curve", values, remedy)


def _axis(name: str, values: Any) -> FloatArray:
    """The angles or the speeds of a torque curve."""
    found = _numbers(name, values, f"give a torque for each {name}").reshape(-1)
    if not 2 <= found.size <= MOST_POINTS:
        rule, remedy = f"2 to {MOST_POINTS} {name}s", f"give a torque for each {name}"
        raise InvalidValue(f"the torque curve must have {rule}, got {found.size}; {remedy}")
    if found[0] != 0.0 or (np.diff(found) <= 0.0).any():
        remedy = f"the motion starts at {name} 0; leave out points that come twice"
        raise validate.fail(f"{name} of the torque curve", "ascending from 0", found, remedy)
    return found


def _grid(path: Any, angle: Any, speed: FloatArray, torque: FloatArray) -> tuple[Any, Any, Any]:
    """Angles, torques and speeds of a curve from the columns of a file."""
    if angle is None:
        return (), torque, speed
    angles, speeds = np.unique(angle), np.unique(speed)
    order = np.lexsort((speed, angle))
    whole = np.array(np.meshgrid(angles, speeds, indexing="ij")).reshape(2, -1)
    if not np.array_equal(whole, np.array([angle, speed])[:, order]):
        got = f"{angle.size} rows for {angles.size} angles and {speeds.size} speeds"
        remedy = "give a row for each speed at each angle"
        raise InputFileError(f"torque curve {path} must have each pair once, got {got}; {remedy}")
    return angles, torque[order].reshape(angles.size, speeds.size), speeds


class Torque(Quantity):
    """The torque of a drive: a number, or a `TorqueCurve`."""

    def check(self, label: str, value: Any) -> Any:
        """`value` as a number that obeys the rule, or the curve that it is."""
        return value if isinstance(value, TorqueCurve) else super().check(label, value)

    def parse(self, label: str, text: str) -> Any:
        """As `check`, of a word on the command line, which may name the file of a curve."""
        named = text.lower().endswith(".csv")
        return TorqueCurve.from_csv(text) if named else super().parse(label, text)
