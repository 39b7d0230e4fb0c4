"""A solved piece of a motion, for the state at any time within it."""

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Solution:
    """A piece as solved: what became of it, and any state within.

    Times are natural ones since its start. `ended` is "arrived", "reversed",
    "stopped" or "horizon"; extrema are times, `rates` the acceleration after the
    start and before the end.
    """

    dense: Any
    anchor: float
    unit: float
    length: float
    ended: str
    extrema: list[float]
    rates: tuple[float, float]

    def __call__(self, time: Any) -> tuple[Any, Any, Any]:
        """Driver angle [rad], speed and friction loss; natural units."""
        y = self.dense(np.maximum(time * self.unit, 0.0))
        return y[0] + self.anchor, y[1] * self.unit, y[2] * self.unit**2


@dataclass(frozen=True)
class Landed:
    """Dense output with its last step taken anew, to end where the piece ends.

    The interpolant inside a step is a less accurate one than the step itself, and
    where an event falls into a step that runs on beyond it, the error would stay.
    """

    before: Any
    join: float
    landing: Any

    def __call__(self, x: Any) -> Any:
        return np.where(x < self.join, self.before(x), self.landing(x))


@dataclass(frozen=True)
class Free:
    """Driver turning alone under the torque: exact."""

    theta: float
    speed: float
    rho: float
    length: float = np.inf

    def __call__(self, time: Any) -> tuple[Any, Any, Any]:
        """Driver angle [rad], speed and friction loss; natural units."""
        theta = self.theta + time * (self.speed + time / (2.0 * self.rho))
        return theta, self.speed + time / self.rho, 0.0 * time
