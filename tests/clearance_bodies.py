"""Driver and follower with clearance, integrated in time as two bodies by solve_ivp.

Nothing of the package's law is used: the equations are those of Newton and Euler, with the
force of the contact as a third unknown and the distance from the wall as its constraint, or
between elastic walls as a function of how deep the pin is in them.
"""

import math
from itertools import product

import numpy as np
from scipy.integrate import solve_ivp

import escapement as esc
from escapement.engines.contact.rigid.impact import CHATTER


def same_as_two_bodies(timer, engagements, start, rtol=1e-8):
    """The motion of the package, whose handoffs are those of two bodies in time."""
    motion = esc.simulate(timer, engagements, initial_speed=start)
    times, speeds = TwoBodies(timer).run(engagements, start)
    np.testing.assert_allclose(motion.handoff_times, times, rtol=rtol)
    np.testing.assert_allclose(motion.handoff_velocities, speeds, rtol=rtol)
    assert abs(motion.ledger.residual) < 1e-12
    return motion


class TwoBodies:
    """An external or internal wheel in natural units; lengths in crank radii."""

    def __init__(self, timer):
        wheel, clock = timer.mechanism, timer.time_unit
        self.sense = 1.0 if wheel.internal else -1.0
        self.centre, self.exit = wheel.centre_distance, wheel.engagement_angle / 2.0
        self.half_clearance = 0.5 * wheel.clearance / wheel.crank_radius
        self.pin = wheel.pin_radius / wheel.crank_radius
        # the far shafts of trains by the balance of power at their ratios
        barrel, train = timer.barrel or esc.Train(1.0), timer.load_train or esc.Train(1.0)
        far = [barrel.inertia / barrel.ratio**2, train.inertia * train.ratio**2]
        unit, drive = timer.inertia.follower + far[1], timer.torque / barrel.ratio
        self.own = np.array([timer.inertia.driver, timer.inertia.follower]) / unit
        self.far, self.passes = (
            np.array(far) / unit,
            np.array([barrel.efficiency, train.efficiency]),
        )
        self.load = timer.load_torque * train.ratio / drive
        # a load over the follower angle, which is counted from the first slot
        self.curve, self.drive, self.turned = timer.load_curve, drive, 0.0
        self.dwell = wheel.cell_angle - 2.0 * self.exit
        # the torque over the driver angle turned; friction of the driver's bearing has its own sign
        self.rate, self.driver_angle = timer.spring_rate / barrel.ratio**2 / drive, 0.0
        self.bearing = timer.driver_bearing_torque / drive
        # a motor gives no torque at this speed of the driver
        self.no_load = (timer.no_load_speed or np.inf) * barrel.ratio * clock
        self.friction, self.bounce = timer.friction, timer.restitution
        self.step, self.clock = wheel.follower_step, clock

    def directions(self, side, q, v):
        """Generalised directions of the normal force and of friction, D, and the sliding speed."""
        theta, phi = q
        pin = self.centre + self.sense * np.exp(1j * self.sense * theta)
        rate = 1j * np.exp(1j * self.sense * theta)
        if self.sense < 0:
            rate = 1j * np.exp(-1j * theta)
        along, across = np.exp(1j * phi), 1j * np.exp(1j * phi)
        dot = lambda a, b: (a.conjugate() * b).real  # noqa: E731
        touch = side * self.pin
        ahead = dot(across, pin)
        normal = side * np.array([-dot(across, rate), dot(along, pin)])
        # the pin's body turns by `sense` per driver radian; friction acts where it touches
        driver = dot(along, rate) - self.sense * touch
        tangent = np.array([-driver, -(ahead + touch)])
        return normal, tangent, ahead, -tangent @ v

    def accelerations(self, side, q, v, sense=0.0):
        """theta_ddot, phi_ddot and the normal force on a wall; of no wall without force.

        `sense` is the sign of the sliding speed, 0 where it is to be found.
        """
        pull = max(1.0 - self.rate * (self.driver_angle + q[0] + self.exit), 0.0)
        beyond = np.array([pull - v[0] / self.no_load, -self.load * np.sign(v[1])])
        held = self.bearing * np.sign(v[0])
        if side == 0.0 and v[0] == 0.0:
            held = min(self.bearing, pull * self.passes[0])
        swing = float(self.curve(q[1] + self.turned)) / self.drive if self.curve else 0.0
        if side == 0.0 and v[1] == 0.0:
            # friction of the load holds a follower at rest
            swing = np.sign(swing) * max(abs(swing) - self.load, 0.0)
        for shares in product(*((eta, 1.0 / eta) for eta in self.passes)):
            inertia, force = self.own + shares * self.far, np.array(shares) * beyond
            force -= held, swing
            found = self.pushed(side, q, v, sense, inertia, force)
            power = (beyond - self.far * found[0]) * v
            # a train takes its share of the power, whichever way it flows
            if ((np.array(shares) - 1.0) * power <= 1e-14).all():
                return found
        raise AssertionError("no direction of the power fits")

    def pushed(self, side, q, v, sense, inertia, force):
        """As `accelerations`, for given inertias and forces."""
        if side == 0.0:
            return force / inertia, 0.0
        normal, tangent, _ahead, sliding = self.directions(side, q, v)
        way = sense or np.sign(sliding)
        by_force = (normal + self.friction * way * tangent) / inertia
        # the derivative of the normal speed at constant speeds, by a central difference
        h = 1e-6
        ends = [self.directions(side, q + s * h * v, v)[0] @ v for s in (1, -1, 2, -2)]
        bend = (8.0 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12.0 * h)
        push = -(bend + normal @ (force / inertia)) / (normal @ by_force)
        return force / inertia + by_force * push, push

    def piece(self, side, sense, t, q, v):
        """Integrate to the first of the `ends` of a flight, or of a contact that slides one way."""
        ends = [*self.ends(side, sense, v), *self.knots(q)]

        def rates(_t, y):
            return [*y[2:], *self.accelerations(side, y[:2], y[2:], sense)[0]]

        events = [lambda t, y, f=f: f(y[:2], y[2:]) for f in ends]
        for event in events:
            event.terminal, event.direction = True, -1
        settings = {"rtol": 1e-12, "atol": 1e-14, "method": "DOP853", "max_step": 0.05}
        y = np.array([*q, *v])
        # what is zero at the start counts only once it has become positive
        for step in (2e-4, 2e-5, 2e-6, 2e-7):
            short = solve_ivp(rates, (t, t + step), y, **settings).y[:, -1]
            if min(f(short[:2], short[2:]) for f in ends) > 0.0:
                t, y = t + step, short
                break
        found = solve_ivp(rates, (t, t + 20.0), y, events=events, **settings)
        which = int(np.flatnonzero([times.size for times in found.t_events])[0])
        return which, found.t[-1], found.y[:2, -1], found.y[2:, -1]

    def ends(self, side, sense, v):
        """Functions that fall to zero where a flight (`side` 0) or a contact ends."""
        way, turns = np.sign(v[1]), np.sign(v[0])

        def gap(wall):
            return lambda q, v: self.half_clearance - wall * self.directions(wall, q, v)[2]

        out = lambda q, v: self.exit - q[0]  # noqa: E731
        if side == 0.0:
            rests = [lambda q, v: way * v[1]] if way and self.load > 0.0 else []
            halts = [lambda q, v: turns * v[0]] if turns and self.bearing > 0.0 else []
            return [out, gap(1.0), gap(-1.0), *rests, *halts]
        force = lambda q, v: self.accelerations(side, q, v, sense)[1]  # noqa: E731
        return [out, force, lambda q, v: sense * self.directions(side, q, v)[3]]

    def knots(self, q):
        """Functions that fall to zero at the nearest knots of the load."""
        if self.curve is None:
            return []
        phi = q[1] + self.turned
        above = min(self.curve.knots_between(phi + 1e-9, phi + 7.0), default=np.inf) - self.turned
        below = max(self.curve.knots_between(phi - 7.0, phi - 1e-9), default=-np.inf) - self.turned
        return [lambda q, v: above - q[1], lambda q, v: q[1] - below] if above < np.inf else []

    def lock(self, t, q, v):
        """Turn through the dwell, in which the follower is locked, to the next pin."""
        v = np.array([v[0], 0.0])

        def rates(_t, y):
            locked = np.array([y[1], 0.0])
            return [y[1], self.accelerations(0.0, np.array([y[0], q[1]]), locked)[0][0]]

        arrives = lambda t, y: y[0] - self.exit - self.dwell  # noqa: E731
        arrives.terminal, arrives.direction = True, 1
        settings = {"rtol": 1e-12, "atol": 1e-14, "method": "DOP853", "events": arrives}
        found = solve_ivp(rates, (t, t + 50.0), [q[0], v[0]], **settings)
        return found.t[-1], np.array([self.exit, q[1]]), np.array([found.y[1, -1], 0.0])

    def blow(self, side, q, v):
        """Speeds behind an impact: impulse in the direction of the normal, with Coulomb
        friction."""
        normal, tangent, _ahead, _sliding = self.directions(side, q, v)
        total, goal, held = 0.0, np.inf, None
        while True:
            sliding = -tangent @ v
            share = self.friction * np.sign(sliding) if held is None else held
            impulse = normal + share * tangent
            slows = impulse * v < 0.0
            inertia = self.own + np.where(slows, self.passes, 1.0 / self.passes) * self.far
            if held is not None:
                # a body that has come to rest turns the other way, with another inertia
                own = tangent / inertia
                held = -(normal @ own) / (tangent @ own)
                assert abs(held) <= self.friction
                impulse = normal + held * tangent
            change = impulse / inertia
            to_end = goal - total if goal < np.inf else -(normal @ v) / (normal @ change)
            to_stick = np.inf if held is not None else sliding / (tangent @ change)
            to_stick = to_stick if to_stick > 1e-15 else np.inf
            to_rest = np.min(-v[slows] / change[slows], initial=np.inf)
            if to_rest < min(to_stick, to_end):
                rests = slows & (np.abs(v) <= to_rest * np.abs(change))
                v, total = np.where(rests, 0.0, v + change * to_rest), total + to_rest
                continue
            if to_stick < to_end:
                v, total = v + change * to_stick, total + to_stick
                own = tangent / inertia
                hold = -(normal @ own) / (tangent @ own)
                if abs(hold) <= self.friction:
                    held = hold
                else:
                    # it slides on against its former sense; rounding must not decide on that
                    v = v + 1e-15 * np.sign(tangent @ (normal / inertia)) * own
                continue
            v, total = v + change * to_end, total + to_end
            if goal < np.inf:
                return v, True
            if self.bounce * (normal @ change) * total <= CHATTER:
                return v, False
            goal = (1.0 + self.bounce) * total

    def struck(self, side, q, v):
        """The wall that the pin touches behind an impact, the speeds, and the sense of sliding."""
        v, bounces = self.blow(side, q, v)
        sense = np.sign(self.directions(side, q, v)[3])
        flies = bounces or self.accelerations(side, q, v)[1] <= 0.0
        return 0.0 if flies else side, v, sense

    def run(self, engagements, speed=0.0, until=np.inf):
        """Times [s] and driver speeds [rad/s] at handoffs, up to a time."""
        t, v, side = 0.0, np.array([speed * self.clock, 0.0]), 0.0
        pin = self.centre + self.sense * np.exp(-1j * self.sense * self.exit)
        q, found, sense = np.array([-self.exit, np.angle(pin)]), [], 0.0
        while len(found) < engagements and t * self.clock < until:
            count = len(self.ends(side, sense, v))
            which, t, q, v = self.piece(side, sense, t, q, v)
            if which >= count:
                continue  # a knot of the load
            sense = -sense if which == 2 else np.sign(self.directions(side, q, v)[3])
            if which == 0:
                if self.dwell > 1e-9:
                    t, q, v = self.lock(t, q, v)
                self.turned += self.step
                found.append((t * self.clock, v[0] / self.clock))
                q, side = q - np.array([2.0 * self.exit, self.step]), 0.0
                self.driver_angle += 2.0 * self.exit + self.dwell
                # the follower may stand where the next pin is at a wall already
                wall = np.sign(self.directions(1.0, q, v)[2])
                normal, _tangent, ahead, _sliding = self.directions(wall, q, v)
                if wall * ahead > self.half_clearance - 1e-9 and normal @ v < 0.0:
                    side, v, sense = self.struck(wall, q, v)
            elif side == 0.0 and which >= 3:
                # the body that has come to rest
                v[np.abs(v).argmin()] = 0.0
            elif side == 0.0:
                side, v, sense = self.struck(1.0 if which == 1 else -1.0, q, v)
            elif which == 1:
                side = 0.0
        return np.array(found).T


def between_elastic_walls(timer, end):
    """theta, phi and their speeds at a time [s], from rest between elastic walls."""
    scene, joint, clock, wheel = timer.scene, timer.joint, timer.time_unit, timer.mechanism
    sense, load = 1.0 if wheel.internal else -1.0, timer.load_curve or (lambda phi: 0.0)

    def slope(_t, y):
        theta, phi, driver, follower = y
        out, along = np.exp(1j * phi), np.exp(1j * sense * theta)
        arm, moves = sense * along, 1j * along * driver
        pin = wheel.centre_distance + arm
        across = (pin * out.conjugate()).imag
        side = 1.0 if across > 0.0 else -1.0
        normal = 1j * out * side
        depth, width = side * across - joint.half_clearance, scene.pin * normal
        relative = moves + 1j * sense * driver * width - 1j * follower * (pin + width)
        rate, slide = (relative * normal.conjugate()).real, (relative * out.conjugate()).real
        force = max(joint.stiffness * depth + joint.damping * rate, 0.0) if depth > 0.0 else 0.0
        drag = scene.mu_plus * force * slide / math.hypot(slide, joint.slip)
        on = force * normal + drag * out
        turn = ((pin + width).conjugate() * on).imag - float(load(phi)) / timer.torque
        back = -sense * ((arm + width).conjugate() * on).imag
        return [driver, follower, (1.0 + back) / scene.rho, turn]

    theta = float(scene.edges[0])
    start = [theta, float(wheel.follower_angle(np.array([theta]))[0]), 0.0, 0.0]
    settings = {"rtol": 1e-12, "atol": 1e-14, "max_step": 2e-3, "method": "DOP853"}
    found = solve_ivp(slope, (0.0, end / clock), start, **settings)
    return found.y[:, -1] * [1.0, 1.0, 1.0 / clock, 1.0 / clock]
