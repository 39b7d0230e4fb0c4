"""Wheels whose pins and slots may have errors: which pin meets which slot, and whether it fits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.lazy import Lazy
from escapement.base.quantity import Numbers, declared, quantity, setting
from escapement.mechanisms.kind import ArrayLike, Wheel, np, slotted
from escapement.mechanisms.path import Pair
from escapement.mechanisms.protocol import FloatArray, checked
from escapement.mechanisms.wheel_checks import IMPERFECT, LENGTHS, check_lengths

pattern: Any = Lazy("escapement.mechanisms.pattern")


def centre_distance_error(of: str) -> Any:
    """Field with the error of a centre distance."""
    return field(default=0.0, metadata=quantity(
        f"error of the centre distance{of}", "length", minimum=-math.inf,
        note=", positive where it is too long", remedy="give the error, 0 for none"
    ))  # fmt: skip


def each(part: str, error: str, unit: str) -> Any:
    """Field with an error of each pin or slot."""
    remedy = f"give one number for each {part}, or leave it out"
    entry = Numbers(long_name=f"{error} of each {part}", unit=unit, remedy=remedy, metavar="X,X,..")
    return field(default=(), metadata=setting(entry))


class ImperfectWheel(Wheel):
    """Base of the wheels with a `centre_distance_error`, and with errors of pins and slots."""

    centre_distance_error: float
    pin_angle_errors: Sequence[float] = ()
    crank_radius_errors: Sequence[float] = ()
    slot_angle_errors: Sequence[float] = ()
    slot_offsets: Sequence[float] = ()

    def check_errors(self) -> None:
        """Store the errors of pins and slots as tuples; a list of zeros counts as none."""
        for name, entry in declared(type(self)).items():
            if not isinstance(entry, Numbers) or getattr(self, name) is entry.default:
                continue
            numbers = entry.read(name, getattr(self, name))
            part, count = self._parts(name)
            if numbers and len(numbers) != count:
                rule = f"as long as there are {part}s, {count}"
                raise validate.fail(name, rule, len(numbers), entry.remedy)
            vars(self)[name] = numbers if any(numbers) else ()
        check_lengths(vars(self), self.crank_radius, self.plain_crank)

    def _parts(self, name: str) -> tuple[str, int]:
        """Whether a list has a number for each pin or slot, and how many these are."""
        return ("slot", self.slots) if name.startswith("slot") else ("pin", self.pins)

    @classmethod
    def counts(cls, given: Mapping[str, Any]) -> dict[str, int]:
        """How many errors of each kind a wheel has, by name; empty for numbers of no wheel."""
        entries = declared(cls)
        numbers = {name: value for name, value in given.items() if name in entries}
        for name in (*IMPERFECT, *LENGTHS):
            numbers.pop(name, None)
        try:
            wheel = cls(**numbers)
        except (TypeError, InvalidValue):
            return {}
        return wheel.error_counts

    @property
    def error_counts(self) -> dict[str, int]:
        """How many errors of each kind it has, by the name of the list."""
        lists = [name for name, entry in declared(type(self)).items() if isinstance(entry, Numbers)]
        return {name: self._parts(name)[1] for name in lists}

    @property
    def errors(self) -> dict[str, float]:
        """The errors of its parts by the names that studies use [SI]; empty if it is perfect."""
        if self.perfect:
            return {}
        found = {"centre_distance_error": self.centre_distance_error}
        for name, count in self.error_counts.items():
            values = getattr(self, name) or (0.0,) * count
            found |= {f"{name}_{i}": float(value) for i, value in enumerate(values)}
        # without a size it can have errors of angles alone
        return {k: v for k, v in found.items() if self.crank_radius or "angle" in k}

    @property
    def path_numbers(self) -> dict[str, Any]:
        """Vectors of its perfect path, and the turns of driver and follower from pin to pin.

        They are the first arguments of `pattern.lay_pattern`.
        """
        arms = tuple(map(float, (*self.arms, self._forward)))
        return {"arms": arms, "turns": (float(self.cell_angle), float(self.follower_step))}

    @cached_property
    def _laid_out(self) -> Any:
        """Its pattern and the first impossible engagement, as `pattern_of` gives them."""
        unit = self.crank_radius or 1.0

        def errors(name: str, scale: float = 1.0) -> Any:
            return np.array(getattr(self, name) or (0.0,) * self._parts(name)[1]) / scale

        return pattern.pattern_of(
            **self.path_numbers,
            longer=self.centre_distance_error / unit,
            pin=self.contact_radius,
            pins=np.stack([errors("pin_angle_errors"), errors("crank_radius_errors", unit)], -1),
            slots=np.stack([errors("slot_angle_errors"), errors("slot_offsets", unit)], -1),
        )

    @cached_property
    def perfect(self) -> bool:
        """Whether it has no error."""
        return not any(getattr(self, name) for name in IMPERFECT)

    @property
    def pattern(self) -> Any:
        """The engagements after which pins and slots meet again, as `pattern_of` gives them."""
        return self._laid_out[0]

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """The engagements of its pattern, one if its parts are perfect.

        InvalidValue if a pin cannot drive its slot.
        """
        if self.misfit:
            raise InvalidValue(self.misfit)
        return super().pairs if self.perfect else self._pairs

    @cached_property
    def _pairs(self) -> tuple[Pair, ...]:
        return pattern.pairs_of(self.pattern)  # type: ignore[no-any-return]

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """As in `Wheel`, with the errors of pins and slots."""
        if self.perfect:
            return super().follower_angle(theta)
        angles = np.asarray(theta, dtype=float)
        driver_angle = np.empty_like(angles)
        for pair, here, number, local in self._pairs_at(angles):
            engaged = pair.follower_angle(np.minimum(local, pair.edges[-1]))
            driver_angle[here] = number * self.follower_step + engaged
        return driver_angle

    def transmission(self, theta: ArrayLike) -> slotted.Transmission:
        """As in `Wheel`, with the errors of pins and slots."""
        if self.perfect:
            return super().transmission(theta)
        angles = np.asarray(theta, dtype=float)
        found = np.zeros((3, *angles.shape))
        for pair, here, _number, local in self._pairs_at(angles):
            at = slotted.transmission(pair.path, local)
            moves = local <= pair.edges[-1]
            found[:, here] = np.where(moves, (at.g, at.u, at.dg), 0.0)
        return slotted.Transmission(*found)

    def jerk(self, theta: ArrayLike) -> FloatArray:
        """As in `Wheel`; InvalidValue for a wheel with errors of its parts."""
        checked(self)
        return super().jerk(theta)

    def _pairs_at(self, theta: FloatArray) -> Iterator[tuple[Pair, Any, FloatArray, FloatArray]]:
        """Each pair of a pin and a slot that holds some of the driver angles.

        With it come which angles these are, their numbers of engagements, and the angles from
        where its pin crosses the line of centres; those behind the exit are in the dwell.
        """
        rows, size, cell = self.pairs, len(self.pairs), self.cell_angle
        starts = np.array([row.delay + row.edges[0] for row in rows])
        # the last engagement that has begun is near the one of perfect parts
        near = np.floor((theta - self.breaks[0]) / cell)
        number = near - 1.0
        for k in (near, near + 1.0):
            begun = k * cell + starts[(k % size).astype(int)] <= theta
            number = np.where(begun, k, number)
        for k, row in enumerate(rows):
            here = number % size == k
            if here.any():
                numbers_here = number[here]
                yield row, here, numbers_here, theta[here] - numbers_here * cell - row.delay

    @cached_property
    def misfit(self) -> str:
        """Which pin cannot drive which slot, and where; "" if all can."""
        k = -1 if self.perfect else self._laid_out[1]
        if k < 0:
            return ""
        return (
            f"pin {k % self.pins} cannot drive slot {k % self.slots}, which it meets "
            f"{math.degrees(k * self.cell_angle):.6g} degrees behind the first dead centre: the "
            "errors of the parts are too large; make them smaller"
        )
