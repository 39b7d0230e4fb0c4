"""Extrema of the transmission, acceleration and jerk functions."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement.constant_speed import geneva
from escapement.mechanisms import Geneva
from escapement.mechanisms.path import smooth_intervals
from escapement.mechanisms.protocol import FloatArray, Mechanism, checked
from escapement.mechanisms.slotted import transmission
from escapement.numerics.chebyshev import Extremum, Function, Series, extremes, fit


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
    jerk = _jerk(mechanism)
    bent = extremes(jerk, jerk if isinstance(jerk, Series) else fit(jerk, points))
    if isinstance(mechanism, Geneva):
        return TransmissionExtrema(*_closed_forms(mechanism), *bent)
    start, exit_ = transmission(mechanism.path, points[[0, -1]]).dg.tolist()
    readers = _reader(mechanism, "g"), _reader(mechanism, "dg")
    (ratio, _), rates = (extremes(read, fit(read, points)) for read in readers)
    return TransmissionExtrema(ratio, start, exit_, *rates, *bent)


def jerk_function(mechanism: Mechanism, theta: ArrayLike) -> FloatArray:
    """g'' at driver angles from dead centre, pin engaged [-].

    A closed form for a Geneva wheel (d^3 alpha/d beta^3 of Filemon, before his
    eq. 5, whose 1 - c^2 must read 1 + c^2), for a gear-driven one and for a planetary
    drive, else the derivative of an interpolant of g'.
    """
    return _jerk(mechanism)(np.asarray(theta, dtype=float))


def _jerk(mechanism: Mechanism) -> Function | Series:
    """g''; without a closed form of it the slope of the series of g'."""
    known: Function | None = mechanism.jerk
    return known or fit(_reader(mechanism, "dg"), edges(mechanism)).derivative()


def edges(mechanism: Mechanism) -> FloatArray:
    """Driver angles between which the transmission is analytic [rad]: of a table, its knots."""
    return smooth_intervals(mechanism.path, mechanism.breaks)


def _closed_forms(wheel: Geneva) -> tuple[Extremum, float, float, Extremum, Extremum]:
    # about dead centre g is even and g' odd, so the least g' mirrors the greatest
    n, internal = wheel.slots, wheel.internal
    start, ratio = float(geneva.acceleration_start(n)), float(geneva.ratio_max(n, internal))
    top = float(geneva.acceleration_max(n, internal))
    angle = float(geneva.acceleration_max_angle(n, internal))
    return Extremum(ratio, 0.0), start, -start, Extremum(top, -angle), Extremum(-top, angle)


def _reader(mechanism: Mechanism, name: str) -> Function:
    path = mechanism.path
    return lambda theta: getattr(transmission(path, theta), name)
