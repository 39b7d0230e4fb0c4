"""Extrema of the transmission, acceleration and jerk functions, and the limits that they set.

The pin stays on its side of the slot as long as F = I_f omega^2/M_load does not exceed F12 of
the mechanism: The limits of a drive without reversals follow from this condition.
"""

import math
from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import check_number
from escapement.constant_speed import Case, geneva, tight
from escapement.mechanisms import Geneva
from escapement.mechanisms.geneva import MOST_SLOTS
from escapement.mechanisms.path import smooth_intervals
from escapement.mechanisms.protocol import FloatArray, Mechanism
from escapement.mechanisms.slotted import transmission
from escapement.model.escapement import Escapement
from escapement.numerics.chebyshev import Extremum, Function, Series, extremes, fit

CONSTANT = 1e-12
"""Greatest g'/g that rounding alone may cause [1/rad], as in a table with a constant ratio."""
_NOTHING = 1e-11  # a deceleration at the exit this small, relatively, is rounding


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
        if -deepest <= CONSTANT * abs(self.ratio_max.value):
            return math.inf, math.inf
        return -1.0 / deepest, -1.0 / last if last < _NOTHING * deepest else math.inf


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
    points = edges(tight(mechanism))
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


def greatest_speed(mechanism: Mechanism, load_torque: float, follower_inertia: float) -> float:
    """Greatest driver speed without a pin reversal, sqrt(F12 M_load/I_f) [rad/s].

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    load_torque : float
        Constant torque opposing the follower [N m], >= 0.
    follower_inertia : float
        Follower and everything that turns with it [kg m^2], > 0.
    """
    inertia = check_number(Case, "follower_inertia", follower_inertia)
    return math.sqrt(_greatest_inertia_torque(mechanism, load_torque) / inertia)


def greatest_follower_inertia(mechanism: Mechanism, speed: float, load_torque: float) -> float:
    """Greatest follower inertia without a pin reversal, F12 M_load/omega^2 [kg m^2].

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    speed : float
        Driver speed [rad/s], > 0.
    load_torque : float
        Constant torque opposing the follower [N m], >= 0.
    """
    omega: float = check_number(Case, "speed", speed)
    return _greatest_inertia_torque(mechanism, load_torque) / omega / omega


def least_load_torque(mechanism: Mechanism, speed: float, follower_inertia: float) -> float:
    """Least constant load without a pin reversal, I_f omega^2/F12 [N m].

    A brake on the follower that adds up to it keeps the pin from knocking.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    speed : float
        Driver speed [rad/s], > 0.
    follower_inertia : float
        Follower and everything that turns with it [kg m^2], > 0.
    """
    omega: float = check_number(Case, "speed", speed)
    inertia: float = check_number(Case, "follower_inertia", follower_inertia)
    return inertia * omega * omega / transmission_extrema(mechanism).reversal_limits[0]


def fewest_slots(inertia_ratio: float, internal: bool = False) -> int:
    """Least number of slots of a Geneva wheel without a pin reversal at F.

    Parameters
    ----------
    inertia_ratio : float
        F = I_f omega^2/M_load [-], >= 0.
    internal : bool
        Whether the wheel is an internal one.

    Raises
    ------
    InvalidValue
        When F is below 0, or too great even for a million slots, the most that a
        `Geneva` has.
    """
    remedy = "give F = I_f omega^2/M_load"
    ratio = validate.non_negative("inertia_ratio", inertia_ratio, remedy)
    # F12 grows with the number of slots, so bisection over the numbers finds the first
    fewest = 3 + bisect_left(
        range(3, MOST_SLOTS + 1), ratio, key=lambda n: float(geneva.reversal_limits(n, internal)[0])
    )
    if fewest > MOST_SLOTS:
        raise InvalidValue(
            f"inertia_ratio must be below the limit of all wheels with up to {MOST_SLOTS:,} "
            f"slots, got {ratio!r}; lower the speed or the inertia, or brake the follower"
        )
    return fewest


def _greatest_inertia_torque(mechanism: Mechanism, load_torque: float) -> float:
    """I_f omega^2 without a pin reversal [N m]; no load is needed if there can be no reversal."""
    load: float = check_number(Escapement, "load_torque", load_torque)
    limit = transmission_extrema(mechanism).reversal_limits[0]
    return limit if math.isinf(limit) else limit * load
