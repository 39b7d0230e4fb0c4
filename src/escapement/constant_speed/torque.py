"""Torque, power and pin reversals of a drive that runs at constant speed.

The same equation of motion as everywhere, with theta_ddot = 0: the pin carries
N R = M_load + I_f omega^2 g', the drive p N R (Filemon's eq. 6), and where N R
changes sign the pin changes sides of its slot.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.chebyshev import extremes, fit, zeros
from escapement.constant_speed.case import Case, table, within_cell
from escapement.constant_speed.extrema import (
    edges,
    rounding_of_acceleration,
    transmission_extrema,
)
from escapement.mechanisms.slotted import transmission
from escapement.model import FloatArray, Mechanism

if TYPE_CHECKING:
    from escapement.constant_speed.case import Load

_PIECES = 512  # to begin with, of a load of any shape: a row in 5000 of a table is seen
_ROUNDING = 64.0 * np.finfo(float).eps  # of the load: the moment carries that of the angle too
_SAMPLES = 721


@dataclass(frozen=True)
class TorqueState:
    """Drive and contact at driver angles `theta`: arrays of one shape.

    theta, phi : driver and follower angle from dead centre [rad].
    torque : drive torque, < 0 where the follower drives back [N m].
    contact_moment : N R of the pin on the follower; its sign is the side of the
        slot [N m].
    load_torque : torque opposing the follower [N m].
    """

    theta: FloatArray
    phi: FloatArray
    torque: FloatArray
    contact_moment: FloatArray
    load_torque: FloatArray


@dataclass(frozen=True, kw_only=True)
class DriveTorque(Case):
    """What a mechanism at constant driver speed asks of its drive.

    Attributes
    ----------
    mechanism, speed, load_torque, follower_inertia, efficiency, friction :
        As given to `drive_torque`.
    torque_max, torque_max_angle : float
        Greatest drive torque [N m] and its driver angle from dead centre [rad].
    torque_min, torque_min_angle : float
        Least one; below zero the follower drives back.
    torque_mean : float
        Mean from pin entry to dead centre, Filemon's (10), of a table to the middle of
        its cell [N m].
    reversals : ndarray
        Driver angles from dead centre where the pin changes sides [rad].
    zone : int
        Filemon's: 1 without reversal; 2 where the pin leaves on the side it
        entered on; 3 where it leaves on the side where the follower drives.
    reversal_limits : (float, float)
        F12 and F23 of the mechanism under a constant load [-].
    """

    torque_max: float
    torque_max_angle: float
    torque_min: float
    torque_min_angle: float
    torque_mean: float
    reversals: FloatArray
    zone: int
    reversal_limits: tuple[float, float]

    @property
    def power_max(self) -> float:
        """Greatest power of the drive [W]."""
        return self.torque_max * self.speed

    @property
    def peak_to_mean(self) -> float:
        """Filemon's s, greatest over mean torque: the overload a motor must stand [-].

        NaN where a varying load helps so much that the mean is not positive.
        """
        return self.torque_max / self.torque_mean if self.torque_mean > 0.0 else math.nan

    @property
    def inertia_ratio(self) -> float:
        """Filemon's F = I_f omega^2/M_load [-].

        Raises
        ------
        InvalidValue
            Where the load torque is zero or varies.
        """
        return inertia_ratio(self.follower_inertia, self.speed, self.load_torque)

    @cached_property
    def moment_deviation(self) -> float:
        """Greatest standard deviation of the contact moment, from a measured table's scatter [N m].

        0 for any other mechanism. Reversals between which the moment stays within two or three
        of it may be of the scatter.
        """
        deviation = getattr(self.mechanism, "deviation", None)
        if deviation is None:
            return 0.0
        return self.inertial * float(deviation(self.samples.theta).dg.max())

    def at(self, theta: ArrayLike) -> TorqueState:
        """Torque at driver angles from dead centre [rad], within one cell.

        In the dwell, from the exit on, the follower is locked: no torque.

        Raises
        ------
        InvalidValue
            Where an angle is not finite or lies outside the cell.
        """
        angles, exit_ = validate.numbers("theta", theta, "give angles"), self.mechanism.breaks[-1]
        flat = within_cell(self.mechanism, angles).reshape(-1)
        phi, load, values = table(self, np.minimum(flat, exit_))
        # the locked follower carries its load by itself
        values[1:, flat > exit_] = 0.0
        columns = (angles, phi, values[2], values[1], load)
        return TorqueState(*(column.reshape(angles.shape) for column in columns))

    @cached_property
    def samples(self) -> TorqueState:
        """The engagement on an even grid, reversals and extrema among it."""
        entry, exit_ = self.mechanism.breaks[0], self.mechanism.breaks[-1]
        marks = [*self.mechanism.breaks, self.torque_max_angle, self.torque_min_angle]
        even = np.linspace(entry, exit_, _SAMPLES)
        return self.at(np.unique(np.concatenate([even, marks, self.reversals])))


def drive_torque(
    mechanism: Mechanism,
    speed: float,
    load_torque: Load,
    follower_inertia: float,
    efficiency: float = 1.0,
    friction: float = 0.0,
) -> DriveTorque:
    """Drive torque and pin reversals at constant driver speed.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry, for example `Geneva(slots=6)`.
    speed : float
        Driver speed [rad/s], > 0. The driver's inertia plays no part.
    load_torque : float or callable
        Torque opposing the follower while it moves [N m], >= 0; or a function
        from an array of follower angles, zero at dead centre [rad], to the
        torque there [N m] of either sign, smooth but for up to 5000 kinks and jumps.
        What is narrower than 1/3000 of a Geneva wheel's step may be passed over.
    follower_inertia : float
        Follower and everything that turns with it [kg m^2], > 0.
    efficiency : float
        Of the drive [-], in (0, 1]. Torque is divided by it where the drive
        works and, other than in Filemon, multiplied where it is driven.
    friction : float
        Coefficient of friction between pin and slot [-], >= 0.

    Returns
    -------
    DriveTorque
        Figures at once; the torque at any angle by its method `at`.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.

    Source: Filemon (1960), eqs. 6 to 11. The maximum, there read from a chart or
    taken for great F, is the greatest value among all roots of the torque's slope.
    """
    case = Case(mechanism, speed, load_torque, follower_inertia, efficiency, friction)
    reversals, zone = _find_reversals(case)
    known: dict[str, Any] = vars(case) | _torque_figures(case, reversals)
    return DriveTorque(
        **known,
        reversals=reversals,
        zone=zone,
        reversal_limits=transmission_extrema(mechanism).reversal_limits,
    )


def inertia_ratio(follower_inertia: float, speed: float, load_torque: Load) -> float:
    """Filemon's F = I_f omega^2/M_load: inertia against load [-].

    Raises
    ------
    InvalidValue
        Where the load torque is zero or varies: no F exists.
    """
    if callable(load_torque):
        raise validate.fail(
            "load_torque", "constant for an inertia ratio F", load_torque, "give a number in N m"
        )
    load = validate.positive(
        "load_torque", load_torque, "without a load there is no inertia ratio F"
    )
    return follower_inertia * speed * speed / load


def _find_reversals(case: Case) -> tuple[FloatArray, int]:
    """Angles where the contact moment changes sign, and Filemon's zone."""
    points = _places(case, edges(case.mechanism))
    found = zeros(lambda theta: table(case, theta)[2][1], points)
    places = np.unique(np.concatenate([[points[0]], found, [points[-1]]]))
    # the moment keeps its sign between zeros; a touching zero has the same one on both sides
    _, load, (ratio, moment, _) = table(case, 0.5 * (places[:-1] + places[1:]))
    rounding = _ROUNDING * np.abs(load) + case.inertial * rounding_of_acceleration(ratio)
    sides = np.where(np.abs(moment) > rounding, np.sign(moment), 0.0)
    carried = np.flatnonzero(sides)
    turned = carried[1:][np.diff(sides[carried]) != 0.0]
    zone = 1 if turned.size == 0 else 3 if sides[carried[-1]] < 0.0 else 2
    return places[turned], zone


def _places(case: Case, points: Iterable[float]) -> FloatArray:
    """`points`, and between them more where a load may hide something narrow."""
    places = np.unique(np.fromiter(points, dtype=float))
    if not callable(case.load_torque):
        return places
    # each interval is cut evenly, as a sliver beside a point would be all rounding
    counts = np.ceil(np.diff(places) * (_PIECES / (places[-1] - places[0]))).astype(int)
    cuts = map(np.linspace, places[:-1], places[1:], counts + 1)
    return np.unique(np.concatenate([*cuts]))


def _torque_figures(case: Case, reversals: FloatArray) -> dict[str, float]:
    """Extremes and mean of the torque, between the points where it has kinks."""
    points, half = edges(case.mechanism), case.half
    kinks = np.concatenate([points, [half], reversals, _idle(case, reversals)])

    def torque(theta: FloatArray) -> FloatArray:
        values: FloatArray = table(case, theta)[2][2]
        return values

    # the torque bends where the pin changes sides and where the power turns round
    series = fit(torque, _places(case, kinks))
    first_half = series.edges[1:] <= half
    names = ("torque_max", "torque_max_angle", "torque_min", "torque_min_angle")
    figures = dict(zip(names, extremes(torque, series), strict=True))
    mean = series.integrals()[first_half].sum() / (half - points[0])
    return figures | {"torque_mean": float(mean)}


def _idle(case: Case, reversals: FloatArray) -> FloatArray:
    """Where friction holds what the follower drives, p = 0: the power turns round there."""
    if case.friction == 0.0 or case.efficiency == 1.0 or len(reversals) == 0:
        return np.empty(0)

    def ratio(theta: FloatArray) -> FloatArray:
        found = transmission(case.mechanism.path, theta)
        result: FloatArray = found.g - case.friction * np.abs(found.u)
        return result

    return zeros(ratio, edges(case.mechanism))
