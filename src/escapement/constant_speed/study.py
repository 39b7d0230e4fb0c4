"""Zones, reversals and torques of a million Geneva drives at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.constant_speed import geneva
from escapement.constant_speed.kernels import study
from escapement.mechanisms import Geneva
from escapement.model import FloatArray


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
    study(*wheel_numbers, which, flat, zone, reversals, top, place)
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
