"""The force between pin and slot of a drive in known motion, and the torque that it needs.

The pin's moment on the follower is N R = M_load + I_f (g theta_ddot + g' theta_dot^2).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import check_number
from escapement.constant_speed import Case, tight
from escapement.mechanisms.protocol import FloatArray, Mechanism
from escapement.mechanisms.slotted import transmission

Load = float | Callable[[FloatArray], ArrayLike]
"""Load torque [N m], or a function that gives it at follower angles [rad]."""

_LARGEST = 1e280  # N m: sums and slopes of torques need room
_HAIR = 1e-12  # share of a cell by which rounding may put an angle beyond an end


class TorqueState(NamedTuple):
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
    it changes sign. Without acceleration it is the moment in `drive_torque`.

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
    ValueError
        When the shapes of the arrays do not fit.
    """
    given = {"theta": theta, "speed": speed, "acceleration": acceleration}
    states = (validate.numbers(name, value, "give finite numbers") for name, value in given.items())
    angles, speeds, rates = np.broadcast_arrays(*states)
    inertia = check_number(Case, "follower_inertia", follower_inertia)
    load = check_number(Case, "load_torque", load_torque)
    engaged, locked = within_cell(tight(mechanism), angles)
    ratios = transmission(mechanism.path, engaged)
    driven = inertia * (ratios.g * rates + ratios.dg * speeds**2)
    moment = _load_at(load, np.asarray(mechanism.follower_angle(engaged))) + driven
    return np.where(locked, 0.0, moment)


def engaged_state(case: Case, theta: FloatArray) -> TorqueState:
    """Drive and contact at driver angles of the engagement.

    The equation of motion with theta_ddot = 0: N R = load + I_f omega^2 g' and p = g + s mu |u|,
    s the sign of N R. The torque is p N R / eta where the driver works, and eta p N R where it
    is driven; with mu = 0 that is Filemon's (6), whose 1/eta holds for the driving part.
    """
    phi = np.asarray(case.mechanism.follower_angle(theta), dtype=float)
    load = _load_at(case.load_torque, phi)
    found = transmission(case.mechanism.path, theta)
    with np.errstate(over="ignore", invalid="ignore"):
        moment = load + case.inertial * found.dg
        # at moment 0 the side of the slot does not matter, because without force there is no
        # friction
        side = np.where(moment >= 0.0, 1.0, -1.0)
        torque = (found.g + side * case.friction * np.abs(found.u)) * moment
        torque = np.where(torque >= 0.0, torque / case.efficiency, torque * case.efficiency)
    # also true of NaN, which eigenvalue solvers would answer with an error of their own
    if not np.abs(torque).max(initial=0.0) < _LARGEST:
        raise InvalidValue(
            "load_torque, follower_inertia, speed and friction must give a torque within the "
            "range of a double, got more; choose less extreme values"
        )
    return TorqueState(theta, phi, torque, moment, load)


def _load_at(load: Load, phi: FloatArray) -> FloatArray:
    """Load torque at follower angles, of their shape [N m]."""
    if not callable(load):
        return np.full(phi.shape, float(load))
    try:
        # the cast refuses complex numbers and text, which `float` alone would let through
        values = np.broadcast_to(load(phi), phi.shape).astype(float, casting="same_kind")
    except (TypeError, ValueError) as error:
        got = " ".join(str(error).split())[:120]
        raise InvalidValue(
            "load_torque must be a function of an array of follower angles that gives the torque "
            f"at each, a real number, got: {got}; write it with NumPy, numpy.where for cases"
        ) from None
    if not np.isfinite(values).all():
        raise InvalidValue(
            "load_torque must give a finite torque at every follower angle, got "
            f"{float(values[~np.isfinite(values)][0])!r}; check the function"
        )
    return values


def within_cell(mechanism: Mechanism, theta: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Driver angles, those of the dwell replaced by the exit, and whether each is one of these.

    An angle outside the cell is an error; one that rounding puts beyond an end or the exit counts
    as that.
    """
    entry, exit_ = mechanism.breaks[0], mechanism.breaks[-1]
    end = max(exit_, entry + mechanism.cell_angle)
    hair = _HAIR * (end - entry)
    outside = ~((theta >= entry - hair) & (theta <= end + hair))
    if outside.any():
        raise InvalidValue(
            f"theta must be between pin entry and the end of the cell, {entry!r} to {end!r} "
            f"rad, got {float(theta[outside].flat[0])!r}; count angles from dead centre"
        )
    return np.clip(theta, entry, exit_), theta > exit_ + hair
