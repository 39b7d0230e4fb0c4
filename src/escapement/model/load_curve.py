"""A load that changes with the follower's angle: points of a curve, or a weight out of balance."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

from escapement.base import validate
from escapement.base.errors import InputFileError, InvalidValue
from escapement.base.lazy import FloatArray, np
from escapement.base.quantity import Setting
from escapement.base.text import Shown

MOST_POINTS = 1000
_SAME = 1e-9
"""A period is that of a step, or of a turn, within this share of it."""


@dataclass(frozen=True, repr=False)
class Unbalance(Shown):
    """A weight out of balance on the follower, with the torque moment sin(phi + angle).

    It is a load where it is positive, whichever way the follower turns.

    Parameters
    ----------
    moment : float
        Weight times the distance of the centre of mass from the axis, m g e [N m], > 0.
    angle : float
        Angle of the centre of mass past its lowest place while phi is 0 [rad], in the sense in
        which the follower turns. phi is the follower angle of a motion: 0 where the first slot is
        at its dead centre.

    Raises
    ------
    InvalidValue
        When a number breaks its rule.
    """

    moment: float
    angle: float = 0.0

    _units = {"moment": "N m", "angle": "rad"}  # noqa: RUF012
    period = 2.0 * math.pi

    def __post_init__(self) -> None:
        moment = validate.positive("moment", self.moment, "give m g e in N m")
        angle = validate.number("angle", self.angle, "give the angle in rad")
        vars(self).update(moment=moment, angle=angle)

    def __call__(self, phi: Any) -> Any:
        """Torque at follower angles [N m]."""
        return self.moment * np.sin(np.asarray(phi) + self.angle)

    def work(self, begin: Any, end: Any) -> Any:
        """Work against it from one follower angle to another [J]."""
        # a product keeps the digits of small turns
        middle, half = 0.5 * (begin + end) + self.angle, 0.5 * (end - begin)
        return 2.0 * self.moment * np.sin(middle) * np.sin(half)

    def __mul__(self, factor: float) -> Unbalance:
        """The same with its moment multiplied by a factor."""
        return Unbalance(factor * self.moment, self.angle)

    def knots_between(self, begin: float, end: float) -> list[float]:
        """Follower angles at which it is not smooth: none."""
        return []

    def as_table(self) -> dict[str, Any]:
        """As `load_of_table` takes it, in types of JSON."""
        return {"moment": self.moment, "angle": self.angle}


@dataclass(frozen=True, repr=False)
class LoadCurve(Shown):
    """A load over the follower angle, linear between points, that repeats.

    It is a torque against the follower's sense where it is positive, whichever way the follower
    turns: a cam or a spring, not friction.

    Parameters
    ----------
    angle : sequence of float
        Follower angles [rad], ascending; the last is one step, or one turn, behind the first. The
        angle is 0 where the first slot is at its dead centre.
    torque : sequence of float
        Torque there [N m], of any sign; the last is the first.

    Raises
    ------
    InvalidValue
        When the curve breaks a rule.
    """

    angle: Sequence[float]
    torque: Sequence[float]

    def __post_init__(self) -> None:
        remedy = "give a torque for each angle"
        angle, torque = (
            validate.numbers(f"{name} of the load curve", values, remedy).reshape(-1)
            for name, values in (("angle", self.angle), ("torque", self.torque))
        )
        if angle.size != torque.size or not 2 <= angle.size <= MOST_POINTS:
            shown = f"{angle.size} angles and {torque.size} torques"
            rule = f"2 to {MOST_POINTS} angles and as many torques"
            raise InvalidValue(f"the load curve must have {rule}, got {shown}; {remedy}")
        if (np.diff(angle) <= 0.0).any():
            remedy = "leave out points that come twice"
            raise validate.fail("angle of the load curve", "ascending", angle, remedy)
        if torque[0] != torque[-1]:
            remedy = "end with the torque with which it begins, a step or a turn later"
            got = f"{torque[0]!s} and {torque[-1]!s}"
            raise validate.fail("torque of the load curve", "the same at both ends", got, remedy)
        vars(self).update(angle=tuple(angle.tolist()), torque=tuple(torque.tolist()))

    @classmethod
    def from_csv(cls, path: str | PathLike[str]) -> LoadCurve:
        """Read a curve of two columns, as `TorqueCurve.from_csv` does.

        Raises
        ------
        MissingInput, InputFileError
            When the file is not there, or holds no such curve.
        """
        from escapement.base.columns import read_columns

        angle, torque = read_columns(path, "load curve", by_order=True, default="rad").angles
        try:
            return cls(angle, torque)  # type: ignore[arg-type]
        except InvalidValue as error:
            raise InputFileError(f"load curve {path}: {error}") from None

    def as_table(self) -> dict[str, Any]:
        """As `load_of_table` takes it, in types of JSON."""
        return {"angle": [*self.angle], "torque": [*self.torque]}

    def _shown(self) -> list[tuple[str, Any, str]]:
        span = f"{min(self.torque):.6g} to {max(self.torque):.6g}"
        return [
            ("points", len(self.angle), ""),
            ("period", self.period, "rad"),
            ("torque", span, "N m"),
        ]

    def __mul__(self, factor: float) -> LoadCurve:
        """The curve with its torque multiplied by a factor."""
        return LoadCurve(self.angle, [factor * x for x in self.torque])

    @property
    def period(self) -> float:
        """Follower angle after which it repeats [rad]."""
        return self.angle[-1] - self.angle[0]

    def __call__(self, phi: Any) -> Any:
        """Torque at follower angles [N m]."""
        return np.interp(np.mod(np.asarray(phi) - self.angle[0], self.period), *self._line)

    def slope(self, phi: Any) -> Any:
        """Torque per angle at follower angles, at a knot behind it [N m/rad]."""
        angle, torque = self._line
        turned = np.mod(np.asarray(phi) - self.angle[0], self.period)
        return (np.diff(torque) / np.diff(angle))[np.searchsorted(angle[1:-1], turned, "right")]

    @cached_property
    def _line(self) -> tuple[FloatArray, FloatArray]:
        """Angles from the first one, and torques."""
        return np.array(self.angle) - self.angle[0], np.array(self.torque)

    def _up_to(self, phi: Any) -> Any:
        return work_up_to(np.asarray(phi) - self.angle[0], *self._line, self.period)

    def work(self, begin: Any, end: Any) -> Any:
        """Work against it from one follower angle to another [J]."""
        return self._up_to(end) - self._up_to(begin)

    def knots_between(self, begin: float, end: float) -> list[float]:
        """Follower angles between two at which it is not smooth, ascending [rad]."""
        first = math.floor((begin - self.angle[0]) / self.period)
        last = math.ceil((end - self.angle[0]) / self.period)
        laps = np.arange(first, last + 1)[:, None] * self.period
        knots = (laps + np.array(self.angle[:-1])).reshape(-1)
        return [float(knot) for knot in knots if begin < knot < end]


def work_up_to(turned: Any, angle: FloatArray, torque: FloatArray, period: float) -> Any:
    """Work of a torque that is linear between angles from 0 on, over the angles turned [J].

    period : angle after which it repeats; 0 where the last torque holds beyond.
    """
    laps, rest = np.divmod(turned, period) if period else (0.0, turned)
    steps = 0.5 * np.diff(angle) * (torque[1:] + torque[:-1])
    work = np.concatenate([[0.0], np.cumsum(steps)])
    last = np.clip(np.searchsorted(angle, rest, side="right") - 1, 0, angle.size - 1)
    mean = 0.5 * (torque[last] + np.interp(rest, angle, torque))
    return laps * work[-1] + work[last] + (rest - angle[last]) * mean


Load = LoadCurve | Unbalance


def load_of_table(table: Mapping[str, Any]) -> Load:
    """The load that a table of a study file gives: by points, by a file, or by a weight."""
    if "moment" in table:
        validate.known_keys(table, ("moment", "angle"), "in the table load_curve")
        return Unbalance(table["moment"], table.get("angle", 0.0))
    keys = ("file",) if "file" in table else ("angle", "torque")
    validate.known_keys(table, keys, "in the table load_curve")
    if "file" in table:
        if not isinstance(table["file"], str | Path):
            raise validate.fail("load_curve.file", "a file name", table["file"], "put it in quotes")
        return LoadCurve.from_csv(table["file"])
    return LoadCurve(table.get("angle", ()), table.get("torque", ()))


class LoadSetting(Setting):
    """A `LoadCurve`, or an `Unbalance`."""

    def check(self, label: str, value: Any) -> Any:
        """`value` as the load that it is."""
        if not isinstance(value, Load):
            raise validate.fail(label, "a LoadCurve or an Unbalance", value, self.remedy)
        return value

    def read(self, label: str, value: Any) -> Any:
        """As `check`; in a file it is a table."""
        if isinstance(value, Mapping):
            return load_of_table(value)
        return self.check(label, value)

    def parse(self, label: str, text: str) -> LoadCurve:
        """The curve of a file that was named on the command line."""
        return LoadCurve.from_csv(text)


def steps_of(load: Load, step: float) -> int:
    """Steps of the follower after which a load repeats.

    Raises
    ------
    InvalidValue
        When it repeats neither after one step nor after one turn.
    """
    if abs(load.period - step) <= _SAME * step:
        return 1
    turn = 2.0 * math.pi
    steps = round(turn / step)
    if abs(load.period - turn) <= _SAME * turn and abs(steps * step - turn) <= _SAME * turn:
        return steps
    rule = f"periodic in a step of the follower, {step:.6g} rad, or in a whole turn of it"
    remedy = "let its last angle be so much behind the first"
    raise validate.fail("load_curve", rule, f"a period of {load.period:.6g} rad", remedy)
