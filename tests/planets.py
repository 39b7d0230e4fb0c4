"""Geometry and law of a gear-driven wheel, by complex numbers and virtual power.

The planet rolls without slip, and the law follows from the power that is lost where it touches the
wheel. Nothing here starts from the law it proves.
"""

import mpmath as mp


class Planet:
    """Geometry of a gear-driven wheel: a planet that rolls in or on a fixed gear about the origin.

    All positions are complex numbers over the carrier's angle, in SI. A pin is at dead centre at
    the angle `dead`. The slot's line passes the wheel's axis at the distance `offset`.
    """

    def __init__(self, wheel, dead=0.0, offset=0.0):
        fixed, k = wheel.fixed_radius, float(wheel.gear_ratio)
        self.planet = fixed / k  # negative for a planet outside the fixed gear
        self.carrier, self.arm = fixed - self.planet, wheel.arms.second * fixed
        self.fixed, self.dead, self.offset = fixed, dead, offset
        self.sense = mp.sign(mp.diff(lambda x: mp.arg(self.pin(x) / self.pin(dead)), dead))
        self.carrier += mp.sign(self.carrier) * wheel.centre_distance_error

    def middle(self, theta):
        return self.carrier * mp.expj(theta)

    def turn(self, theta):
        """How far the planet has turned: the arcs that the two pitch circles roll off are equal.

        The planet turns by the arc over its radius relative to the carrier, backwards if inside.
        """
        return theta - self.fixed * theta / self.planet

    def pin(self, theta):
        turned = self.turn(theta) - self.turn(self.dead)
        return self.middle(theta) + self.arm * mp.expj(self.dead + turned)

    def slot(self, theta):
        """Direction outwards of the slot's line, and how far along it the pin is."""
        place = self.pin(theta)
        far = mp.sqrt(abs(place) ** 2 - self.offset**2)
        return place / mp.mpc(far, self.sense * self.offset), far

    def on_planet(self, point, theta):
        """Path of the planet's material point that lies at `point` at the angle theta."""
        own = (point - self.middle(theta)) * mp.expj(-self.turn(theta))
        return lambda x: self.middle(x) + own * mp.expj(self.turn(x))

    def on_wheel(self, point, theta):
        """Path of the wheel's material point that lies at `point`: its slot follows the pin."""
        return lambda x: point * mp.expj(self.follower(x, theta))

    def follower(self, x, theta):
        """Angle by which the wheel turns from theta to x, with the carrier positive."""
        return mp.arg(self.slot(x)[0] / self.slot(theta)[0])

    def ratio(self, theta, order=1):
        """Derivative of the wheel's angle, as it turns, by the carrier's."""
        return self.sense * mp.diff(lambda x: self.follower(x, theta), theta, order)

    def slide(self, theta):
        """Speed of the pin along the slot's line per carrier radian."""
        return mp.diff(lambda x: self.slot(x)[1], theta)


def dot(a, b):
    return a.real * b.real + a.imag * b.imag


def outer(a, b):
    return a.real * b.imag - a.imag * b.real


class Touch:
    """Where the planet's pin touches a wall at a carrier angle, per carrier radian."""

    def __init__(self, planet, theta, pin, side):
        self.sense, centre = planet.sense, planet.pin(theta)
        self.out = planet.slot(theta)[0]
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

    def losses(self, drive, g, side):
        """For a normal force of 1: moment left to the wheel, and power lost per carrier speed."""
        journal = drive.follower_bearing_friction * drive.follower_bearing_radius
        journal *= mp.sqrt(1 + drive.friction**2) * mp.sign(g)
        lever = self.moment(side, drive.friction) - journal
        return lever, drive.friction * abs(self.sliding) + journal * g


def by_power(drive, planet, theta, speed, side):
    """theta_ddot, |N| and |v| of a gear-driven wheel on one wall, from two balances.

    The wheel's balance of moments, and the power of the drive, of which the contact loses the
    friction force times the sliding speed.
    """
    wheel, own = drive.mechanism, drive.inertia
    touch = Touch(planet, theta, wheel.pin_radius, side)
    g, slope = planet.ratio(theta), planet.ratio(theta, 2)
    lever, lost = touch.losses(drive, g, side)
    phi_dot = g * speed
    resisting = drive.load_torque + drive.follower_drag * phi_dot**2
    resisting += drive.follower_viscous * phi_dot
    driving = drive.torque - drive.driver_bearing_torque
    driving -= drive.driver_drag * speed**2 + drive.driver_viscous * speed
    # unknowns theta_ddot and |N|: I_f phi_ddot = |N| lever - resisting, and the power over speed
    matrix = mp.matrix([[own.follower * g, -lever], [own.driver + own.follower * g**2, lost]])
    inertial = own.follower * slope * speed**2
    right = mp.matrix([-resisting - inertial, driving - g * (resisting + inertial)])
    acceleration, force = mp.lu_solve(matrix, right)
    return float(acceleration), float(force), float(abs(touch.sliding))
