"""Torque, power and pin reversals of a drive that runs at constant speed.

The same equation of motion as everywhere, with theta_ddot = 0: the pin carries
N R = M_load + I_f omega^2 g', the drive p N R (Filemon's eq. 6), and where N R
changes sign the pin changes sides of its slot.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.constant_speed import Case, extrema, tight
from escapement.constant_speed.contact import Load, TorqueState, engaged_state, within_cell
from escapement.mechanisms.protocol import FloatArray, Mechanism
from escapement.mechanisms.slotted import transmission
from escapement.numerics.chebyshev import Extremum, extremes, fit, zeros

_PIECES = 512  # to begin with, of a load of any shape: a row in 5000 of a table is seen
_ROUNDING = 64.0 * np.finfo(float).eps  # share of the load; it includes the rounding of the angle
_SAMPLES = 721


@dataclass(frozen=True)
class DriveTorque(Case):
    """Torque, power and pin reversals of a mechanism at constant driver speed.

    Attributes
    ----------
    mechanism, speed, load_torque, follower_inertia, efficiency, friction :
        As given to `drive_torque`.
    torque_max, torque_max_angle : float
        Greatest drive torque [N m] and its driver angle from dead centre [rad].
    torque_min, torque_min_angle : float
        Least drive torque and its angle; below zero the follower drives back.
    torque_mean : float
        Mean from pin entry to dead centre, Filemon's (10); for a table to the middle of its cell
        [N m].
    reversals : ndarray
        Driver angles from dead centre where the pin changes sides [rad].
    zone : int
        Filemon's: 1 without reversal; 2 where the pin leaves on the side it
        entered on; 3 where it leaves on the side where the follower drives.
    reversal_limits : (float, float)
        F12 and F23 of the mechanism under a constant load [-].
    """

    torque_max: float = field(init=False)
    torque_max_angle: float = field(init=False)
    torque_min: float = field(init=False)
    torque_min_angle: float = field(init=False)
    torque_mean: float = field(init=False)
    reversals: FloatArray = field(init=False)
    zone: int = field(init=False)
    reversal_limits: tuple[float, float] = field(init=False)

    def __post_init__(self) -> None:
        width = tight(self.mechanism).pin_radius
        super().__post_init__()
        if self.friction > 0.0 and width:
            rule = "0 with friction, whose torque is that of thin pins"
            raise validate.fail("pin_radius", rule, width, "leave one out, or call esc.index")
        limits = extrema.transmission_extrema(self.mechanism).reversal_limits
        vars(self).update(_find_reversals(self), reversal_limits=limits)
        vars(self).update(_torque_figures(self, self.reversals))

    @cached_property
    def contact_force_max(self) -> Extremum:
        """Greatest force between pin and slot, N = |N R|/R [N], and where it is [rad].

        NaN for a mechanism without slots or without a length.
        """
        length = self.mechanism.crank_radius
        if length is None:
            return Extremum(math.nan, math.nan)
        wheel: Any = self.mechanism

        def force(theta: FloatArray) -> FloatArray:
            moment = engaged_state(self, theta).contact_moment
            return np.asarray(np.abs(moment) / (length * wheel.radius(theta)))

        # the force has a kink where the pin changes sides
        kinks = _angles_of(self, [*extrema.edges(wheel), *self.reversals])
        return extremes(force, fit(force, kinks))[0]

    def at(self, theta: ArrayLike) -> TorqueState:
        """Torque at driver angles from dead centre [rad], within one cell.

        In the dwell, from the exit on, the follower is locked: no torque.

        Raises
        ------
        InvalidValue
            Where an angle is not finite or lies outside the cell.
        """
        angles = validate.numbers("theta", theta, "give angles")
        engaged, locked = within_cell(self.mechanism, angles)
        state = engaged_state(self, engaged)
        # the locked follower carries its load by itself
        torque, moment = (np.where(locked, 0.0, x) for x in (state.torque, state.contact_moment))
        return state._replace(theta=angles, torque=torque, contact_moment=moment)

    @cached_property
    def samples(self) -> TorqueState:
        """The engagement on an even grid, which includes reversals and extrema."""
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
        Driver speed [rad/s], > 0. The driver's inertia has no influence.
    load_torque : float or callable
        Torque opposing the follower while it moves [N m], >= 0; or a function
        from an array of follower angles, zero at dead centre [rad], to the
        torque there [N m] of either sign, smooth except for up to 5000 kinks and jumps.
        A feature narrower than 1/3000 of a Geneva wheel's step may be missed.
    follower_inertia : float
        Follower and everything that turns with it [kg m^2], > 0.
    efficiency : float
        Efficiency of the drive [-], in (0, 1]. Torque is divided by it where the drive works and,
        unlike in Filemon, multiplied where it is driven.
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
    return DriveTorque(mechanism, speed, load_torque, follower_inertia, efficiency, friction)


def _find_reversals(case: Case) -> dict[str, Any]:
    """Angles where the contact moment changes sign, and Filemon's zone."""
    points = _angles_of(case, extrema.edges(case.mechanism))
    found = zeros(lambda theta: engaged_state(case, theta).contact_moment, points)
    angles = np.unique([points[0], *found, points[-1]])
    # the moment keeps its sign between zeros; a touching zero has the same one on both sides
    middle = engaged_state(case, 0.5 * (angles[:-1] + angles[1:]))
    moment, ratio = middle.contact_moment, transmission(case.mechanism.path, middle.theta).g
    slack = case.inertial * extrema.CONSTANT * np.abs(ratio)
    carries = np.abs(moment) > _ROUNDING * np.abs(middle.load_torque) + slack
    carried, sides = np.flatnonzero(carries), np.sign(moment[carries])
    reversed_at = carried[1:][np.diff(sides) != 0.0]
    zone = 1 if reversed_at.size == 0 else 3 if sides[-1] < 0.0 else 2
    return {"reversals": angles[reversed_at], "zone": zone}


def _angles_of(case: Case, points: Iterable[float]) -> FloatArray:
    """`points`, and between them more where a load may hide something narrow."""
    angles = np.unique(np.fromiter(points, dtype=float))
    if not callable(case.load_torque):
        return angles
    # each interval is cut evenly, as a sliver beside a point would be all rounding
    counts = np.ceil(np.diff(angles) * (_PIECES / (angles[-1] - angles[0]))).astype(int)
    cuts = map(np.linspace, angles[:-1], angles[1:], counts + 1)
    return np.unique(np.concatenate([*cuts]))


def _torque_figures(case: Case, reversals: FloatArray) -> dict[str, float]:
    """Extremes and mean of the torque, between the points where it has kinks."""
    points, half = extrema.edges(case.mechanism), case.half
    # the torque has kinks where the pin changes sides, and where the power changes direction:
    # there friction balances the driving follower, p = 0
    kinks = [*points, half, *reversals]
    if reversals.size and case.friction > 0.0 and case.efficiency < 1.0:
        kinks += zeros(lambda theta: _held(case, theta), points).tolist()

    def torque(theta: FloatArray) -> FloatArray:
        return engaged_state(case, theta).torque

    series = fit(torque, _angles_of(case, kinks))
    (top, top_at), (bottom, bottom_at) = extremes(torque, series)
    first_half = series.integrals()[series.edges[1:] <= half]
    return {
        "torque_max": top, "torque_max_angle": top_at,
        "torque_min": bottom, "torque_min_angle": bottom_at,
        "torque_mean": float(first_half.sum() / (half - points[0])),
    }  # fmt: skip


def _held(case: Case, theta: FloatArray) -> FloatArray:
    """The effective ratio where the follower drives, g - mu |u|."""
    found = transmission(case.mechanism.path, theta)
    return np.asarray(found.g - case.friction * np.abs(found.u))
