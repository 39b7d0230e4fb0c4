"""Inverse synthesis: charts of the ratio of times, and wheels for given requirements."""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.mechanisms import GearDriven
from escapement.mechanisms.gear_equation import CURVES, MOST_LOBES, lobe_ratios
from escapement.mechanisms.protocol import FloatArray
from escapement.synthesis.wheel import MotionPeaks, motion_peaks

_MOST = 100_000
_EDGE = 1e-12  # a value exactly on a limit may miss it by less than this through rounding


@dataclass(frozen=True)
class Candidate:
    """A mechanism that was found.

    mechanism : with `fixed_radius` where a size was given.
    peaks : of the follower's motion, in steps per motion time.
    closest_radius : least distance of the pin path from the axis [m], or over R0.
    """

    mechanism: GearDriven
    peaks: MotionPeaks
    closest_radius: float

    @property
    def motion_ratio(self) -> float:
        """Share of the cycle during which the follower moves, V [-]."""
        return self.peaks.motion_ratio

    @property
    def slots(self) -> int:
        """Slots of the wheel."""
        return self.mechanism.slots


def find_mechanisms(
    stations: int,
    motion_ratio: float,
    *,
    tolerance: float = 0.02,
    curves: str | Sequence[str] = CURVES[:2],
    most_lobes: int = 24,
    finest: int = 2,
    most_pins: int = 1,
    most_unused: int = 3,
    most_slots: int | None = None,
    largest_radius: float | None = None,
    shaft_radius: float = 0.0,
    planet_radius: float = 0.0,
) -> list[Candidate]:
    """Gear-driven wheels of given stations and ratio of times.

    Parameters
    ----------
    stations : int
        Stations n, >= 3.
    motion_ratio : float
        Wanted moving share V of the cycle [-].
    tolerance : float
        Greatest deviation from it [-].
    curves : str or sequence of str
        Curves to search; cognates have the same V.
    most_lobes, finest : int
        Greatest number of lobes m, and the greatest denominator of one.
    most_pins, most_unused : int
        Most pins on a planet, and most unused lobes between two used ones.
    most_slots : int, optional
        Most slots of the wheel.
    largest_radius : float, optional
        Radius of the space for gears and pin path [m]: each mechanism is made as
        large as it allows.
    shaft_radius : float
        Radius around the axis that the pin path must leave free [m], or over R0
        without a `largest_radius`.
    planet_radius : float
        Least pitch radius of the planet [m], or over R0.

    Returns
    -------
    list of Candidate
        Nearest to the wanted ratio first, then by peak acceleration.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    n = validate.integer("stations", stations, 3, "the wheel needs 3 stations or more")
    wanted = validate.non_negative("motion_ratio", motion_ratio, "give a share of the cycle")
    if wanted > 1.0:
        raise validate.fail("motion_ratio", "at most 1", motion_ratio, "give a share of the cycle")
    given = [curves] if isinstance(curves, str) else curves
    names = [validate.choice("curves", name, CURVES) for name in given]
    most = validate.integer("most_lobes", most_lobes, 0, "give a number of lobes")
    validate.integer("finest", finest, 1, "1 for whole numbers of lobes")
    validate.integer("most_pins", most_pins, 1, "give a number of pins")
    validate.integer("most_unused", most_unused, 0, "0 to use every lobe", _MOST)
    validate.integer("most_slots", 1 if most_slots is None else most_slots, 1, "give a number")
    room = validate.non_negative("tolerance", tolerance, "give a deviation of V")
    shaft = validate.non_negative("shaft_radius", shaft_radius, "give a radius, 0 for none")
    planet = validate.non_negative("planet_radius", planet_radius, "give a radius, 0 for none")
    if largest_radius is not None:
        validate.positive("largest_radius", largest_radius, "give the radius in m")
    if (most + 1) * finest**2 > _MOST:
        raise InvalidValue(
            f"most_lobes and finest must leave at most {_MOST} numbers of lobes, got "
            f"{most} and {finest}; choose smaller ones"
        )
    lobes = sorted({Fraction(a, b) for b in range(1, finest + 1) for a in range(most * b + 1)})
    found = []
    # the mechanism is as large as the space allows, so all lengths are proportional to that size
    for wheel in _near(_with_one_pin(n, names, lobes), wanted, room, most_pins, most_unused):
        scale = largest_radius / wheel.reach_over_fixed if largest_radius else 1.0
        closest = scale * wheel.closest_radius_over_fixed
        radius = scale / abs(float(wheel.gear_ratio))
        possible = closest >= shaft * (1.0 - _EDGE) and radius >= planet * (1.0 - _EDGE)
        if possible and wheel.slots <= (most_slots or math.inf):
            sized = replace(wheel, fixed_radius=scale) if largest_radius else wheel
            found.append(Candidate(sized, motion_peaks(wheel), closest))

    def rank(one: Candidate) -> tuple[float, float]:
        return round(abs(one.motion_ratio - wanted), 12), one.peaks.acceleration_max

    return sorted(found, key=rank)


def _with_one_pin(n: int, curves: Sequence[str], lobes: Sequence[Fraction]) -> Iterator[GearDriven]:
    for curve, m in product(curves, lobes):
        with suppress(InvalidValue):  # there may be no mechanism with so many lobes
            yield GearDriven(n, m, curve)


def _near(
    free: Iterator[GearDriven], wanted: float, room: float, most_pins: int, most_unused: int
) -> Iterator[GearDriven]:
    """The same paths with more pins and unused lobes, if the wheel rests and the ratio is near."""
    near, far = wanted + room + _EDGE, wanted - room - _EDGE
    for one in free:
        most = 0 if one.through_centre else int((1.0 + _EDGE) / one.lobe_ratio)
        for pins in range(1, min(most_pins, most) + 1):
            share = pins * one.lobe_ratio
            first = max(0, math.ceil(share / near - 1.0))
            last = most_unused if far <= 0.0 else min(most_unused, math.floor(share / far - 1.0))
            for unused in range(first, last + 1):
                with suppress(InvalidValue):  # an unused lobe may find a slot
                    yield replace(one, pins=pins, unused_lobes=unused)


def motion_ratio_chart(stations: int, lobes: ArrayLike, curve: str = CURVES[0]) -> FloatArray:
    """V0 of one pin over the number of lobes, a line of Dijksman's charts.

    Parameters
    ----------
    stations : int
        Stations n, >= 3.
    lobes : array_like
        Number m of further lobes between two neighbouring lobes [-], from 0 to 100 000, any real
        value.
    curve : str
        "hypocycloid", "epicycloid" or a cognate of theirs.

    Returns
    -------
    ndarray of the shape of `lobes`
        V0 [-]; NaN where no mechanism corresponds. A hypocycloid needs
        m <= n/2 - 2, where V0 reaches 1.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.

    Source: Dijksman (1974), eq. 14 with V0 counted negative for the epicycloid, as
    his (9) does.
    """
    n = validate.integer("stations", stations, 3, "the wheel needs 3 stations or more")
    name = validate.choice("curve", curve, CURVES)
    values = validate.numbers("lobes", lobes, "give numbers of lobes")
    if not np.all((values >= 0.0) & (values <= MOST_LOBES)):
        rule = f"at least 0 and at most {MOST_LOBES}"
        raise validate.fail("lobes", rule, lobes, "give numbers of lobes")
    found = (lobe_ratios(n, Fraction(float(m)), name) for m in values.reshape(-1))
    return np.array([next(iter(ratios), math.nan) for ratios in found]).reshape(values.shape)
