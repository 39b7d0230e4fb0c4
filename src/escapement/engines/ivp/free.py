"""A driver that turns free of the follower, or stands still, in closed form."""

from typing import Any

import numpy as np

from escapement.dynamics.codes import Ending
from escapement.engines.ivp.law import SceneLaw
from escapement.engines.ivp.piece import Solution, Task


def is_free(law: SceneLaw, task: Task) -> bool:
    """Whether nothing but a constant torque acts: in a dwell, if no drag brakes the driver."""
    scene = law.scene
    dragged = scene.driver_drag + scene.driver_viscous + scene.pace > 0.0
    return task.sign == 0.0 and law.is_steady and not dragged


def turn_free(law: SceneLaw, task: Task) -> Solution:
    """Turn until the goal, a stop or the end of the time."""
    theta, speed = task.theta, task.speed
    rate, loss = law.acceleration(theta, speed, 0.0), law.loss_rates(theta, speed**2, 0.0)
    distance = task.end - theta
    square = speed * speed + 2.0 * rate * distance
    if square > 0.0:
        length, ending = 2.0 * distance / (speed + np.sqrt(square)), Ending.ARRIVED
    else:
        length, ending = -speed / rate, Ending.STOPPED
    if length > task.time:
        length, ending = task.time, Ending.OVER

    def at(time: Any) -> Any:
        driver_angle = time * (speed + 0.5 * rate * time)
        return np.array([driver_angle, speed + rate * time, *np.multiply.outer(loss, driver_angle)])

    return Solution(at, theta, 1.0, float(length), ending, [], rate, rate)


def stand_still(law: SceneLaw, theta: float) -> Solution:
    """A driver that stands still for good."""

    def at(time: Any) -> Any:
        return np.zeros((2 + law.losses.size, *np.shape(time)))

    return Solution(at, theta, 1.0, np.inf, Ending.STOPPED, [], 0.0, 0.0)
