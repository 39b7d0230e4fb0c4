"""Constant driver speed: torque, power and pin reversals (Filemon 1960), and indexing drives.

Modules are loaded when they are first used, because a case can be described without them. Read
`index_case` and `indexing` first.

- `index_case`: what is given of an indexing drive; `index_torque`, `index_loads`: the formulas of
  its figures, for one drive or many
- `indexing`, `index_rows`: one drive, and many; `cam_drive`: a cam to compare with
- `wall_changes`, `cycle_figures`, `knock`, `ringing`, `row_kernel`: the kernels
- `index_record`: what is told of a drive, in the order in which it is read
- `input_torque`, `contact`: torque and contact of a drive under any load, also a function
- `extrema`, `geneva`: extremes of the transmission functions, and Filemon's formulas
"""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from escapement.base import validate
from escapement.base.lazy import offered
from escapement.base.quantity import Declared, like, quantity
from escapement.mechanisms.protocol import Mechanism, checked
from escapement.model.checks import check_losses
from escapement.model.escapement import Escapement, Inertia

if TYPE_CHECKING:
    from escapement.constant_speed.contact import Load, TorqueState, contact_moment
    from escapement.constant_speed.extrema import (
        TransmissionExtrema,
        fewest_slots,
        greatest_follower_inertia,
        greatest_speed,
        jerk_function,
        least_load_torque,
        transmission_extrema,
    )
    from escapement.constant_speed.geneva import ReversalStudy, reversal_study
    from escapement.constant_speed.indexing import IndexingDrive, IndexState, index
    from escapement.constant_speed.input_torque import DriveTorque, drive_torque
    from escapement.numerics.chebyshev import Extremum

__all__ = [
    "DriveTorque", "Extremum", "IndexState", "IndexingDrive", "ReversalStudy", "TorqueState",
    "TransmissionExtrema", "contact_moment", "drive_torque", "fewest_slots",
    "greatest_follower_inertia", "greatest_speed", "index", "inertia_ratio", "jerk_function",
    "least_load_torque", "reversal_study", "transmission_extrema",
]  # fmt: skip

_SAMPLES = 721


@dataclass(frozen=True)
class Case(Declared):
    """A mechanism at constant driver speed, see `drive_torque` for the fields."""

    mechanism: Mechanism
    speed: float = field(metadata=quantity(
        "constant driver speed", "speed", exclusive=True, remedy="give the driver speed"
    ))  # fmt: skip
    load_torque: "Load" = field(
        metadata=like(Escapement, "load_torque", default=None, function=True)
    )
    follower_inertia: float = field(metadata=like(Inertia, "follower_inertia"))
    efficiency: float = field(metadata=quantity(
        "efficiency of the drive, in (0, 1]", exclusive=True, maximum=1.0, default=1.0,
        metavar="E", remedy="give the share of the drive's work that arrives, 1 for all of it"
    ))  # fmt: skip
    friction: float = field(metadata=like(Escapement, "friction"))

    def __post_init__(self) -> None:
        self.check_fields()
        check_losses(self, checked(self.mechanism).path.meshed)

    @property
    def inertial(self) -> float:
        """Inertia torque at unit follower acceleration function, I_f omega^2 [N m]."""
        return self.follower_inertia * self.speed * self.speed

    @property
    def half(self) -> float:
        """Driver angle where the first half of the engagement ends: dead centre [rad].

        For a table, or if angles are not counted from dead centre, it is the middle of the cell.
        """
        entry, exit_ = self.mechanism.breaks[0], self.mechanism.breaks[-1]
        centred = entry < 0.0 < exit_ and not self.mechanism.path.table
        return 0.0 if centred else 0.5 * (entry + exit_)

    @property
    def inertia_ratio(self) -> float:
        """Filemon's F = I_f omega^2/M_load [-].

        Raises
        ------
        InvalidValue
            Where the load torque is zero or varies.
        """
        return inertia_ratio(self.follower_inertia, self.speed, self.load_torque)

    @property
    def power_max(self: Any) -> float:
        """Greatest power of the drive [W]."""
        return float(self.torque_max * self.speed)

    @property
    def power_mean_to_dead_centre(self: Any) -> float:
        """Mean power over the first half of the engagement, Filemon's N2 = M_2av omega_2 [W]."""
        return float(self.torque_mean * self.speed)

    @property
    def peak_to_mean(self: Any) -> float:
        """Filemon's s, greatest over mean torque: the overload a motor must stand [-].

        NaN where a varying load helps so much that the mean is not positive.
        """
        return self.torque_max / self.torque_mean if self.torque_mean > 0.0 else math.nan

    @property
    def moment_deviation(self) -> float:
        """Greatest standard deviation of the contact moment, from a measured table's scatter [N m].

        0 for any other mechanism. If the moment between two reversals stays within two or three
        of these, the reversals may be due to the scatter.
        """
        mechanism = self.mechanism
        if mechanism.noise == 0.0:
            return 0.0
        import numpy as np

        theta = np.linspace(mechanism.breaks[0], mechanism.breaks[-1], _SAMPLES)
        return self.inertial * float(mechanism.deviation(theta).dg.max())


def inertia_ratio(follower_inertia: float, speed: float, load_torque: "Load") -> float:
    """Filemon's F = I_f omega^2/M_load: inertia against load [-].

    Raises
    ------
    InvalidValue
        Where the load torque is zero or varies: no F exists.
    """
    name, rule = "load_torque", "constant for an inertia ratio F"
    if callable(load_torque):
        raise validate.fail(name, rule, load_torque, "give a constant one")
    load = validate.positive(name, load_torque, "without a load there is no inertia ratio F")
    return follower_inertia * speed * speed / load


def tight(mechanism: Any) -> Any:
    """`mechanism`, or an error if its parts have errors, or its pins have clearance in their
    slots."""
    if clearance := checked(mechanism).clearance:
        remedy = "leave it out; simulate computes motions with clearance"
        raise validate.fail("clearance", "0 at constant speed", clearance, remedy)
    return mechanism


def __getattr__(name: str) -> Any:
    return offered(
        __name__, __all__, ("input_torque", "contact", "extrema", "geneva", "indexing"), name
    )
