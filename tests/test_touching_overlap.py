"""Bodies of a motion never overlap: the exact distance of lines and arcs knows no engine."""

import cmath
import math

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.outlines.gaps import gap, segments_of
from escapement.outlines.touching import edges_of

pytestmark = pytest.mark.slow
DEEPEST = 1e-9  # of the wheel's radius
GEOMETRIES, PITCHES, INSTANTS = 10, 5, 200


def random_runaways(seed, count):
    """Runaway escapements around two good ones, those that are possible."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        near = rng.uniform(0.97, 1.03, 8)
        if len(found) % 2:
            numbers = {
                **{"teeth": 20, "tooth_depth": 0.2 * near[0], "lead": math.radians(-5.0 * near[1])},
                **{"back": math.radians(30.0 * near[2]), "tip_radius": 0.01, "pallets": "flat"},
                **{"span": 3.5, "pallet_radius": 0.95 * (1.0 + 0.1 * (near[3] - 1.0))},
                **{"pallet_angle": math.radians(45.0 * near[4]), "pallet_length": 0.2},
                **{"pallet_thickness": 0.08 * near[5], "corner_radius": 0.01},
            }
        else:
            numbers = {
                **{
                    "teeth": 12,
                    "tooth_depth": 0.22 * near[0],
                    "lead": math.radians(45.0 * near[1]),
                },
                **{"back": math.radians(15.0 * near[2]), "tip_radius": 0.01, "pallets": "pins"},
                **{"span": 2.5, "pallet_radius": 1.02 * (1.0 + 0.1 * (near[3] - 1.0))},
                "pin_radius": 0.05 * near[4],
            }
        try:
            found.append(esc.Runaway(wheel_radius=1.0, **numbers))
        except InvalidValue:
            continue
    return found


def deepest(mechanism, theta, phi):
    """By how much the bodies are apart at their angles; negative where they overlap."""
    wheel = edges_of(mechanism.driver_chains, mechanism.driver_fold)
    turned = segments_of([edge.moved(cmath.exp(1j * theta)) for edge in wheel])
    pallets = edges_of(mechanism.follower_chains, mechanism.follower_fold)
    turn, axis = cmath.exp(1j * phi), mechanism.axes_distance
    return min(gap(segments_of([edge.moved(turn, axis)]), turned)[0] for edge in pallets)


@pytest.mark.parametrize("seed", range(2))
def test_no_bodies_of_a_motion_overlap(seed):
    for verge in random_runaways(seed, GEOMETRIES // 2):
        timer = esc.Escapement(verge, esc.Inertia(1.0, 0.2), 1.0, friction=0.15)
        motion = esc.simulate(timer, engagements=PITCHES)
        state = motion.at(np.linspace(0.0, motion.end_time, INSTANTS))
        apart = [
            deepest(verge, theta, phi)
            for theta, phi in zip(state.theta.tolist(), state.phi.tolist(), strict=True)
        ]
        assert min(apart) > -DEEPEST
        assert min(apart) < 1e-6  # and they do touch
