"""The law of a gear-driven wheel whose pins have a width, by virtual power.

`planets` has the explicit geometry and the balances that it follows from.
"""

import math

import mpmath as mp
import numpy as np
import pytest

import escapement as esc
from planets import Planet, Touch, by_power
from two_bodies import BOTH, close, law, random_drive, random_state

CURVES = [
    ("hypocycloid", 7, 1, 1),
    ("hypocycloid", 9, 2, 1),
    ("epicycloid", 6, 1, 1),
    ("epicycloid", 5, 2, 1),
    ("contracted-hypocycloid", 7, 1, 1),
    ("pericycloid", 6, 1, 1),
]


@pytest.fixture
def thirty_digits():
    with mp.workdps(30):
        yield


@pytest.mark.usefixtures("thirty_digits")
@pytest.mark.parametrize(("curve", "stations", "lobes", "pins"), CURVES)
def test_a_planet_rolls_and_its_pin_loses_where_it_slides(curve, stations, lobes, pins):
    rng = np.random.default_rng([1974, stations, lobes, len(curve)])
    fixed = 0.07
    wheel = esc.GearDriven(stations, lobes, curve, pins, fixed_radius=fixed)
    closest = fixed * wheel.closest_radius_over_fixed
    pin = 0.3 * closest * math.sin(math.pi / wheel.slots)
    wheel = esc.GearDriven(stations, lobes, curve, pins, fixed_radius=fixed, pin_radius=pin)
    planet = Planet(wheel)
    assert planet.carrier == pytest.approx(wheel.arms.first * fixed, rel=1e-14)
    # without slip: the planet's point on both pitch circles stands still
    pitch = planet.on_planet(fixed * mp.expj(0.3), 0.3)
    assert abs(mp.diff(pitch, 0.3)) < 1e-15
    # counted as the wheel turns, by -(1 - k) where wheel and carrier turn against each other
    sense = Touch(planet, 0.1, pin, 1).sense
    turning = sense * mp.diff(planet.turn, 0.1)
    assert wheel.path.numbers[9] == pytest.approx(float(turning), rel=1e-14)
    sides = set()
    for _ in range(3):
        drive = random_drive(rng, mechanism=wheel)
        for _ in range(4):
            theta, speed = random_state(rng, drive)
            found = {side: by_power(drive, planet, theta, speed, side) for side in BOTH}
            good = [side for side in BOTH if found[side][1] > 0.0]
            assert len(good) == 1
            acceleration, force, sliding = found[good[0]]
            computed = law(drive, theta, speed, good[0])
            torques = drive.torque + drive.inertia.follower * speed**2
            close(computed[0], acceleration, torques / drive.inertia.driver)
            close(computed[1], good[0] * force, torques / fixed)
            friction = drive.friction
            close(computed[2]["friction"] / abs(computed[1]), friction * sliding * speed)
            sides.add(good[0])
    assert sides
