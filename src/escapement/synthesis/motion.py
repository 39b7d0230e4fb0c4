"""The follower's motion at constant driver speed, and its peaks.

On a path of two vectors (g, u) runs along a circle through (g1, 0) and (g2, 0), and
with s the sum of the two rates g' = u (s - 2 g), so that over an engagement

    g'^2 = (g1 - g)(g - g2)(s - 2 g)^2
    g''  = (s - 2 g) [(s - 2 g)(g1 + g2 - 2 g)/2 - 2 (g1 - g)(g - g2)]

are polynomials in g, which runs from 0 to its value at dead centre: every peak is at
an end or at a root of a polynomial.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from escapement import validate
from escapement.mechanisms import GearDriven, Geneva
from escapement.mechanisms.slotted import circle
from escapement.model import FloatArray

_PEAKS = ("velocity_max", "acceleration_start", "acceleration_max", "jerk_start", "jerk_max")


@dataclass(frozen=True)
class FollowerMotion:
    """Motion of the follower: arrays of one shape.

    time : in cycles, from the entry of a pin.
    angle : in steps, 0 at that entry.
    velocity, acceleration, jerk : in steps per cycle, its square and its cube. The
        impulses of jerk where the wheel starts and stops are not in it.
    """

    time: FloatArray
    angle: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    jerk: FloatArray


def follower_motion(mechanism: GearDriven | Geneva, time: ArrayLike) -> FollowerMotion:
    """Follower angle, velocity, acceleration and jerk at constant driver speed.

    Parameters
    ----------
    mechanism : GearDriven or Geneva
        What moves. In a dwell the follower rests.
    time : array_like
        In cycles from the entry of a pin, of any sign and size.

    Raises
    ------
    InvalidValue
        For another mechanism, or a time that is not finite.

    Notes
    -----
    A wheel in uniform motion has neither acceleration nor jerk.
    """
    _check_wheel(mechanism)
    at = validate.numbers("time", time, "give times in cycles")
    cell, half = mechanism.cell_angle, mechanism.breaks[-1]
    step, whole = mechanism.follower_step, np.floor(at)
    # a cell begins when a pin enters, half an engagement before dead centre
    theta = (at - whole) * cell - half
    moving = theta <= half
    theta = np.minimum(theta, half)
    found = mechanism.transmission(theta)
    # at a speed of one cell a cycle each derivative by the angle brings one more cell
    rates = (found.g, found.dg, mechanism.jerk(theta))
    angle = whole + 0.5 + mechanism.follower_angle(theta) / step
    scaled = (np.where(moving, x, 0.0) * cell ** (i + 1) / step for i, x in enumerate(rates))
    return FollowerMotion(at, angle, *scaled)


@dataclass(frozen=True)
class MotionPeaks:
    """Peaks of the follower's motion at constant driver speed.

    In steps per motion time, its square and its cube, as `motion_peaks` gives them;
    `per_cycle` changes to the time of a whole cycle.

    motion_ratio : moving share of the cycle [-].
    velocity_max : greatest velocity.
    acceleration_start : acceleration with which the motion begins. It comes at once:
        the jerk at the start and at the end is an impulse of this size.
    acceleration_max : greatest acceleration.
    jerk_start : jerk right after the start. jerk_max : greatest size of the jerk.
    """

    motion_ratio: float
    velocity_max: float
    acceleration_start: float
    acceleration_max: float
    jerk_start: float
    jerk_max: float

    def per_cycle(self) -> "MotionPeaks":
        """The same in steps per cycle time, its square and its cube."""
        powers = dict(zip(_PEAKS, (1, 2, 2, 3, 3), strict=True))
        shares = {name: self.motion_ratio**power for name, power in powers.items()}
        return replace(self, **{name: getattr(self, name) / shares[name] for name in _PEAKS})


def motion_peaks(mechanism: GearDriven | Geneva) -> MotionPeaks:
    """Peaks of velocity, acceleration and jerk of one engagement.

    Raises
    ------
    InvalidValue
        For a mechanism without a slotted wheel, or a path through its centre.
    """
    _check_wheel(mechanism)
    path = mechanism.path
    first, second = circle(path)  # u vanishes at these g, the first of which is dead centre
    g = Polynomial([0.0, 1.0])
    slope, product = path.numbers[6] - 2.0 * g, (first - g) * (g - second)
    squared = product * slope**2
    jerk = slope * (slope * (first + second - 2.0 * g) / 2.0 - 2.0 * product)
    angle, step = mechanism.engagement_angle, mechanism.follower_step
    speed, rate, change = (angle**power / step for power in (1, 2, 3))
    return MotionPeaks(
        motion_ratio=mechanism.motion_ratio,
        velocity_max=first * speed,
        acceleration_start=float(np.sqrt(squared(0.0))) * rate,
        acceleration_max=float(np.sqrt(_largest(squared, first))) * rate,
        jerk_start=float(jerk(0.0)) * change,
        jerk_max=_largest(jerk, first) * change,
    )


def _check_wheel(mechanism: GearDriven | Geneva) -> None:
    if not isinstance(mechanism, GearDriven | Geneva):
        remedy = "give a Geneva or a GearDriven"
        raise validate.fail("mechanism", "a slotted wheel", mechanism, remedy)


def _largest(function: Polynomial, end: float) -> float:
    """Greatest size of a polynomial between 0 and `end`."""
    # rounding may give a real root a small imaginary part
    roots = function.deriv().roots()
    inside = roots[(np.abs(roots.imag) < 1e-9 * end) & (roots.real > 0.0) & (roots.real < end)]
    return float(np.abs(function(np.array([0.0, end, *inside.real]))).max())
