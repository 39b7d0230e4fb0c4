"""What is asked of a constant-speed analysis: checked values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from escapement import validate
from escapement.model import Escapement, Inertia, Mechanism, check_losses, is_mechanism
from escapement.quantity import Declared, check_number, like, quantity

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from escapement.model import FloatArray

    Load = float | Callable[[FloatArray], ArrayLike]
    """Load torque [N m], or a function that gives it at follower angles [rad]."""


@dataclass(frozen=True)
class Case(Declared):
    """A mechanism at constant driver speed, see `drive_torque` for the fields."""

    mechanism: Mechanism
    speed: float = field(metadata=quantity(
        "constant driver speed", "speed", exclusive=True, remedy="give the driver speed"
    ))  # fmt: skip
    load_torque: Load = field(metadata=like(
        Escapement, "load_torque", default=None, function=True,
        remedy="give the opposing torque, 0 for none, or a function"
    ))  # fmt: skip
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
    def load_varies(self) -> bool:
        """Whether the load is a function of the follower angle."""
        return callable(self.load_torque)

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


def checked_number(name: str, value: Any) -> Any:
    """A number of a case that keeps its rule, or the error."""
    return check_number(Case, name, value)
