"""Transmission, acceleration and jerk functions of a mechanism and their extrema."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.chebyshev import Function, Series, extremes, fit
from escapement.constant_speed import geneva
from escapement.constant_speed.case import checked
from escapement.mechanisms import Geneva
from escapement.mechanisms.slotted import transmission
from escapement.model import FloatArray, Mechanism
from escapement.scene import smooth_intervals

_CONSTANT = 1e-12  # g' over g [1/rad] of a table whose ratio does not vary
_NOTHING = 1e-11  # a deceleration at the exit this small, relatively, is rounding


class Extremum(NamedTuple):
    """A value [-] and the driver angle from dead centre that has it [rad]."""

    value: float
    angle: float


@dataclass(frozen=True)
class TransmissionExtrema:
    """Extrema of the transmission functions over one engagement [-].

    ratio_max : of g, follower over driver speed (Filemon's i_omega).
    acceleration_start, acceleration_exit : g' at pin entry and exit.
    acceleration_max, acceleration_min : of g', follower acceleration over
        squared driver speed (Filemon's i_epsilon).
    jerk_max, jerk_min : of g'', follower jerk over cubed driver speed.
    """

    ratio_max: Extremum
    acceleration_start: float
    acceleration_exit: float
    acceleration_max: Extremum
    acceleration_min: Extremum
    jerk_max: Extremum
    jerk_min: Extremum

    @property
    def reversal_limits(self) -> tuple[float, float]:
        """F12 and F23, Filemon's (8) and (9) for any mechanism [-].

        From F = I_f omega^2/M_load = F12 on the pin changes sides; from F23 on
        it leaves on the side where the follower drives. Infinite where there is
        no such F.
        """
        deepest, last = self.acceleration_min.value, self.acceleration_exit
        if -deepest <= rounding_of_acceleration(self.ratio_max.value):
            return math.inf, math.inf
        return -1.0 / deepest, -1.0 / last if last < _NOTHING * deepest else math.inf


def rounding_of_acceleration(ratio: float) -> float:
    """What rounding alone may make of g' where g is `ratio` [-]."""
    return _CONSTANT * abs(ratio)


def transmission_extrema(mechanism: Mechanism) -> TransmissionExtrema:
    """Extrema of g, g' and g'' over one engagement, and where they are.

    For a Geneva wheel, external or internal, g and g' by Filemon's closed forms;
    every other extremum as a root of the next derivative. Values are accurate to
    rounding, those of g'' of a mechanism without a closed form of it, as a table, to
    some 1e-9 of the greatest.

    Raises
    ------
    InvalidValue
        When `mechanism` is none.

    Source: Filemon (1960), eqs. 2 to 5 and Table I.
    """
    points = edges(checked(mechanism))
    known: Function | None = getattr(mechanism, "jerk", None)
    jerk = fit(known, points) if known else _rate(mechanism).derivative()
    bent = _extrema(known or jerk, jerk)
    if isinstance(mechanism, Geneva):
        return TransmissionExtrema(*_closed_forms(mechanism), *bent)
    start, exit_ = transmission(mechanism.path, points[[0, -1]]).dg.tolist()
    ratio, _ = _extrema(_reader(mechanism, "g"), fit(_reader(mechanism, "g"), points))
    rates = _extrema(_reader(mechanism, "dg"), _rate(mechanism))
    return TransmissionExtrema(ratio, start, exit_, *rates, *bent)


def jerk_function(mechanism: Mechanism, theta: ArrayLike) -> FloatArray:
    """g'' at driver angles from dead centre, pin engaged [-].

    A closed form for a Geneva wheel (d^3 alpha/d beta^3 of Filemon, before his
    eq. 5, whose 1 - c^2 must read 1 + c^2), for a gear-driven one and for a planetary
    drive, else the derivative of an interpolant of g'.
    """
    known: Function | None = getattr(mechanism, "jerk", None)
    return (known or _rate(mechanism).derivative())(np.asarray(theta, dtype=float))


def edges(mechanism: Mechanism) -> FloatArray:
    """Driver angles between which the transmission is analytic [rad]: of a table, its knots."""
    return smooth_intervals(mechanism.path, mechanism.breaks)


def _closed_forms(wheel: Geneva) -> tuple[Extremum, float, float, Extremum, Extremum]:
    n, internal = wheel.slots, wheel.internal
    start = float(geneva.acceleration_start(n))
    top = float(geneva.acceleration_max(n, internal))
    angle = float(geneva.acceleration_max_angle(n, internal))
    return (
        Extremum(float(geneva.ratio_max(n, internal)), 0.0),
        start,
        -start,
        Extremum(top, -angle),
        Extremum(-top, angle),
    )


def _reader(mechanism: Mechanism, name: str) -> Function:
    path = mechanism.path
    return lambda theta: getattr(transmission(path, theta), name)


def _rate(mechanism: Mechanism) -> Series:
    return fit(_reader(mechanism, "dg"), edges(mechanism))


def _extrema(function: Function | Series, series: Series) -> tuple[Extremum, Extremum]:
    top, top_at, bottom, bottom_at = extremes(function, series)
    return Extremum(top, top_at), Extremum(bottom, bottom_at)
