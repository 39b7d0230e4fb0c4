"""An escapement of two bodies as the kernels take it."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from escapement.engines.two_bodies.law import SHARED, Law
from escapement.engines.two_bodies.pairs import joints_of, pairs_of
from escapement.model.escapement import Escapement, once_per_escapement


class Prepared(NamedTuple):
    """What `march.march` takes: the law, the pairs of features, which of them meet, and the pitches
    of both bodies; and the angles at the start.
    """

    law: Law
    pairs: np.ndarray
    joints: Any
    pitches: tuple[float, float]
    start: tuple[float, float]


@once_per_escapement
def prepared(escapement: Escapement) -> Prepared:
    """The escapement in natural units, kept on it so that its next call has it at once."""
    machine: Any = escapement.mechanism
    scene, unit = escapement.scene, escapement.torque_unit
    theta, phi = (float(angle) for angle in machine.start)
    theta %= machine.pitch  # the driver looks the same
    spring, weight = escapement.follower_spring / unit, escapement.follower_gravity / unit
    changing = spring, weight, scene.torque.size - 3, scene.driver_drag, scene.follower_drag
    plain = not any((*changing, scene.driver_viscous, scene.follower_viscous))
    shared = (getattr(scene, name) for name in SHARED)
    place, swing = (float(machine.axes_distance), theta), (spring, weight)
    rest, restitution = escapement.follower_rest_angle, escapement.restitution
    law = Law._make((*shared, *place, *swing, rest, restitution, plain))
    return Prepared(law, *_touching(machine), (theta, phi))


@lru_cache
def _touching(machine: Any) -> tuple[np.ndarray, Any, tuple[float, float]]:
    """Pairs, joints and pitches, which the cases of a study have in common."""
    driver, follower = machine.driver_features, machine.follower_features
    pitches = 2.0 * np.pi / driver.fold, 2.0 * np.pi / follower.fold
    return pairs_of(driver, follower), (joints_of(driver), joints_of(follower)), pitches
