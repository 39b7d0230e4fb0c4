"""Moment of the pin on the follower, in any known motion of the driver."""

import numpy as np
from numpy.typing import ArrayLike

from escapement.constant_speed._case import (
    Load,
    checked_inertia,
    checked_load,
    finite,
    load_at,
    within_cell,
)
from escapement.constant_speed.extrema import checked
from escapement.errors import InvalidValue
from escapement.mechanisms.slotted import transmission
from escapement.model import FloatArray, Mechanism


def contact_moment(
    mechanism: Mechanism,
    theta: ArrayLike,
    speed: ArrayLike,
    acceleration: ArrayLike,
    load_torque: Load,
    follower_inertia: float,
) -> FloatArray:
    """Moment of the pin on the follower of a drive in any known motion [N m].

    N R = I_f (g theta_ddot + g' theta_dot^2) + M_load: the pin changes sides where
    it changes sign. With no acceleration it is what `drive_torque` works with.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry.
    theta, speed, acceleration : array_like
        Driver angle from dead centre [rad], within one cell, and its derivatives by
        time [rad/s, rad/s^2]; their shapes broadcast.
    load_torque, follower_inertia :
        As for `drive_torque`.

    Returns
    -------
    ndarray
        N R; 0 in the dwell, where the follower is locked.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    wanted = {"theta": theta, "speed": speed, "acceleration": acceleration}
    given = [finite(name, value) for name, value in wanted.items()]
    try:
        angles, speeds, rates = np.broadcast_arrays(*given)
    except ValueError:
        shapes = ", ".join(str(values.shape) for values in given)
        raise InvalidValue(
            f"theta, speed and acceleration must have shapes that fit, got {shapes}; give one of "
            "each for every state, or one for all"
        ) from None
    inertia, load = checked_inertia(follower_inertia), checked_load(load_torque)
    exit_ = checked(mechanism).breaks[-1]
    angles = within_cell(mechanism, angles)
    engaged = np.minimum(angles, exit_)
    ratios = transmission(mechanism.path, engaged)
    with np.errstate(over="ignore", invalid="ignore"):
        driven = inertia * (ratios.g * rates + ratios.dg * speeds**2)
    moment = load_at(load, np.asarray(mechanism.follower_angle(engaged))) + driven
    if not np.isfinite(moment).all():
        raise InvalidValue(
            "speed, acceleration and follower_inertia must give a moment within the range of a "
            "double, got more; choose less extreme values"
        )
    return np.where(angles > exit_, 0.0, moment)
