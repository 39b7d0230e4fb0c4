"""The law of a gear-driven wheel whose pins have a width, by virtual power.

The planet rolls without slip, and the law follows from the power that is lost where it touches the
wheel. Nothing here starts from the law it proves.
"""

import math

import mpmath as mp
import numpy as np
import pytest

import escapement as esc
from two_bodies import BOTH, close, law, random_drive, random_state


class Planet:
    """Geometry of a gear-driven wheel: a planet that rolls in or on a fixed gear about the origin.

    All positions are complex numbers over the carrier's angle, in SI.
    """

    def __init__(self, wheel):
        fixed, k = wheel.fixed_radius, float(wheel.gear_ratio)
        self.planet = fixed / k  # negative for a planet outside the fixed gear
        self.carrier, self.arm = fixed - self.planet, wheel.arms.second * fixed
        self.fixed = fixed

    def middle(self, theta):
        return self.carrier * mp.expj(theta)

    def turn(self, theta):
        """How far the planet has turned: the arcs that the two pitch circles roll off are equal.

        The planet turns by the arc over its radius relative to the carrier, backwards if inside.
        """
        return theta - self.fixed * theta / self.planet

    def pin(self, theta):
        return self.middle(theta) + self.arm * mp.expj(self.turn(theta))

    def on_planet(self, point, theta):
        """Path of the planet's material point that lies at `point` at the angle theta."""
        own = (point - self.middle(theta)) * mp.expj(-self.turn(theta))
        return lambda x: self.middle(x) + own * mp.expj(self.turn(x))

    def on_wheel(self, point, theta):
        """Path of the wheel's material point that lies at `point`: its slot follows the pin."""
        return lambda x: point * mp.expj(self.follower(x, theta))

    def follower(self, x, theta):
        """Angle by which the wheel turns from theta to x, with the carrier positive."""
        return mp.arg(self.pin(x) / self.pin(theta))


def dot(a, b):
    return a.real * b.real + a.imag * b.imag


def outer(a, b):
    return a.real * b.imag - a.imag * b.real


class Touch:
    """Where the planet's pin touches a wall at a carrier angle, per carrier radian."""

    def __init__(self, planet, theta, pin, side):
        self.sense = mp.sign(mp.diff(lambda x: planet.follower(x, 0.0), 0.0))
        centre = planet.pin(theta)
        self.out = centre / abs(centre)
        self.ahead = self.sense * mp.mpc(0, 1) * self.out  # where the wheel turns to
        self.point = centre + side * pin * self.ahead
        relative = mp.diff(planet.on_planet(self.point, theta), theta)
        relative -= mp.diff(planet.on_wheel(self.point, theta), theta)
        assert abs(dot(relative, self.ahead)) < 1e-15 * planet.fixed  # it does not leave the wall
        self.sliding = dot(relative, self.out)

    def moment(self, side, friction):
        """Moment about the wheel's axis, forwards, of a normal force of 1 and its friction."""
        force = side * self.ahead + mp.sign(self.sliding) * friction * self.out
        return self.sense * outer(self.point, force)


def by_power(drive, theta, speed, side):
    """theta_ddot, |N| and |v| of a gear-driven wheel on one wall, from two balances.

    The wheel's balance of moments, and the power of the drive, of which the contact loses the
    friction force times the sliding speed.
    """
    wheel, own = drive.mechanism, drive.inertia
    planet = Planet(wheel)
    touch = Touch(planet, theta, wheel.pin_radius, side)
    g, slope = (
        touch.sense * mp.diff(lambda x: planet.follower(x, theta), theta, n) for n in (1, 2)
    )
    journal = drive.follower_bearing_friction * drive.follower_bearing_radius
    journal *= mp.sqrt(1 + drive.friction**2)
    lever = touch.moment(side, drive.friction) - journal
    phi_dot = g * speed
    resisting = drive.load_torque + drive.follower_drag * phi_dot**2
    resisting += drive.follower_viscous * phi_dot
    driving = drive.torque - drive.driver_bearing_torque
    driving -= drive.driver_drag * speed**2 + drive.driver_viscous * speed
    lost = drive.friction * abs(touch.sliding) + journal * g
    # unknowns theta_ddot and |N|: I_f phi_ddot = |N| lever - resisting, and the power over speed
    matrix = mp.matrix([[own.follower * g, -lever], [own.driver + own.follower * g**2, lost]])
    inertial = own.follower * slope * speed**2
    right = mp.matrix([-resisting - inertial, driving - g * (resisting + inertial)])
    acceleration, force = mp.lu_solve(matrix, right)
    return float(acceleration), float(force), float(abs(touch.sliding))


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
            found = {side: by_power(drive, theta, speed, side) for side in BOTH}
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
