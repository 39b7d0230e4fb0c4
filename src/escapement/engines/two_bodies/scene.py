"""An escapement of two bodies as the kernels take it."""

from typing import Any, NamedTuple

import numpy as np

from escapement.engines.two_bodies.law import Law
from escapement.engines.two_bodies.march import BEGIN
from escapement.engines.two_bodies.pairs import joints_of, pairs_of
from escapement.model.escapement import Escapement

_KEY = "two_bodies.prepared"


class Prepared(NamedTuple):
    """What `march.march` takes: the law, the pairs of features, which of them meet, the pitches of
    both bodies; and the start.
    """

    law: Law
    pairs: np.ndarray
    joints: Any
    pitches: tuple[float, float]
    begin: np.ndarray


def prepared(escapement: Escapement) -> Prepared:
    """The escapement in natural units, kept on it so that its next call has it at once."""
    kept = escapement.kept
    if _KEY not in kept:
        kept[_KEY] = _prepare(escapement)
    found: Prepared = kept[_KEY]
    return found


def _prepare(escapement: Escapement) -> Prepared:
    machine: Any = escapement.mechanism
    scene, driver, follower = escapement.scene, machine.driver_features, machine.follower_features
    theta, phi = (float(angle) for angle in machine.start)
    theta %= machine.pitch  # the driver looks the same
    unit = escapement.torque_unit
    spring, weight = escapement.follower_spring / unit, escapement.follower_gravity / unit
    resisting = (
        *(scene.driver_drag, scene.follower_drag, scene.driver_viscous, scene.follower_viscous),
        *(spring, weight, float(scene.torque.size != 3)),
    )
    law = Law(
        centre=float(machine.axes_distance),
        rho=scene.rho,
        mu=scene.mu_plus,
        torque=scene.torque,
        gain=scene.gain,
        begin=theta,
        load=scene.load,
        bearing=scene.bearing,
        driver_drag=scene.driver_drag,
        follower_drag=scene.follower_drag,
        driver_viscous=scene.driver_viscous,
        follower_viscous=scene.follower_viscous,
        driver_journal=scene.driver_journal,
        follower_journal=scene.follower_journal,
        spring=spring,
        weight=weight,
        rest=escapement.follower_rest_angle,
        restitution=escapement.restitution,
        plain=not any(resisting),
    )
    begin = np.zeros(1, BEGIN)
    begin["theta"], begin["phi"], begin["fresh"] = theta, phi, 1
    pitches = 2.0 * np.pi / driver.fold, 2.0 * np.pi / follower.fold
    pairs = pairs_of(driver, follower)
    return Prepared(law, pairs, (joints_of(driver), joints_of(follower)), pitches, begin)
