"""Inverse synthesis: charts of the ratio of times, and wheels that meet a designer's wishes."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.errors import InvalidValue
from escapement.mechanisms import GearDriven
from escapement.mechanisms.gear_equation import CURVES, MOST_LOBES, lobe_ratios
from escapement.model import FloatArray
from escapement.synthesis.motion import MotionPeaks, motion_peaks

_MOST = 100_000
_GRID = 501  # of a chart: two roots closer than a step are one for a designer
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
    names = (curves,) if isinstance(curves, str) else tuple(curves)
    for name in names:
        validate.choice("curves", name, CURVES)
    greatest = validate.integer("most_lobes", most_lobes, 0, "give a number of lobes")
    parts = validate.integer("finest", finest, 1, "1 for whole numbers of lobes")
    validate.integer("most_pins", most_pins, 1, "give a number of pins")
    validate.integer("most_unused", most_unused, 0, "0 to use every lobe", _MOST)
    if (greatest + 1) * parts**2 > _MOST:
        raise InvalidValue(
            f"most_lobes and finest must leave at most {_MOST} numbers of lobes, got "
            f"{most_lobes} and {finest}; choose smaller ones"
        )
    lobes = sorted({Fraction(a, b) for b in range(1, parts + 1) for a in range(greatest * b + 1)})
    if largest_radius is not None:
        validate.positive("largest_radius", largest_radius, "give the radius in m")
    if most_slots is not None:
        validate.integer("most_slots", most_slots, 1, "give a number of slots")
    shaft = validate.non_negative("shaft_radius", shaft_radius, "give a radius, 0 for none")
    planet = validate.non_negative("planet_radius", planet_radius, "give a radius, 0 for none")
    found = []
    for free in _single_pins(n, names, lobes):
        # the size is that of the largest mechanism in the space, so all lengths go with it
        for wheel in _with_pins(free, wanted, room, most_pins, most_unused):
            scale = largest_radius / wheel.reach_over_fixed if largest_radius else 1.0
            closest = scale * wheel.closest_radius_over_fixed
            radius = scale / abs(float(wheel.gear_ratio))
            fits = closest >= shaft * (1.0 - _EDGE) and radius >= planet * (1.0 - _EDGE)
            if fits and wheel.slots <= (most_slots or math.inf):
                sized = replace(wheel, fixed_radius=scale) if largest_radius else wheel
                found.append(Candidate(sized, motion_peaks(wheel), closest))
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


def _single_pins(n: int, curves: Sequence[str], lobes: Sequence[Fraction]) -> Iterator[GearDriven]:
    """Every mechanism with one pin and no unused lobe that turns the wheel by steps."""
    for curve in curves:
        for m in lobes:
            try:
                free = GearDriven(n, m, curve)
            except InvalidValue:  # there is no mechanism with so many lobes
                continue
            if not free.through_centre:
                yield free


def _with_pins(
    free: GearDriven, wanted: float, room: float, most_pins: int, most_unused: int
) -> Iterator[GearDriven]:
    """The same path with more pins and unused lobes, within reach of the wanted ratio."""
    for pins in range(1, min(most_pins, int((1.0 + _EDGE) / free.lobe_ratio)) + 1):
        for unused in _unused(pins * free.lobe_ratio, wanted, room, most_unused):
            try:
                yield replace(free, pins=pins, unused_lobes=unused)
            except InvalidValue:  # an unused lobe would find a slot
                continue


def _unused(share: float, wanted: float, room: float, most: int) -> range:
    """Numbers of unused lobes with which pins that drive for a share of a lobe are near enough."""
    near, far = wanted + room + _EDGE, wanted - room - _EDGE
    first = max(0, math.ceil(share / near - 1.0))
    return range(first, most + 1 if far <= 0.0 else min(most, math.floor(share / far - 1.0)) + 1)


def motion_ratio_chart(stations: int, lobes: ArrayLike, curve: str = CURVES[0]) -> FloatArray:
    """V0 of one pin over the number of lobes, a line of Dijksman's charts.

    Parameters
    ----------
    stations : int
        Stations n, >= 3.
    lobes : array_like
        Unreal lobes m [-], from 0 to 100 000, of any real value.
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
    found = [_ratio(n, Fraction(float(m)), name) for m in values.reshape(-1)]
    return np.array(found).reshape(values.shape)


def lobes_for(stations: int, motion_ratio: float, curve: str = CURVES[0]) -> list[float]:
    """Numbers of lobes that give a ratio of times with one pin, ascending.

    The chart read the other way round, up to 100 000 lobes. They are real numbers: take a
    rational one near by.

    Parameters
    ----------
    stations : int
        Stations n, >= 3.
    motion_ratio : float
        Wanted V0 [-], in (0, 1).
    curve : str
        "hypocycloid", "epicycloid" or a cognate of theirs.

    Returns
    -------
    list of float
        Empty where the chart does not reach this ratio; two near a hypocycloid's
        least one.
    """
    from scipy.optimize import brentq

    n = validate.integer("stations", stations, 3, "the wheel needs 3 stations or more")
    name = validate.choice("curve", curve, CURVES)
    wanted = validate.positive("motion_ratio", motion_ratio, "give V0 between 0 and 1")
    if wanted >= 1.0:
        raise validate.fail("motion_ratio", "below 1", motion_ratio, "give V0 between 0 and 1")
    # with x = pi V0 and c = +-2/k - 1 the equation is c sin x = sin(c x + gamma); c goes
    # from m = 0 to alpha = pi - gamma, or to the hypocycloid through the wheel's centre
    gamma, x = 2.0 * math.pi / n, math.pi * wanted
    outside = name in CURVES[1::2]
    start = 1.0 if outside else -1.0
    low, high = start + 2.0 / n, 1.0 + (math.pi - gamma) / x if outside else -2.0 / n

    def value(c: float) -> float:
        return c * math.sin(x) - math.sin(c * x + gamma)

    if high < low - _EDGE:
        return []
    grid = np.linspace(low - _EDGE, high + _EDGE, _GRID)  # so that m = 0 is on the chart
    signs = np.sign([value(c) for c in grid])
    places = np.flatnonzero(signs[1:] * signs[:-1] < 0.0)
    roots = (float(brentq(value, grid[i], grid[i + 1], xtol=1e-15)) for i in places)
    found = [max((c - start) * n / 2.0 - 1.0, 0.0) for c in roots]
    return [m for m in found if m <= MOST_LOBES]


def _ratio(stations: int, lobes: Fraction, curve: str) -> float:
    try:
        found = lobe_ratios(stations, lobes, curve)
    except InvalidValue:  # no hypocycloid has so many lobes
        found = []
    return found[0] if found else math.nan
