"""What is asked of a constant-speed analysis: checked values, and functions of the angle."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from escapement import validate
from escapement.constant_speed.extrema import checked
from escapement.constant_speed.kernels import tabulate_torque
from escapement.errors import InvalidValue
from escapement.model import FloatArray, Mechanism

Load = float | Callable[[FloatArray], ArrayLike]
"""Load torque [N m], or a function that gives it at follower angles [rad]."""

_LARGEST = 1e280  # N m: sums and slopes of torques need room
_HAIR = 1e-12  # of a cell: what rounding may put an angle beyond its ends, or the exit


@dataclass(frozen=True)
class Case:
    """A mechanism at constant driver speed, see `drive_torque` for the fields."""

    mechanism: Mechanism
    speed: float
    load_torque: Load
    follower_inertia: float
    efficiency: float
    friction: float

    def __post_init__(self) -> None:
        values = {
            "mechanism": checked(self.mechanism),
            "speed": checked_speed(self.speed),
            "load_torque": checked_load(self.load_torque),
            "follower_inertia": checked_inertia(self.follower_inertia),
            "efficiency": _efficiency(self.efficiency),
            "friction": validate.non_negative(
                "friction", self.friction, "give a coefficient of friction, 0 for none"
            ),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        if self.friction > 0.0 and self.mechanism.path.table:
            raise validate.fail(
                "friction", "0 for a mechanism without a slot", self.friction, "give its efficiency"
            )
        if not 0.0 < self.inertial < math.inf:
            raise InvalidValue(
                "speed and follower_inertia must give a torque a double can hold, got "
                f"{self.speed!r} rad/s and {self.follower_inertia!r} kg m^2; choose other units"
            )

    @property
    def inertial(self) -> float:
        """Inertia torque at unit follower acceleration function, I_f omega^2 [N m]."""
        return self.follower_inertia * self.speed * self.speed

    @property
    def half(self) -> float:
        """Driver angle where the first half of the engagement ends: dead centre [rad].

        The middle, of a table or where angles are counted from elsewhere.
        """
        entry, exit_ = self.mechanism.breaks[0], self.mechanism.breaks[-1]
        if entry < 0.0 < exit_ and not self.mechanism.path.table:
            return 0.0
        return 0.5 * (entry + exit_)


def checked_speed(value: float) -> float:
    """A driver speed that keeps its rule, or the error."""
    return validate.positive("speed", value, "give the driver speed in rad/s")


def checked_inertia(value: float) -> float:
    """A follower inertia that keeps its rule, or the error."""
    return validate.positive("follower_inertia", value, "give the moment of inertia in kg m^2")


def checked_load(value: Load) -> Load:
    """A load torque that keeps its rule, or the error."""
    if callable(value):
        return value
    return validate.non_negative(
        "load_torque", value, "give the opposing torque in N m, 0 for none, or a function"
    )


def _efficiency(value: float) -> float:
    remedy = "give the share of the drive's work that arrives, 1 for all of it"
    result = validate.number("efficiency", value, remedy)
    if not 0.0 < result <= 1.0:
        raise validate.fail("efficiency", "greater than 0 and at most 1", value, remedy)
    return result


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
