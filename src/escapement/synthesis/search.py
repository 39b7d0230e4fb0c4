"""Inverse synthesis: gear-driven wheels that meet a designer's wishes."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from escapement import validate
from escapement.errors import InvalidValue
from escapement.mechanisms import GearDriven
from escapement.mechanisms.gear_equation import CURVES
from escapement.synthesis.motion import MotionPeaks, motion_peaks

_MOST = 100_000
_EDGE = 1e-12  # rounding may leave what lies exactly on a limit by less than this


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
        """Moving share of the cycle V [-]."""
        return self.peaks.motion_ratio

    @property
    def slots(self) -> int:
        """Slots of the wheel."""
        return self.mechanism.slots


def find_mechanisms(
    stations: int,
    motion_ratio: float | None = None,
    *,
    dwell_ratio: float | None = None,
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
    motion_ratio, dwell_ratio : float
        Wanted moving share V of the cycle, or 1 - V [-]: one of the two.
    tolerance : float
        Greatest deviation from it [-].
    curves : str or sequence of str
        Curves to look at; cognates have the same V.
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
    wanted = _wanted(motion_ratio, dwell_ratio)
    room = validate.non_negative("tolerance", tolerance, "give a deviation of V")
    several = isinstance(curves, Iterable) and not isinstance(curves, str)
    wished = curves if several else (curves,)
    names = [validate.choice("curves", curve, CURVES) for curve in wished]
    counts = {
        "most_lobes": validate.integer("most_lobes", most_lobes, 0, "give a number of lobes"),
        "finest": validate.integer("finest", finest, 1, "1 for whole numbers of lobes"),
        "most_pins": validate.integer("most_pins", most_pins, 1, "give a number of pins"),
        "most_unused": validate.integer(
            "most_unused", most_unused, 0, "0 to use every lobe", _MOST
        ),
    }
    if (counts["most_lobes"] + 1) * counts["finest"] ** 2 > _MOST:
        raise InvalidValue(
            f"most_lobes and finest must leave at most {_MOST} numbers of lobes, got "
            f"{most_lobes} and {finest}; choose smaller ones"
        )
    size = None
    if largest_radius is not None:
        size = validate.positive("largest_radius", largest_radius, "give the radius in m")
    limit = math.inf
    if most_slots is not None:
        limit = validate.integer("most_slots", most_slots, 1, "give a number of slots")
    shaft = validate.non_negative("shaft_radius", shaft_radius, "give a radius, 0 for none")
    planet = validate.non_negative("planet_radius", planet_radius, "give a radius, 0 for none")
    found = []
    for wheel in _mechanisms(n, wanted, room, names, **counts):
        scale = 1.0 if size is None else size / wheel.reach_over_fixed
        closest = scale * wheel.closest_radius_over_fixed
        radius = scale / abs(float(wheel.gear_ratio))
        fits = closest >= shaft * (1.0 - _EDGE) and radius >= planet * (1.0 - _EDGE)
        if fits and wheel.slots <= limit:
            peaks = motion_peaks(wheel)
            if size is not None:
                wheel = _sized(wheel, scale)
            found.append(Candidate(wheel, peaks, closest))
    return sorted(
        found,
        key=lambda one: (round(abs(one.motion_ratio - wanted), 12), one.peaks.acceleration_max),
    )


def _wanted(motion_ratio: float | None, dwell_ratio: float | None) -> float:
    if (motion_ratio is None) == (dwell_ratio is None):
        raise InvalidValue(
            "motion_ratio or dwell_ratio must be given, and not both, got "
            f"{motion_ratio!r} and {dwell_ratio!r}; one is 1 minus the other"
        )
    name = "motion_ratio" if dwell_ratio is None else "dwell_ratio"
    value = motion_ratio if dwell_ratio is None else dwell_ratio
    share = validate.non_negative(name, value, "give a share of the cycle")
    if share > 1.0:
        raise validate.fail(name, "at most 1", value, "give a share of the cycle")
    return share if dwell_ratio is None else 1.0 - share


def _mechanisms(
    n: int,
    wanted: float,
    room: float,
    curves: Sequence[str],
    most_lobes: int,
    finest: int,
    most_pins: int,
    most_unused: int,
) -> Iterator[GearDriven]:
    """Every mechanism within reach of the wanted ratio that turns the wheel by steps."""
    lobes = {Fraction(a, b) for b in range(1, finest + 1) for a in range(most_lobes * b + 1)}
    for curve in curves:
        for m in sorted(lobes):
            try:
                free = GearDriven(n, m, curve)
            except InvalidValue:  # there is no mechanism with so many lobes
                continue
            if free.through_centre:
                continue
            for pins in range(1, min(most_pins, int((1.0 + _EDGE) / free.lobe_ratio)) + 1):
                for unused in _unused(pins * free.lobe_ratio, wanted, room, most_unused):
                    try:
                        yield GearDriven(n, m, curve, pins, unused)
                    except InvalidValue:  # an unused lobe would find a slot
                        continue


def _unused(share: float, wanted: float, room: float, most: int) -> range:
    """Numbers of unused lobes with which pins that drive for a share of a lobe are near enough."""
    near, far = wanted + room + _EDGE, wanted - room - _EDGE
    first = max(0, math.ceil(share / near - 1.0))
    return range(first, most + 1 if far <= 0.0 else min(most, math.floor(share / far - 1.0)) + 1)


def _sized(wheel: GearDriven, fixed_radius: float) -> GearDriven:
    return GearDriven(
        wheel.stations,
        wheel.lobes,
        wheel.curve,
        wheel.pins,
        wheel.unused_lobes,
        fixed_radius=fixed_radius,
    )
