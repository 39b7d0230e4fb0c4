"""Zones, reversals and torques of a million Geneva drives at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.constant_speed import geneva
from escapement.jit import inner_jit, jit
from escapement.mechanisms import Geneva
from escapement.mechanisms.slotted import transmission_at
from escapement.model import FloatArray
from escapement.roots import newton_in_bracket
from escapement.scene import Path

_ROUNDING = 8.0 * np.finfo(np.float64).eps  # an F this close to a limit is the limit


@dataclass(frozen=True)
class ReversalStudy:
    """Filemon's figures over numbers of slots n and inertia ratios F.

    All but `reversals` have the shape n and F broadcast to. Torques are those of a drive
    without losses, over the load torque.

    slots, inertia_ratio : n and F [-].
    zone : 1, 2 or 3 (u1).
    reversals : driver angles from dead centre [rad], shape (..., 2); NaN for
        one that is not there.
    torque_max, torque_max_angle : greatest torque [-] and its angle [rad].
    torque_mean : mean from pin entry to dead centre (10) [-].
    """

    slots: np.ndarray
    inertia_ratio: FloatArray
    zone: np.ndarray
    reversals: FloatArray
    torque_max: FloatArray
    torque_max_angle: FloatArray
    torque_mean: FloatArray

    @property
    def reversal_count(self) -> np.ndarray:
        """Pin reversals an engagement: 0, 2 or 1 in zone 1, 2 or 3."""
        result: np.ndarray = np.array([0, 0, 2, 1])[self.zone]
        return result

    @property
    def peak_to_mean(self) -> FloatArray:
        """Filemon's s, greatest over mean torque [-]."""
        return self.torque_max / self.torque_mean


def reversal_study(
    slots: ArrayLike, inertia_ratio: ArrayLike, internal: bool = False
) -> ReversalStudy:
    """Zones, reversal angles, greatest and mean torque of many Geneva drives.

    Without friction, under a constant load; about a microsecond a case.

    Parameters
    ----------
    slots : array_like of int
        Numbers of slots n, >= 3.
    inertia_ratio : array_like
        F = I_f omega^2/M_load [-], >= 0; broadcast against `slots`.
    internal : bool
        Whether the wheels are internal ones.

    Raises
    ------
    InvalidValue
        When a number of slots or an F breaks its rule.
    ValueError
        When the shapes of both do not fit.

    Source: Filemon (1960), eqs. 7 to 11.
    """
    n, ratio = _checked(slots, inertia_ratio)
    # each wheel is made once, however many cases it has
    wheels, wheel = np.unique(n, return_inverse=True)
    drives = [Geneva(int(count), pins=1, internal=internal) for count in wheels]
    limit_12, limit_23 = geneva.reversal_limits(wheels, internal)
    steepest = geneva.acceleration_max_angle(wheels, internal)
    d, a = geneva.mean_factors(wheels, internal)
    entry = np.array([drive.breaks[0] for drive in drives])
    paths = np.array([drive.path.numbers for drive in drives], dtype=float, ndmin=2)
    flat, which = np.ascontiguousarray(ratio.reshape(-1)), wheel.reshape(-1)
    zone = np.empty(flat.size, dtype=np.uint8)
    reversals = np.empty((flat.size, 2))
    top, place = np.empty(flat.size), np.empty(flat.size)
    wheel_numbers = (paths, np.empty(0), entry, steepest, limit_12, limit_23)
    _fill(*wheel_numbers, which, flat, zone, reversals, top, place)
    shape = n.shape
    mean = d[which] * (1.0 + flat * a[which])
    return ReversalStudy(
        n, ratio, zone.reshape(shape), reversals.reshape(*shape, 2),
        top.reshape(shape), place.reshape(shape), mean.reshape(shape),
    )  # fmt: skip


def _checked(slots: ArrayLike, inertia_ratio: ArrayLike) -> tuple[np.ndarray, FloatArray]:
    ratio = validate.numbers("inertia_ratio", inertia_ratio, "give F = I_f omega^2/M_load")
    n = validate.numbers("slots", slots, "give numbers of slots")
    for name, values, wrong, rule in (
        ("slots", n, (n < 3) | (n != np.rint(n)), "whole numbers of at least 3"),
        ("inertia_ratio", ratio, ratio < 0.0, "at least 0"),
    ):
        if wrong.any():
            raise validate.fail(name, rule, values[wrong][0].item(), "correct it")
    n, ratio = np.broadcast_arrays(n.astype(int), ratio)
    return n, ratio


@jit
def derivatives_at(path, theta):
    """(g, g', g'', g''') of a slotted path, from u' = a b - (a + b) g - u^2 + g^2."""
    g, u, dg = transmission_at(path, theta)
    total = path.numbers[6] - 2.0 * g
    du = 0.25 * path.numbers[6] ** 2 - path.numbers[0] ** 2 - path.numbers[6] * g - u * u + g * g
    ddu = -dg * total - 2.0 * u * du
    return (
        g,
        dg,
        du * total - 2.0 * u * dg,
        ddu * total - 4.0 * du * dg - 2.0 * u * (du * total - 2.0 * u * dg),
    )


@inner_jit
def _root(path, ratio, low, high, rising, of_torque):
    """Root between two angles of 1 + F g', or of the slope of the torque g (1 + F g')."""
    theta = 0.5 * (low + high)
    for _ in range(100):
        g, dg, ddg, dddg = derivatives_at(path, theta)
        value, slope = 1.0 + ratio * dg, ratio * ddg
        if of_torque:
            value = dg + ratio * (dg * dg + g * ddg)
            slope = ddg + ratio * (3.0 * dg * ddg + g * dddg)
        guess, low, high = newton_in_bracket(theta, value, slope, low, high, rising)
        if abs(guess - theta) <= 1e-16 * abs(theta):
            break
        theta = guess
    return theta


@jit
def _fill(
    paths, corners, entry, steepest, limit_12, limit_23, wheel, ratio, zone, reversals, top, place
):
    """Zones, reversal angles and torque maxima of many wheels and inertia ratios.

    paths, entry, steepest, limit_12, limit_23 hold one row a wheel: numbers of its path, pin
    entry, angle of greatest deceleration and Filemon's limits; wheel and ratio,
    one entry a case, say which and at what F. The last four are filled: zone 1,
    2 or 3, two reversal angles or NaN, and the greatest g (1 + F g') with its angle.
    """
    for i in range(ratio.size):
        k, f = wheel[i], ratio[i]
        path = Path(False, paths[k], corners)
        reversals[i, 0] = reversals[i, 1] = np.nan
        # F12 and F23 themselves belong to the zones without a second reversal
        zone[i] = 2
        if f <= limit_12[k] * (1.0 + _ROUNDING):
            zone[i] = 1
        elif f >= limit_23[k] * (1.0 - _ROUNDING):
            zone[i] = 3
        # g' falls from dead centre to its least value and rises again towards the exit
        if zone[i] > 1:
            reversals[i, 0] = _root(path, f, 0.0, steepest[k], False, False)
        if zone[i] == 2:
            reversals[i, 1] = _root(path, f, steepest[k], -entry[k], True, False)
        place[i] = _root(path, f, entry[k], 0.0, False, True)
        g, dg, _ddg, _dddg = derivatives_at(path, place[i])
        top[i] = g * (1.0 + f * dg)
