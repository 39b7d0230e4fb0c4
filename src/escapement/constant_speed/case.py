"""What is asked of a constant-speed analysis, and the equation of motion at that speed.

The pin's moment on the follower is N R = M_load + I_f (g theta_ddot + g' theta_dot^2).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from escapement import validate
from escapement.errors import InvalidValue
from escapement.lazy import Lazy
from escapement.model import Escapement, Inertia, Mechanism, check_losses, is_mechanism
from escapement.quantity import Declared, check_number, like, quantity

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike

    from escapement.mechanisms import slotted
    from escapement.model import FloatArray

    Load = float | Callable[[FloatArray], ArrayLike]
    """Load torque [N m], or a function that gives it at follower angles [rad]."""
else:
    np, slotted = Lazy("numpy"), Lazy("escapement.mechanisms.slotted")

_LARGEST = 1e280  # N m: sums and slopes of torques need room
_HAIR = 1e-12  # of a cell: what rounding may put an angle beyond its ends, or the exit


@dataclass(frozen=True)
class Case(Declared):
    """A mechanism at constant driver speed, see `drive_torque` for the fields."""

    mechanism: Mechanism
    speed: float = field(metadata=quantity(
        "constant driver speed", "speed", exclusive=True, remedy="give the driver speed"
    ))  # fmt: skip
    load_torque: Load = field(metadata=like(Escapement, "load_torque", default=None, function=True))
    follower_inertia: float = field(metadata=like(Inertia, "follower_inertia"))
    efficiency: float = field(metadata=quantity(
        "efficiency of the drive, in (0, 1]", exclusive=True, maximum=1.0, default=1.0,
        metavar="E", remedy="give the share of the drive's work that arrives, 1 for all of it"
    ))  # fmt: skip
    friction: float = field(metadata=like(Escapement, "friction"))

    def __post_init__(self) -> None:
        checked(self.mechanism)
        self.check_fields()
        check_losses(self, self.mechanism.path.table)

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


def checked(mechanism: Mechanism) -> Mechanism:
    """`mechanism`, or the error that it is none."""
    if not is_mechanism(mechanism):
        raise validate.fail(
            "mechanism", "a mechanism", mechanism, "give for example Geneva(slots=4)"
        )
    return mechanism


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
    ValueError
        When the shapes of the arrays do not fit.
    """
    given = {"theta": theta, "speed": speed, "acceleration": acceleration}
    states = [validate.numbers(name, value, "give finite numbers") for name, value in given.items()]
    angles, speeds, rates = np.broadcast_arrays(*states)
    inertia = check_number(Case, "follower_inertia", follower_inertia)
    load = check_number(Case, "load_torque", load_torque)
    exit_ = checked(mechanism).breaks[-1]
    angles = within_cell(mechanism, angles)
    # the transmission is that of the exit all through the dwell, and is masked there below
    engaged = np.minimum(angles, exit_)
    ratios = slotted.transmission(mechanism.path, engaged)
    driven = inertia * (ratios.g * rates + ratios.dg * speeds**2)
    moment = load_at(load, np.asarray(mechanism.follower_angle(engaged))) + driven
    return np.where(angles > exit_, 0.0, moment)


def table(case: Case, theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Follower angle, load torque, and g, contact moment and torque, at 1-D angles.

    The equation of motion with theta_ddot = 0: N R = load + I_f omega^2 g' and p = g + s mu |u|,
    s the sign of N R. The torque is p N R / eta where the driver works, and eta p N R where it
    is driven; with mu = 0 that is Filemon's (6), whose 1/eta holds for the driving part.
    """
    phi = np.asarray(case.mechanism.follower_angle(theta), dtype=float)
    load = load_at(case.load_torque, phi)
    found = slotted.transmission(case.mechanism.path, theta)
    with np.errstate(over="ignore", invalid="ignore"):
        moment = load + case.inertial * found.dg
        # at moment 0 either side of the slot may be meant, as no force means no friction
        side = np.where(moment >= 0.0, 1.0, -1.0)
        torque = (found.g + side * case.friction * np.abs(found.u)) * moment
        torque = np.where(torque >= 0.0, torque / case.efficiency, torque * case.efficiency)
    # also true of NaN, which eigenvalue solvers would answer with an error of their own
    if not np.abs(torque).max(initial=0.0) < _LARGEST:
        raise InvalidValue(
            "load_torque, follower_inertia, speed and friction must give a torque within the "
            "range of a double, got more; choose less extreme values"
        )
    return phi, load, np.array([found.g, moment, torque])


def load_at(load: Load, phi: FloatArray) -> FloatArray:
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
