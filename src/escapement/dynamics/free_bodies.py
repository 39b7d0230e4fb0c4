"""Driver and follower as two bodies, each with the same equation of motion.

A body of inertia I moves at the speed v. Behind a train of efficiency eta it has a shaft, whose
inertia I_s is referred to the body. Of the torque T on the shaft the train takes in

    q = T - I_s dv/dt

and the body receives e q, where e is eta if power flows to the body, and 1/eta if it flows back:

    I dv/dt = e q + P - sign(v) H - (c |v| + nu) v

P is the push of the contact, H the dry friction of bearing and journal, and c and nu are the
coefficients of drag. A motor's torque T falls by nu_m v with the speed. The driver's shaft is that
of the barrel, with the torque of the drive; the follower's is that of the load, whose torque is
-sign(v) M. A load that changes with the follower's angle is part of P. Friction never drives: a
driver at rest that the drive cannot move is held.

The sign of q (I + e I_s) = I T - I_s (P - ..) does not depend on e, so that the direction of the
power is explicit. Along a wall both bodies have one degree of freedom: see `law`.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.load import has_load_curve, load_over
from escapement.dynamics.torque import torque_at
from escapement.numerics.jit import inner_jit


class FreeBody(NamedTuple):
    """Driver or follower in natural units.

    near, far : inertia I of the body, and I_s of the shaft behind its train.
    efficiency : eta of the train.
    drag, viscous : coefficients c and nu.
    motor : coefficient nu_m of a motor on the shaft; without losses of its train `viscous` has it.
    """

    near: float
    far: float
    efficiency: float
    drag: float
    viscous: float
    motor: float


class Movement(NamedTuple):
    """Acceleration of a body, and the torques that it loses, positive against a positive speed.

    inertia : I + e I_s.
    through : q times this inertia; its sign says where the power in the train flows.
    """

    rate: float
    inertia: float
    through: float
    friction: float
    drag: float
    train: float


@inner_jit
def driver_of(scene):
    """The driver, with the barrel behind its train."""
    return FreeBody(
        near=scene.rho - scene.barrel, far=scene.barrel, efficiency=scene.barrel_efficiency,
        drag=scene.driver_drag, viscous=scene.driver_viscous - scene.motor, motor=scene.motor,
    )  # fmt: skip


@inner_jit
def follower_of(scene):
    """The follower, with the load behind its train."""
    return FreeBody(
        near=1.0 - scene.load_train, far=scene.load_train, efficiency=scene.load_train_efficiency,
        drag=scene.follower_drag, viscous=scene.follower_viscous, motor=0.0,
    )  # fmt: skip


@inner_jit
def shared(efficiency, flow):
    """The factor e on the torque through a train: eta where the flow of power to the body that
    moves is +1, 1/eta where it is -1, and in between near rest.
    """
    half = 0.5 * (1.0 / efficiency - efficiency)
    return efficiency + half - flow * half


@inner_jit
def move(body, speed, sense, torque, push, friction):
    """Acceleration and losses of a body.

    Parameters
    ----------
    speed, sense : v, and its sign, or a number between -1 and 1 that stands for it near rest.
    torque, push, friction : T, P and H.
    """
    friction *= sense
    drag = (body.drag * abs(speed) + body.viscous) * speed
    other, slope = push - friction - drag, body.motor * speed
    torque -= slope
    through, share = body.near * torque - body.far * other, 1.0
    if body.efficiency != 1.0:
        share = shared(body.efficiency, sense if through >= 0.0 else -sense)
    inertia = body.near + share * body.far
    rate = (share * torque + other) / inertia
    train = (1.0 - share) * (torque - body.far * rate)
    drag += slope
    return Movement(
        rate=rate, inertia=inertia, through=through, friction=friction, drag=drag, train=train
    )


@inner_jit
def drag_slope(body, speed):
    """By how much the drag grows with the speed."""
    return 2.0 * body.drag * abs(speed) + body.viscous


@inner_jit
def free_driver(scene, theta, speed, sense):
    """The driver without contact, which turns in this sense; it is held if that is 0."""
    torque = torque_at(theta, scene)[0] if sense != 0.0 else 0.0
    return move(driver_of(scene), speed, sense, torque, 0.0, scene.bearing)


@inner_jit
def free_follower(scene, phi, turning, sense):
    """The follower without contact, which turns in this sense; it is held if that is 0."""
    push = 0.0
    if has_load_curve(scene) and sense != 0.0:
        push = -load_over(phi, sense, scene.driver_angle, scene)[0]
    return move(follower_of(scene), turning, sense, -sense * scene.load, push, 0.0)


@inner_jit
def follower_sense(scene, phi, turning):
    """Sense in which a follower without contact turns, 0 at rest if nothing moves it."""
    if turning != 0.0 or not has_load_curve(scene):
        return np.sign(turning)
    sense = -np.sign(load_over(phi, 0.0, scene.driver_angle, scene)[0])
    return sense if sense * free_follower(scene, phi, 0.0, sense).rate > 0.0 else 0.0


@inner_jit
def driver_sense(scene, theta, speed):
    """Sense in which a driver without contact turns, 0 at rest if its bearing holds it."""
    if speed != 0.0:
        return np.sign(speed)
    return 1.0 if free_driver(scene, theta, 0.0, 1.0).rate > 0.0 else 0.0
