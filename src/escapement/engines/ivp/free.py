"""A driver that turns free of the follower, or stands still, in closed form."""

from typing import Any, NamedTuple

import numpy as np

from escapement.engines.ivp.law import SceneLaw
from escapement.engines.ivp.piece import PieceEnd, Task
from escapement.mechanisms.protocol import FloatArray


class FreeTurn(NamedTuple):
    """A driver at constant acceleration; a piece as `piece.Solution` is, in natural units.

    theta, speed : driver angle [rad] and speed at the start.
    rate : acceleration.
    loss : work lost per driver angle in each loss of the scene.
    """

    theta: float
    speed: float
    rate: float
    loss: FloatArray
    length: float
    ending: PieceEnd
    extrema: tuple[float, ...] = ()

    @property
    def first_rate(self) -> float:
        """Acceleration at the start."""
        return self.rate

    @property
    def last_rate(self) -> float:
        """Acceleration at the end."""
        return self.rate

    def state(self, time: Any) -> tuple[Any, Any, Any]:
        """Driver angle [rad], speed and losses in natural units."""
        driver_angle = time * (self.speed + 0.5 * self.rate * time)
        return (
            self.theta + driver_angle,
            self.speed + self.rate * time,
            np.multiply.outer(self.loss, driver_angle),
        )


def is_free(law: SceneLaw, task: Task) -> bool:
    """Whether nothing but a constant torque acts: in a dwell, if no drag brakes the driver."""
    dragged = law.scene.driver_drag + law.scene.driver_viscous > 0.0
    return task.sign == 0.0 and law.is_steady and not dragged


def turn_free(law: SceneLaw, task: Task) -> FreeTurn:
    """Turn until the goal, a stop or the end of the time."""
    theta, speed = task.theta, task.speed
    rate, loss = law.acceleration(theta, speed, 0.0), law.loss_rates(theta, speed**2, 0.0)
    distance = task.end - theta
    square = speed * speed + 2.0 * rate * distance
    if square > 0.0:
        length, ending = 2.0 * distance / (speed + np.sqrt(square)), PieceEnd.ARRIVED
    else:
        length, ending = -speed / rate, PieceEnd.STOPPED
    if length > task.time:
        length, ending = task.time, PieceEnd.TIME_UP
    return FreeTurn(theta, speed, rate, loss, float(length), ending)


def stand_still(law: SceneLaw, theta: float) -> FreeTurn:
    """A driver that stands still for good."""
    return FreeTurn(theta, 0.0, 0.0, np.zeros(law.losses.size), np.inf, PieceEnd.STOPPED)
