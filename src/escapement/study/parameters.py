"""Every scalar of an escapement that a study may fix or sweep.

The table is the only place that knows a parameter: its key in the file, its rule,
its unit and its default. What a kind of mechanism adds is in its own table.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement import units, validate


@dataclass(frozen=True)
class Parameter:
    """A number of the model.

    long_name, quantity : what it is, and its key in `escapement.units`.
    minimum, maximum, exclusive, whole, fraction : the rule its values obey; a
        fraction may be written as text, "1/2".
    section, key : where its fixed value stands in the file ("" is top level).
    required, default : the fixed value when the file has none; None leaves the
        choice to the mechanism.
    """

    long_name: str
    quantity: str
    remedy: str
    key: str
    section: str = ""
    minimum: float = 0.0
    maximum: float = math.inf
    exclusive: bool = False
    whole: bool = False
    fraction: bool = False
    required: bool = False
    default: float | None = None

    @property
    def label(self) -> str:
        """Where the value stands in the file, for messages."""
        return f"{self.section}.{self.key}" if self.section else self.key

    def to_si(self, values: Any, system: str) -> Any:
        """Numbers in units of `system` in SI; whole numbers stay whole."""
        return values if self.whole else values * units.factor(self.quantity, system)

    def check(self, label: str, value: Any) -> float:
        """`value` as a number that obeys the rule; raises InvalidValue."""
        if self.whole:
            number = validate.number(label, value, self.remedy)
            whole = int(number) if number == int(number) else value
            most = None if self.maximum == math.inf else int(self.maximum)
            return validate.integer(label, whole, int(self.minimum), self.remedy, most)
        if self.fraction:
            return float(validate.rational(label, value, self.remedy, self.maximum))
        rule = validate.positive if self.exclusive else validate.non_negative
        checked = rule(label, value, self.remedy)
        if not self.minimum <= checked <= self.maximum:
            raise validate.fail(
                label, f"in [{self.minimum:g}, {self.maximum:g}]", value, self.remedy
            )
        return checked

    def check_all(self, label: str, values: NDArray[np.float64]) -> NDArray[Any]:
        """`values`, whole ones as integers; raises for the first that breaks the rule."""
        if self.fraction:
            return np.array([self.check(f"{label}[{i}]", x) for i, x in enumerate(values.tolist())])
        good = np.isfinite(values) & (values >= self.minimum) & (values <= self.maximum)
        if self.exclusive:
            good &= values > self.minimum
        if self.whole:
            good &= values == np.rint(values)
            good &= values < 2.0**53  # beyond it a double no longer tells whole numbers apart
        if not good.all():
            first = int(np.argmin(good))
            self.check(f"{label}[{first}]", float(values[first]))
            raise validate.fail(
                f"{label}[{first}]", "below 2^53", float(values[first]), self.remedy
            )
        return values.astype(np.int64) if self.whole else values


MODEL = {
    "friction": Parameter(
        "coefficient of friction between pin and slot",
        "ratio",
        "give a coefficient of friction, 0 for none",
        key="friction",
        default=0.0,
    ),
    "efficiency": Parameter(
        "share of the power that the mesh passes on",
        "ratio",
        "give a share of 1, 1 for no loss",
        key="efficiency",
        minimum=1e-3,
        maximum=1.0,
        default=1.0,
    ),
    "torque": Parameter(
        "driving torque",
        "torque",
        "give the constant driving torque",
        key="torque",
        exclusive=True,
        required=True,
    ),
    "load_torque": Parameter(
        "load torque on the follower",
        "torque",
        "give the opposing torque, 0 for none",
        key="load_torque",
        default=0.0,
    ),
    "initial_speed": Parameter(
        "driver speed at the first pin entry",
        "speed",
        "give the driver speed in rad/s, 0 to start from rest",
        key="initial_speed",
        default=0.0,
    ),
    "driver_inertia": Parameter(
        "moment of inertia of the driver",
        "inertia",
        "give the moment of inertia",
        key="driver",
        section="inertia",
        exclusive=True,
        required=True,
    ),
    "follower_inertia": Parameter(
        "moment of inertia of the follower",
        "inertia",
        "give the moment of inertia",
        key="follower",
        section="inertia",
        exclusive=True,
        required=True,
    ),
}
"""Parameters of an escapement, by the name of their axis.

A slot loses by friction, a mesh by its efficiency: no mechanism has both.
"""
