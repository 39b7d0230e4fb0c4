"""Accelerations of driver and follower that do not touch each other.

Friction never drives: a body at rest that the torque on it cannot move is held.
"""

import numpy as np

from escapement.dynamics.law import is_drag_free, is_viscous
from escapement.dynamics.torque import REST, is_constant, is_undriven, torque_at
from escapement.dynamics.train_losses import passed_on
from escapement.numerics.jit import inner_jit


@inner_jit
def driver_rate(scene, theta, speed, sense):
    """theta_ddot of a driver without contact that turns in this sense, 0 if it is held."""
    if sense == 0.0:
        return 0.0
    torque = torque_at(theta, scene)[0]
    lost = scene.bearing + scene.driver_drag * speed * speed
    # sense times speed, not its magnitude: the law stays smooth if a trial passes a reversal
    lost = sense * (lost + scene.driver_viscous * sense * speed)
    if scene.barrel_efficiency == 1.0:
        return (torque - lost) / scene.rho
    near = scene.rho - scene.barrel
    return passed_on(near, scene.barrel, torque, -lost, scene.barrel_efficiency, sense)[0]


@inner_jit
def follower_rate(scene, turning, sense):
    """phi_ddot of a follower without contact that turns in this sense, 0 at rest."""
    air = scene.follower_drag * turning * turning + scene.follower_viscous * sense * turning
    if scene.load_train_efficiency == 1.0 or sense == 0.0:
        return -sense * (scene.load + air)
    near, efficiency = 1.0 - scene.load_train, scene.load_train_efficiency
    return passed_on(near, scene.load_train, -sense * scene.load, -sense * air, efficiency, sense)[
        0
    ]


@inner_jit
def driver_sense(scene, theta, speed):
    """Sense in which a driver without contact turns, 0 at rest if its bearing holds it."""
    if speed != 0.0:
        return np.sign(speed)
    return 1.0 if driver_rate(scene, theta, 0.0, 1.0) > 0.0 else 0.0


@inner_jit
def is_calm(scene, theta, speed, turning):
    """Whether only viscous drag acts and both bodies count as at rest: `law.rest_speed`."""
    if not (is_viscous(scene) and is_undriven(theta, scene)):
        return False
    return scene.rho * speed * speed + turning * turning <= (1.0 + 1e-9) * scene.rho * REST


@inner_jit
def is_even(scene):
    """Whether driver and follower have constant accelerations without contact."""
    return is_constant(scene) and is_drag_free(scene)
