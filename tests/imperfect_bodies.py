"""Both bodies of a Geneva wheel with imperfect parts, integrated in time; each handoff is explicit.

The state is the angle and the speed of either body. Positions of material points and Newton's and
Euler's equations take the place of a transmission function: while a pin is in its slot the normal
force is an unknown beside the two accelerations. The origin is the follower's axis.
"""

import cmath
import math
from typing import NamedTuple

from scipy.integrate import solve_ivp
from scipy.optimize import brentq

TIGHT = {"rtol": 1e-13, "atol": 1e-14, "method": "DOP853"}


def dot(a, b):
    return a.real * b.real + a.imag * b.imag


def cross(a, b):
    return a.real * b.imag - a.imag * b.real


class Pair(NamedTuple):
    """A pin and the slot it meets in one engagement, in SI.

    `zero` and `lean` are what the crank and the slot have turned where driver and follower are
    at angle 0; `offset` is the distance of the slot's line from the axis.
    """

    axis: float
    radius: float
    sense: float
    zero: float
    lean: float
    offset: float

    def asked(self, theta):
        """Follower angle and follower speed per driver speed that the pin asks for."""
        crank = cmath.rect(self.radius, self.zero + self.sense * theta)
        distance, angle = cmath.polar(self.axis + crank)
        angle -= math.asin(self.offset / distance)
        out = cmath.rect(1.0, angle)
        ratio = dot(self.sense * 1j * crank, 1j * out) / dot(self.axis + crank, out)
        return angle - self.lean, ratio


def pair_of(wheel, k):
    """The pin and the slot of engagement k."""
    m, n, r = wheel.pins, wheel.slots, wheel.crank_radius
    sense = 1.0 if wheel.internal else -1.0
    distance = r / math.sin(math.pi / n) + wheel.centre_distance_error

    def part(numbers, i):
        return numbers[i] if numbers else 0.0

    late = part(wheel.pin_angle_errors, k % m) + 2.0 * math.pi * k / m
    zero = (0.0 if wheel.internal else math.pi) - sense * late
    lean = part(wheel.slot_angle_errors, k % n) - 2.0 * math.pi * k / n
    crank = r + part(wheel.crank_radius_errors, k % m)
    offset = part(wheel.slot_offsets, k % n)
    return Pair(distance, crank, sense, zero, lean, offset)


class Ends(NamedTuple):
    """Driver angles where pin A ceases to drive and B begins to, what happens, and the jump."""

    leaves: float
    starts: float
    kind: str
    jump: float


def handoff(wheel, k):
    """The rule by which engagement k hands over to the next one."""
    cell = 2.0 * math.pi / wheel.pins
    return hand_over(pair_of(wheel, k), pair_of(wheel, k + 1), cell * k, cell * (k + 1), math.pi)


def hand_over(a, b, first, second, farthest):
    """The rule for two pairs with these dead centres; a pin is farthest off behind that angle."""
    leaves = brentq(lambda x: a.asked(x)[1], first, first + farthest, xtol=1e-15)
    enters = brentq(lambda x: b.asked(x)[1], second - farthest, second, xtol=1e-15)
    if enters <= leaves + 1e-13:
        both = leaves
        if enters < leaves - 1e-13:
            both = brentq(lambda x: a.asked(x)[1] - b.asked(x)[1], enters, leaves, xtol=1e-15)
        jump = b.asked(both)[0] - a.asked(both)[0]
        if jump >= -1e-13:
            return Ends(both, both, "overlap", jump)
    rest = a.asked(leaves)[0]
    jump = b.asked(max(enters, leaves))[0] - rest
    if jump >= 0.0:
        return Ends(leaves, max(enters, leaves), "pick-up" if enters > leaves else "strike", jump)
    start = max(enters, leaves)
    strikes = brentq(lambda x: b.asked(x)[0] - rest, start, second, xtol=1e-15)
    return Ends(leaves, strikes, "strike", 0.0)


class Contact:
    """What acts between a pin and its slot at one instant; vectors are complex numbers."""

    def __init__(self, drive, pair, side, theta, speed, phi, phi_dot):
        wheel = drive.mechanism
        self.drive, self.pair, self.side = drive, pair, side
        self.speed, self.phi_dot, self.turning = speed, phi_dot, pair.sense * speed
        self.crank = cmath.rect(pair.radius, pair.zero + pair.sense * theta)
        self.centre = pair.axis + self.crank
        self.out = cmath.rect(1.0, phi + pair.lean)
        self.ahead = 1j * self.out
        self.arm = side * (wheel.roller_radius or wheel.pin_radius) * self.ahead
        self.touch = self.centre + self.arm
        of_pin = self.turning * 1j * (self.crank + self.arm)
        self.sliding = dot(of_pin - phi_dot * 1j * self.touch, self.out)

    def moments(self, way):
        """Moments on driver, in its sense, and follower for a unit of force; bearings included."""
        drive = self.drive
        force = self.side * self.ahead + drive.friction * way * self.out
        load = math.hypot(1.0, drive.friction)
        held = drive.driver_bearing_friction * drive.driver_bearing_radius * load
        back = drive.follower_bearing_friction * drive.follower_bearing_radius * load
        on_driver = -self.pair.sense * cross(self.crank + self.arm, force) - held
        return on_driver, cross(self.touch, force) - math.copysign(back, self.phi_dot)

    def across(self):
        """Accelerations of the pin's centre across the slot for those of driver and follower."""
        return dot(self.pair.sense * 1j * self.crank, self.ahead), -dot(self.centre, self.out)

    def accelerations(self, way):
        """Of driver and follower, and the force on the wall."""
        own = self.drive.inertia
        free, back = torques(self.drive, self.speed, self.phi_dot)
        on_driver, on_follower = self.moments(way)
        # the pin's centre stays on the line of the slot: its acceleration across is zero
        of_driver, of_follower = self.across()
        bent = dot(-(self.turning**2) * self.crank, self.ahead)
        bent -= 2.0 * self.phi_dot * dot(self.turning * 1j * self.crank, self.out)
        bent -= self.phi_dot**2 * dot(self.centre, self.ahead)
        bent += of_driver * free / own.driver - of_follower * back / own.follower
        by_force = of_driver * on_driver / own.driver + of_follower * on_follower / own.follower
        force = -bent / by_force
        driver = (free + force * on_driver) / own.driver
        return driver, (force * on_follower - back) / own.follower, force


def torques(drive, speed, phi_dot):
    """Torque that is left of the drive, and what holds the follower, but for the contact."""
    free = drive.torque - drive.driver_bearing_torque
    free -= drive.driver_drag * speed**2 + drive.driver_viscous * speed
    back = drive.load_torque + drive.follower_drag * phi_dot * abs(phi_dot)
    return free, back + drive.follower_viscous * phi_dot


def drive_to(drive, pair, theta, speed, end):
    """Drive from an angle to another with the pin in its slot; returns time and speed there."""
    phi, ratio = pair.asked(theta)
    state, time = [theta, speed, phi, ratio * speed], 0.0

    def contact(y, side):
        return Contact(drive, pair, side, *y)

    def starts_with(side):
        now = contact(state, side)
        return now.accelerations(math.copysign(1.0, now.sliding))[2]

    side = 1.0 if starts_with(1.0) > 0.0 else -1.0
    while True:
        way = math.copysign(1.0, contact(state, side).sliding)
        if fresh := abs(contact(state, side).sliding) < 1e-9 * speed * pair.radius:
            way = math.copysign(1.0, contact(later(drive, pair, state), side).sliding)

        def rates(_t, y, side=side, way=way):
            a, b, _n = contact(y, side).accelerations(way)
            return [y[1], a, y[3], b]

        def arrives(_t, y):
            return y[0] - end

        def lets_go(t, y, side=side, way=way):
            return contact(y, side).accelerations(way)[2] if t > 0.0 else 1.0

        def turns(t, y, side=side, way=way, fresh=fresh):
            return contact(y, side).sliding * way if t > 0.0 or not fresh else 1.0

        for event, direction in ((arrives, 1.0), (lets_go, -1.0), (turns, -1.0)):
            event.terminal, event.direction = True, direction
        span, events = (0.0, 10.0 * drive.time_unit), (arrives, lets_go, turns)
        limit = 0.05 * drive.time_unit
        found = solve_ivp(rates, span, state, events=events, max_step=limit, **TIGHT)
        state, time = found.y[:, -1], time + found.t[-1]
        if found.t_events[0].size:
            asked, ratio = pair.asked(end)
            assert abs(state[2] - asked) < 1e-10
            assert abs(state[3] - ratio * state[1]) < 1e-9 * state[1]
            return time, state[1]
        if found.t_events[1].size:
            side = -side


def later(drive, pair, state):
    """The state a moment later, to see which way the contact point slides from here on."""
    step = 1e-6 * drive.time_unit
    theta = state[0] + step * state[1]
    phi, ratio = pair.asked(theta)
    return [theta, state[1], phi, ratio * state[1]]


def turn_free(drive, speed, way):
    """Turn the driver alone by an angle; returns time and speed there."""
    if way <= 0.0:
        return 0.0, speed

    def rates(_t, y):
        return [y[1], torques(drive, y[1], 0.0)[0] / drive.inertia.driver]

    def arrives(_t, y):
        return y[0] - way

    arrives.terminal = True
    found = solve_ivp(rates, (0.0, 1e3 * drive.time_unit), [0.0, speed], events=arrives, **TIGHT)
    return found.t[-1], found.y[1, -1]


class Blow(NamedTuple):
    """Speeds of driver and follower behind a plastic impact, and its angular impulse on either."""

    speed: float
    phi_dot: float
    on_driver: float
    on_follower: float


def strike(drive, pair, theta, speed):
    """The impact of a pin on the front wall of a slot that stands still."""
    phi, ratio = pair.asked(theta)
    # friction acts against the sliding that the walls have in lasting contact
    now = Contact(drive, pair, 1.0, theta, speed, phi, ratio * speed)
    on_driver, on_follower = now.moments(math.copysign(1.0, now.sliding))
    own, (of_driver, of_follower) = drive.inertia, now.across()
    # impulse after which pin and wall have the same speed across the slot
    gained = of_driver * on_driver / own.driver + of_follower * on_follower / own.follower
    impulse = -of_driver * speed / gained
    return Blow(
        speed + impulse * on_driver / own.driver,
        impulse * on_follower / own.follower,
        impulse * on_driver,
        impulse * on_follower,
    )


class Handed(NamedTuple):
    """A handoff: time, driver speeds before and behind it, its ends and its impact."""

    time: float
    before: float
    speed: float
    ends: Ends
    blow: Blow | None


def run(drive, speed, engagements):
    """The handoffs of a motion that begins behind the one to pin 0."""
    wheel, time, found = drive.mechanism, 0.0, []
    start = handoff(wheel, -1).starts
    for k in range(engagements):
        ends = handoff(wheel, k)
        passed, speed = drive_to(drive, pair_of(wheel, k), start, speed, ends.leaves)
        waited, before = turn_free(drive, speed, ends.starts - ends.leaves)
        time += passed + waited
        blow, speed, start = None, before, ends.starts
        if ends.kind == "strike":
            blow = strike(drive, pair_of(wheel, k + 1), start, speed)
            speed = blow.speed
        found.append(Handed(time, before, speed, ends, blow))
    return found
