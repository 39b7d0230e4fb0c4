"""The law of a pin with a width, journals with friction and drag, from Newton and Euler.

Nothing here starts from the law it proves. The symbolic part balances the moments of either body
about its axis and eliminates the contact force. The numerical part compares with `two_bodies`.
"""

import math

import numpy as np
import pytest
import sympy as sp

import escapement as esc
from escapement.dynamics import law as dynamics
from two_bodies import BOTH, Bodies, close, cross, law, random_drive, random_state

# The law in symbols.

time = sp.symbols("t", real=True)
theta = sp.Function("theta")(time)
angle, rate, accel = sp.symbols("theta_now theta_dot theta_ddot", real=True)
ratio, ratio_slope, slip_rate = sp.symbols("g g_prime V", real=True)
size = sp.symbols("N_abs")
carried = sp.symbols("sqrt_of_1_and_mu_squared", positive=True)
distance, centres = sp.symbols("R c", positive=True)  # lengths in crank radii
driver, follower, torque, mu, pin = sp.symbols("I_d I_f tau mu r_p", positive=True)
driver_journal, follower_journal = sp.symbols("mu_bd_r_bd mu_bf_r_bf", positive=True)
constant, load = sp.symbols("T_d M_f", real=True)
c_d, c_f, nu_d, nu_f = sp.symbols("c_d c_f nu_d nu_f", real=True)


def now(expression):
    """An expression of theta(t) in the angle, speed and acceleration of one instant."""
    found = expression.doit().subs(theta.diff(time, 2), accel).subs(theta.diff(time), rate)
    return found.subs(theta, angle)


def reduced(expression, square):
    """Numerator of an expression once R^2 and sin^2 are written in the cosine."""
    sine, cosine = sp.symbols("sine cosine")
    plain = expression.subs({sp.sin(angle): sine, sp.cos(angle): cosine})
    square = square.subs({sp.sin(angle): sine, sp.cos(angle): cosine})
    numerator = sp.expand(sp.numer(sp.together(plain)))
    numerator = sp.rem(numerator, distance**2 - square, distance)
    return sp.rem(sp.expand(numerator), sine**2 + cosine**2 - 1, sine).expand()


@pytest.mark.parametrize(
    ("kind", "side", "slip"), [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
)
def test_balances_of_moments_give_the_law(kind, side, slip):
    """p_s, J_s and X follow from the forces on both bodies, whichever wall and way of sliding.

    `side` is the wall that pushes, and `slip` the sign of the pin's sliding along the slot.
    """
    crank = sp.Matrix([-kind * sp.cos(theta), sp.sin(theta)])
    centre = sp.Matrix([centres, 0]) + crank  # of the pin; the follower turns about the origin
    turning = cross(crank, crank.diff(time))  # of the driver, signed
    assert sp.simplify(now(turning) + kind * rate) == 0
    x, y = centre
    phi = sp.atan2(y, x)
    square = sp.expand_trig(sp.expand(now(x**2 + y**2)))
    out = sp.Matrix([x, y]) / distance
    ahead = sp.Matrix([-y, x]) / distance
    touch = centre + side * pin * ahead

    # velocities of the two material points that touch, per driver radian
    of_pin = centre.diff(time) + turning * sp.Matrix([-(touch - centre)[1], (touch - centre)[0]])
    of_wall = phi.diff(time) * sp.Matrix([-touch[1], touch[0]])
    relative = (of_pin - of_wall) / theta.diff(time)
    assert reduced(now(relative.dot(ahead)), square) == 0

    # force on the follower for each unit of |N|, its opposite on the driver
    force = side * ahead + slip * mu * out
    assert reduced(now(force.dot(force)) - (1 + mu**2), square) == 0
    sense = -kind
    on_driver = sense * now(cross(touch - (centre - crank), -force))
    on_follower = now(cross(touch, force))

    # what this is in g, g', R and V = R', which the second part takes for what they are
    g = now(phi.diff(time) / theta.diff(time))
    assert reduced(now(phi.diff(time, 2)) - g * accel - g.diff(angle) * rate**2, square) == 0
    slide = now((x * x.diff(time) + y * y.diff(time)) / theta.diff(time)) / distance
    places = {ratio: g, slip_rate: slide}
    v = slip_rate + side * pin * (ratio - sense)
    assert reduced(v.subs(places) - now(relative.dot(out)), square) == 0
    lever = side * distance - slip * side * mu * pin
    assert reduced(lever - on_follower, square) == 0
    against = ratio * lever + slip * mu * v
    assert reduced(against.subs(places) + on_driver, square) == 0

    # a bearing holds the axis of a balanced rotor, so it carries the contact's force
    reaction = carried * size  # carried^2 = 1 + mu^2 from above
    phi_dot, phi_ddot = ratio * rate, ratio * accel + ratio_slope * rate**2
    driving = torque - constant - c_d * rate**2 - nu_d * rate
    driving += -against * size - driver_journal * reaction
    pushing = lever * size - load - c_f * phi_dot**2 - nu_f * phi_dot
    pushing -= follower_journal * reaction
    (found,) = sp.solve(
        [driver * accel - driving, follower * phi_ddot - pushing], [accel, size], dict=True
    )
    acceleration, contact = found[accel], side * found[size]

    # what docs/theory.md states
    w = rate**2
    b_d, b_f = (journal * carried for journal in (driver_journal, follower_journal))
    h = distance - slip * mu * pin - side * b_f
    p = ratio + side * (mu * slip * v + b_d + ratio * b_f) / h
    inertia = driver + follower * ratio * p
    resistance = (follower * ratio_slope + c_f * ratio**2) * w + nu_f * ratio * rate + load
    drive = torque - constant - c_d * w - nu_d * rate
    moment = driver * resistance + follower * ratio * drive
    for difference in (
        acceleration * inertia - (drive - p * resistance),
        contact * h * inertia - moment,
    ):
        assert sp.expand(sp.numer(sp.together(difference))) == 0


@pytest.mark.parametrize("roller", [False, True], ids=["pin", "roller"])
@pytest.mark.parametrize("internal", [False, True], ids=["external", "internal"])
def test_two_bodies_with_all_reactions_move_by_the_law(internal, roller):
    rng = np.random.default_rng([1973, internal, roller])
    sides = set()
    for _ in range(12):
        drive = random_drive(rng, roller, internal)
        for _ in range(5):
            theta, speed = random_state(rng, drive)
            expected = Bodies(drive, theta, speed).motion()
            side = expected["side"]
            acceleration, force, lost, moment = law(drive, theta, speed, side)
            assert np.sign(moment) == side
            # either is a difference of torques that may all but cancel
            torques = drive.torque + drive.inertia.follower * speed**2
            close(acceleration, expected["theta_ddot"], torques / drive.inertia.driver)
            close(force, expected["contact_force"], torques / drive.mechanism.crank_radius)
            for name, value in lost.items():
                close(value, expected[name], torques * speed)
            sides.add(side)
    assert sides == set(BOTH)


@pytest.mark.parametrize("roller", [False, True], ids=["pin", "roller"])
@pytest.mark.parametrize("internal", [False, True], ids=["external", "internal"])
def test_a_simulated_motion_is_that_of_two_bodies(internal, roller):
    rng = np.random.default_rng([1974, internal, roller])
    for _ in range(2):
        drive = random_drive(rng, roller, internal)
        motion = esc.simulate(drive, engagements=2)
        ends = np.append(motion.trajectory.start, motion.end_time)
        names = [*dynamics.LOSSES[:5], "phi_dot", "phi_ddot", "theta_ddot", "contact_force"]
        names += ["driver_bearing_reaction", "follower_bearing_reaction"]
        for piece in np.flatnonzero(motion.trajectory.sign):
            times = ends[piece] + (ends[piece + 1] - ends[piece]) * np.array([0.1, 0.4, 0.8])
            state = motion.within(int(piece), times)
            turned_by = motion.trajectory.engagement[piece] * drive.mechanism.cell_angle
            bodies = [
                Bodies(drive, angle - turned_by, speed).motion()
                for angle, speed in zip(state.theta, state.theta_dot, strict=True)
            ]
            assert {b["side"] for b in bodies} == {motion.trajectory.sign[piece]}
            for name in names:
                lost = state.power_lost
                found = lost[name] if name in lost else getattr(state, name)
                expected = np.array([b[name] for b in bodies])
                close(found, expected, np.abs(expected).max())


# The roller by itself.


def test_a_massless_roller_acts_as_a_pin_with_less_friction():
    """Balance of moments about the roller's centre: the force passes it at r_i sin(psi)."""
    mu_i, r_i, r_r, normal = sp.symbols("mu_i r_i r_r N_i", positive=True)
    friction = mu_i * normal
    total = sp.sqrt(normal**2 + friction**2)  # the two forces of the pin on the roller
    traction = friction * r_i / r_r  # of the wall, from the moments about the centre
    pressure = sp.sqrt(total**2 - traction**2)  # the wall's force is the pin's
    share = sp.simplify(traction / pressure)
    assert not share.has(normal)
    q = r_i / r_r * mu_i / sp.sqrt(1 + mu_i**2)
    effective = q / sp.sqrt(1 - q**2)
    assert sp.simplify(share**2 - effective**2) == 0
    claimed = sp.lambdify((mu_i, r_i, r_r), share)
    for values in ((0.3, 0.05, 0.08), (0.9, 0.02, 0.021), (0.05, 0.01, 0.1)):
        wheel = esc.Geneva(4, crank_radius=1.0, pin_radius=values[1], roller_radius=values[2])
        scene = esc.Escapement(wheel, esc.Inertia(1.0, 1.0), 1.0, values[0]).scene
        assert scene.mu_plus == scene.mu_minus == pytest.approx(claimed(*values), rel=1e-14)
        assert scene.pin == values[2]


def test_bearings_carry_the_contact_force_with_its_friction():
    """Only of balanced rotors under pure torques: that is why a journal's loss grows with N."""
    rng = np.random.default_rng(1976)
    for _ in range(10):
        drive = random_drive(rng)
        found = Bodies(drive, *random_state(rng, drive)).motion()
        expected = abs(found["contact_force"]) * math.hypot(1.0, drive.friction)
        close(found["driver_bearing_reaction"], expected)
        close(found["follower_bearing_reaction"], expected)
