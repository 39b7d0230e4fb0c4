"""Moment of the pin on the follower: at constant speed, or in any known motion of the driver."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.constant_speed.case import Case, checked, checked_number
from escapement.constant_speed.kernels import tabulate_torque
from escapement.errors import InvalidValue
from escapement.mechanisms.slotted import transmission
from escapement.model import FloatArray, Mechanism

if TYPE_CHECKING:
    from escapement.constant_speed.case import Load

_LARGEST = 1e280  # N m: sums and slopes of torques need room
_HAIR = 1e-12  # of a cell: what rounding may put an angle beyond its ends, or the exit


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
    inertia = checked_number("follower_inertia", follower_inertia)
    load = checked_number("load_torque", load_torque)
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


def table(case: Case, theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Follower angle, load torque, and g, contact moment and torque, at 1-D angles."""
    phi = np.asarray(case.mechanism.follower_angle(theta), dtype=float)
    load = load_at(case.load_torque, phi)
    out = np.empty((3, theta.size))
    path, friction, efficiency = case.mechanism.path, case.friction, case.efficiency
    tabulate_torque(path, theta, load, case.inertial, friction, efficiency, out)
    if not np.abs(out).max(initial=0.0) < _LARGEST:
        raise InvalidValue(
            "load_torque, follower_inertia, speed and friction must give a torque within the "
            "range of a double, got more; choose less extreme values"
        )
    return phi, load, out


def load_at(load: Load, phi: FloatArray) -> FloatArray:
    """Load torque at follower angles, of their shape [N m]."""
    values = _asked(load, phi) if callable(load) else np.asarray(load, dtype=float)
    if not np.isfinite(values).all():
        raise InvalidValue(
            "load_torque must give a finite torque at every follower angle, got "
            f"{float(values[~np.isfinite(values)].flat[0])!r}; check the function"
        )
    return np.array(np.broadcast_to(values, phi.shape))


def _asked(load: Callable[[FloatArray], ArrayLike], phi: FloatArray) -> FloatArray:
    """What a load function gives at follower angles, real numbers of their shape."""
    try:
        values = np.ma.filled(load(phi), np.nan)
        if values.dtype.kind in "biuf":
            return np.broadcast_to(values.astype(float), phi.shape)
        got = repr(values.reshape(-1)[:1].tolist())
    except (TypeError, ValueError) as error:
        got = str(error)
    got = " ".join(got.split())[:120]
    raise InvalidValue(
        "load_torque must be a function of an array of follower angles that gives the torque at "
        f"each, a real number, got: {got}; write it with NumPy, numpy.where for cases"
    )


def within_cell(mechanism: Mechanism, theta: FloatArray) -> FloatArray:
    """Driver angles within the cell, or the error; one a hair beyond an end or the exit is that."""
    entry, exit_ = mechanism.breaks[0], mechanism.breaks[-1]
    end = max(exit_, entry + mechanism.cell_angle)
    hair = _HAIR * (end - entry)
    outside = ~((theta >= entry - hair) & (theta <= end + hair))
    if outside.any():
        raise InvalidValue(
            f"theta must be between pin entry and the end of the cell, {entry!r} to {end!r} "
            f"rad, got {float(theta[outside].flat[0])!r}; count angles from dead centre"
        )
    engaged = theta <= exit_ + hair
    return np.where(engaged, np.clip(theta, entry, exit_), np.minimum(theta, end))


def finite(name: str, value: ArrayLike) -> FloatArray:
    """`value` as an array of finite real numbers."""
    remedy = "give finite numbers"
    try:
        given = np.ma.filled(value, np.nan)
    except (TypeError, ValueError):
        raise validate.fail(name, "finite numbers", value, remedy) from None
    if given.dtype.kind not in "iuf" or not np.isfinite(given).all():
        raise validate.fail(name, "finite numbers", value, remedy)
    return given.astype(float)
