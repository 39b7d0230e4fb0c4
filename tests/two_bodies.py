"""Both bodies of a Geneva wheel in the plane, with all reactions as unknowns.

Positions and velocities of material points take the place of a transmission function. A cross
product here is the component along the axes.
"""

import math

import numpy as np

import escapement as esc
from escapement.dynamics import law as dynamics
from escapement.dynamics import state_table
from escapement.dynamics.painleve import friction_limits

BOTH = (1.0, -1.0)


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


def along(angle):
    return np.array([math.cos(angle), math.sin(angle)])


def turned(vector):
    """A vector turned by a right angle: the velocity of its tip at the rate 1."""
    return np.array([-vector[1], vector[0]])


def solution(residual, start):
    """Root of a system by Newton's method, with derivatives by complex steps; None if none."""
    z = np.array(start, dtype=float)
    for _ in range(60):
        columns = [residual(z + 1e-200j * row).imag / 1e-200 for row in np.eye(z.size)]
        matrix, value = np.array(columns).T, residual(z + 0j).real
        unit = 1.0 / np.abs(matrix).max(axis=0)
        matrix = matrix * unit
        scale = np.abs(matrix).max(axis=1)
        step = unit * np.linalg.solve(matrix / scale[:, None], value / scale)
        z -= step
        if (np.abs(step) <= 1e-14 * np.abs(z).max() * unit / unit.max()).all():
            return z
        if not np.isfinite(z).all():
            break
    return z if (np.abs(step) <= 1e-12 * (np.abs(z) + 1e-300)).all() else None


def length(vector):
    """Length of a real vector, or its continuation where a component is complex."""
    return np.sqrt(vector[0] ** 2 + vector[1] ** 2)


class Bodies:
    """Driver, follower and, if there is one, roller of a Geneva wheel at one instant, in SI.

    The follower's axis is the origin, the driver's lies on the x-axis.
    """

    def __init__(self, drive, theta, speed):
        wheel = drive.mechanism
        self.drive, self.speed = drive, speed
        sense = 1.0 if wheel.internal else -1.0
        start = 0.0 if wheel.internal else math.pi
        axis = np.array([wheel.crank_radius / math.sin(math.pi / wheel.slots), 0.0])
        self.sense, self.turning = sense, sense * speed
        self.crank = wheel.crank_radius * along(start + sense * theta)
        self.centre = axis + self.crank
        self.velocity = self.turning * turned(self.crank)
        self.distance = length(self.centre)
        self.out = self.centre / self.distance
        self.ahead = turned(self.out)
        self.phi_dot = self.velocity @ self.ahead / self.distance
        self.radius = wheel.roller_radius or wheel.pin_radius

    def accelerations_agree(self, driver, follower):
        """The pin's centre stays on the line of the slot: its acceleration across is zero."""
        slot_rate = -self.phi_dot * self.out
        slot_bend = -follower * self.out - self.phi_dot**2 * self.ahead
        moved = driver * turned(self.crank) - self.turning**2 * self.crank
        return self.ahead @ moved + 2.0 * slot_rate @ self.velocity + slot_bend @ self.centre

    def rotors(self, z, on_driver, at_driver, on_follower, at_follower):
        """Balances of both rotors, whose unknowns are z[:2] and z[3:7], and the slot's."""
        drive, bearings = self.drive, (z[3:5], z[5:7])
        friction = [
            getattr(drive, f"{body}_bearing_friction")
            * getattr(drive, f"{body}_bearing_radius")
            * length(reaction)
            for body, reaction in zip(("driver", "follower"), bearings, strict=True)
        ]
        held = drive.driver_bearing_torque + friction[0]
        held += drive.driver_drag * self.speed**2 + drive.driver_viscous * self.speed
        back = drive.load_torque + friction[1] * np.sign(self.phi_dot)
        back += drive.follower_drag * self.phi_dot**2 + drive.follower_viscous * self.phi_dot
        driving = self.sense * (drive.torque - held) + cross(at_driver, on_driver)
        return [
            *(bearings[0] + on_driver),
            *(bearings[1] + on_follower),
            driving - drive.inertia.driver * z[0],
            cross(at_follower, on_follower) - back - drive.inertia.follower * z[1],
            self.accelerations_agree(z[0], z[1]),
        ]

    def with_pin(self, side):
        """Unknowns and sliding speed while the pin slides on the wall of that side."""
        arm = side * self.radius * self.ahead
        touch = self.centre + arm
        of_pin = self.velocity + self.turning * turned(arm)
        relative = of_pin - self.phi_dot * turned(touch)
        assert abs(relative @ self.ahead) <= 1e-12 * length(relative) + 1e-14 * length(of_pin)
        sliding = relative @ self.out
        friction = self.drive.friction * np.sign(sliding) * side

        def force(n):
            return n * (self.ahead + friction * self.out)

        def residual(z):
            on = force(z[2])
            return np.array(self.rotors(z, -on, self.crank + arm, on, touch))

        guess = side * self.drive.torque / self.distance
        start = [0.0, 0.0, guess, *force(guess), *-force(guess)]
        found = solution(residual, start)
        lost = 0.0 if found is None else abs(friction * found[2] * sliding)
        return found, lost

    def with_roller(self, side):
        """Unknowns and power lost while a massless roller rolls on the wall of that side.

        Three more unknowns: the force along the wall, and the normal force between pin and
        roller with its direction.
        """
        wheel, drive = self.drive.mechanism, self.drive
        arm = side * self.radius * self.ahead
        touch = self.centre + arm
        # the roller's point at the wall has the wall's velocity
        wall = self.phi_dot * turned(touch)
        spin = (wall - self.velocity) @ self.out / (turned(arm) @ self.out)
        assert length(self.velocity + spin * turned(arm) - wall) <= 1e-12 * length(wall)
        slip = self.turning - spin
        inner, friction = wheel.pin_radius, drive.friction * np.sign(slip)

        def on_roller(z):
            """Place from the roller's centre and force of the pin, from N_i and direction."""
            normal = np.array([np.cos(z[1]), np.sin(z[1])])
            return inner * normal, z[0] * (normal + friction * turned(normal))

        def roller(z, on_wall):
            at, force = on_roller(z)
            return [*(force - on_wall), cross(at, force) - cross(arm, on_wall)]

        def residual(z):
            on_wall = z[2] * self.ahead + z[7] * self.out
            at, force = on_roller(z[8:])
            rotors = self.rotors(z, -force, self.crank + at, on_wall, touch)
            return np.array([*rotors, *roller(z[8:], on_wall)])

        # all forces keep their directions, so the roller alone finds where they point to
        facing = math.atan2(side * self.ahead[1], side * self.ahead[0])
        alone = solution(
            lambda z: np.array(roller(z[1:], side * self.ahead + z[0] * self.out)),
            [0.0, 1.0, facing],
        )
        guess = drive.torque / self.distance
        push = guess * (side * self.ahead + alone[0] * self.out)
        tail = guess * alone[0], guess * alone[1], alone[2]
        found = solution(residual, [0.0, 0.0, side * guess, *push, *-push, *tail])
        if found is None or found[8] < 0.0:
            return None, 0.0
        return found, abs(drive.friction * found[8] * inner * slip)

    def motion(self):
        """What the bodies do: on exactly one wall the force that it needs is a push."""
        solve = self.with_roller if self.drive.mechanism.roller_radius else self.with_pin
        candidates = {side: solve(side) for side in BOTH}
        good = {s: z for s, z in candidates.items() if z[0] is not None and s * z[0][2] > 0.0}
        assert len(good) == 1
        ((side, (z, lost)),) = good.items()
        speed, phi_dot, drive = self.speed, self.phi_dot, self.drive
        reactions = length(z[3:5]), length(z[5:7])
        journals = [
            getattr(drive, f"{body}_bearing_friction")
            * getattr(drive, f"{body}_bearing_radius")
            * reaction
            for body, reaction in zip(("driver", "follower"), reactions, strict=True)
        ]
        return {
            "side": side,
            "theta_ddot": self.sense * z[0],
            "phi_dot": phi_dot,
            "phi_ddot": z[1],
            "contact_force": z[2],
            "driver_bearing_reaction": reactions[0],
            "follower_bearing_reaction": reactions[1],
            "friction": lost,
            "driver_bearing": (journals[0] + drive.driver_bearing_torque) * speed,
            "follower_bearing": journals[1] * phi_dot,
            "driver_drag": drive.driver_drag * speed**3 + drive.driver_viscous * speed**2,
            "follower_drag": drive.follower_drag * phi_dot**3 + drive.follower_viscous * phi_dot**2,
        }


def random_drive(rng, roller=False, internal=None, mechanism=None):
    """An escapement below both limits of friction, with every loss, in SI."""
    inside = rng.random() < 0.5 if internal is None else internal
    crank = 10.0 ** rng.uniform(-3, 0)
    torque, own = 10.0 ** rng.uniform(-3, 1), 10.0 ** rng.uniform(-6, -1)
    if mechanism is None:
        pin = rng.uniform(0.02, 0.12) * crank  # neighbouring slots of three meet at 0.134
        outer, pin = (pin, rng.uniform(0.4, 0.9) * pin) if roller else (0.0, pin)
        slots = int(rng.integers(3, 9))
        mechanism = esc.Geneva(slots, 1, inside, crank, pin_radius=pin, roller_radius=outer)
    crank = mechanism.crank_radius
    clock = math.sqrt(own / torque)
    share = rng.uniform(0.0, 0.3, 7)
    rest = {
        "load_torque": share[0] * torque,
        "driver_bearing_torque": share[1] * torque,
        "driver_drag": share[2] * own,
        "follower_drag": share[3] * own,
        "driver_viscous": share[4] * own / clock,
        "follower_viscous": share[5] * own / clock,
        "follower_bearing_friction": rng.uniform(0.05, 0.2),
        "follower_bearing_radius": rng.uniform(0.02, 0.1) * crank,
    }
    if mechanism.plain_crank:
        rest["driver_bearing_friction"] = rng.uniform(0.05, 0.2)
        rest["driver_bearing_radius"] = rng.uniform(0.02, 0.1) * crank
    inertia = esc.Inertia(own * 10.0 ** rng.uniform(-1, 1), own)
    drive = esc.Escapement(mechanism, inertia, torque, 0.0, **rest)
    # a roller brings the friction in the slot far down, so that its limit is none
    limit = min(*friction_limits(drive), 0.8)
    return esc.Escapement(mechanism, inertia, torque, rng.uniform(0.2, 0.95) * limit, **rest)


def random_state(rng, drive):
    """An angle within the engagement, and a speed at which every torque counts."""
    low, high = drive.mechanism.breaks[0], drive.mechanism.breaks[-1]
    theta = low + (high - low) * rng.uniform(0.03, 0.97)
    return theta, 10.0 ** rng.uniform(-1, 1) / drive.time_unit


def law(drive, theta, speed, side, engagement=0):
    """The package's rows at one state, in SI but for X: acceleration, N, losses, and X."""
    w = np.array([(speed * drive.time_unit) ** 2])
    table = np.empty((state_table.ROWS, 1))
    place = drive.scenes[engagement], np.array([theta]), *np.zeros((2, 1)), w, side
    state_table.tabulate(*place, table)
    found = state_table.LawTable(*table[:, 0])
    own = dynamics.LOSSES[:5]  # there are no trains
    lost = {name: drive.torque * speed * getattr(found, name) for name in own}
    force = found.force * drive.torque / drive.mechanism.crank_radius
    return found.rate / drive.time_unit**2, force, lost, found.pressing


def close(found, expected, scale=0.0, rtol=1e-10):
    np.testing.assert_allclose(found, expected, rtol=rtol, atol=rtol * scale)
