"""Walls that yield: examples, limits, energy, independent solutions, and refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import escapement as esc
from clearance_bodies import between_elastic_walls
from escapement.base.status import Status

RADIUS, TORQUE, DRIVER, FOLLOWER = 0.01, 0.1, 3e-6, 50e-6
CLOCK, UNIT = math.sqrt(FOLLOWER / TORQUE), TORQUE / RADIUS**2


def timer(friction=0.3, play=0.0, stiffness=1e6, share=1.0, **other):
    """Meyer's four slots in natural units; `share` of sqrt(k I_f)/r is the damping."""
    names = ("slots", "internal", "pin_radius")
    wheel = {"slots": 4, **{name: other.pop(name) for name in names if name in other}}
    given = {"damping": share * math.sqrt(stiffness) * UNIT * CLOCK, "friction": friction}
    given["slip_speed"] = 1e-4 * RADIUS / CLOCK
    return esc.Escapement(
        esc.Geneva(crank_radius=RADIUS, clearance=2.0 * play * RADIUS, **wheel),
        esc.Inertia(DRIVER, FOLLOWER),
        torque=TORQUE,
        stiffness=stiffness * UNIT,
        **(given | other),
    )


def rigid(**other):
    """The same with rigid bodies."""
    own = timer(**other)
    wheel = esc.Geneva(own.mechanism.slots, crank_radius=RADIUS, clearance=own.mechanism.clearance)
    return esc.Escapement(wheel, own.inertia, torque=TORQUE, friction=own.friction)


@pytest.mark.parametrize(
    ("play", "share", "stiffness", "period", "most", "least", "handoff"),
    [
        (5e-4, 1.0, 1e6, 0.04167124, 130.051, 18.41466, 86.0256),
        (0.0, 1.0, 1e6, 0.04151453, 131.480, 18.46375, 86.2279),
        (0.0, 0.3, 1e6, 0.0415311, None, None, None),
        (0.0, 0.3, 1e7, 0.0415064, None, None, None),
    ],
)
def test_worked_examples_come_out_to_the_digits_printed(
    play, share, stiffness, period, most, least, handoff
):
    found = esc.terminal(timer(play=play, share=share, stiffness=stiffness), rtol=1e-8)
    assert found.status is Status.OK
    assert found.period == pytest.approx(period, abs=0.7 * 10.0 ** -len(str(period)[2:]))
    if most:
        assert found.velocity_max == pytest.approx(most, abs=6e-4)
        assert found.velocity_min == pytest.approx(least, abs=6e-6)
        assert found.handoff_velocity == pytest.approx(handoff, abs=6e-5)


def test_stiff_walls_tend_to_rigid_bodies_with_order_one_half():
    exact = esc.terminal(rigid()).period
    errors = [
        esc.terminal(timer(stiffness=k, share=0.3), rtol=1e-8).period - exact for k in (1e6, 4e6)
    ]
    assert math.log(errors[0] / errors[1]) / math.log(4.0) == pytest.approx(0.5, abs=0.02)


def test_the_error_falls_with_the_order_of_the_method():
    # without damping and friction the law is smooth between touches
    own = timer(friction=0.0, share=0.0, stiffness=1e5)
    exact = esc.simulate(own, 1, rtol=1e-13).handoff_velocities[0]
    rtols = [1e-6, 1e-7, 1e-8, 1e-9]
    found = [esc.simulate(own, 1, rtol=rtol) for rtol in rtols]
    errors = np.array([abs(m.handoff_velocities[0] / exact - 1.0) for m in found])
    assert (errors < rtols).all()
    steps = [m.trajectory.rows.steps.size for m in found]
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order == pytest.approx(9.0, abs=0.5)


@pytest.mark.parametrize("internal", [False, True])
def test_an_integrator_of_its_own_finds_the_same_motion(internal):
    own, end = timer(play=1e-3, stiffness=3e3, internal=internal, pin_radius=5e-4), 0.9 * CLOCK
    state = esc.simulate(own, duration=end, rtol=1e-10).at(end)
    found = [state.theta, state.phi, state.theta_dot, state.phi_dot]
    assert np.array(found) == pytest.approx(between_elastic_walls(own, end), rel=2e-6)


_LOSSES = {
    "load_torque": 0.05 * TORQUE,
    "driver_bearing_torque": 0.1 * TORQUE,
    "driver_drag": 0.005 * FOLLOWER,
    "follower_viscous": 0.02 * math.sqrt(FOLLOWER * TORQUE),
    "follower_bearing_friction": 0.15,
    "follower_bearing_radius": 0.08 * RADIUS,
    "spring_rate": 0.01 * TORQUE,
}


@pytest.mark.parametrize(
    "other",
    [
        {"play": 1e-3, "share": 0.05},
        {"play": 1e-3, "pin_radius": 0.05 * RADIUS, **_LOSSES},
        {"slots": 5, "play": 1e-3, "share": 0.1},
        {"play": 1e-3, "contact_law": "hunt-crossley", "damping": 0.0, "restitution": 0.3},
        {"friction": 0.7, "stiffness": 1e5},
    ],
)
def test_the_energy_balance_closes(other):
    motion = esc.simulate(timer(**other), 5, rtol=1e-9)
    assert motion.status is Status.OK
    assert abs(motion.ledger.residual) < 1e-8
    assert motion.ledger.blows > 0.0
    times = np.linspace(0.0, motion.end_time, 40_001)
    state = motion.at(times)
    for angle, speed in ((state.theta, state.theta_dot), (state.phi, state.phi_dot)):
        turned = np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(times))
        assert turned == pytest.approx(angle[-1] - angle[0], rel=1e-4)


def test_losses_agree_with_the_rigid_engine():
    own = timer(stiffness=1e8, pin_radius=0.05 * RADIUS, **{**_LOSSES, "spring_rate": 0.0})
    wheel = esc.Geneva(4, crank_radius=RADIUS, pin_radius=0.05 * RADIUS)
    given = {**_LOSSES, "spring_rate": 0.0, "friction": 0.3, "torque": TORQUE}
    plain = esc.simulate(esc.Escapement(wheel, own.inertia, **given), 2, engine="energy")
    found = esc.simulate(own, 2, rtol=1e-7)
    assert found.handoff_times == pytest.approx(plain.handoff_times, rel=1e-4)
    assert found.handoff_velocities == pytest.approx(plain.handoff_velocities, rel=1e-4)


def test_engagements_that_never_repeat_give_means_and_intervals():
    found = esc.terminal(timer(play=5e-4, share=0.1), rtol=1e-7)
    assert found.status is Status.OK
    assert found.spread is not None
    assert found.spread.deviation["period"] > found.spread.interval["period"] > 0.0
    assert "do not repeat" in found.message


def test_beyond_the_limit_it_jams_where_the_message_says():
    own = timer(friction=0.6, stiffness=1e5)
    found = esc.terminal(own, rtol=1e-7)
    assert found.status is Status.OK
    assert "jams" in found.message
    stops = esc.jams(found.motion)
    assert stops.angle.size > 0
    assert (stops.duration > 0.0).all()
    assert found.motion.at(stops.time).theta_dot.max() < 0.011 * found.velocity_mean
    for task in (esc.simulate, esc.terminal):
        answer = task(rigid(friction=0.6))
        assert answer.status is Status.PAINLEVE
        assert "stiffness" in answer.message
        assert "jam_rule" in answer.message


@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
def test_a_flight_that_turns_back_misses_no_wall(rtol):
    # where a jam lets go the pin flies to the other wall and back while the driver hardly turns;
    # 0.0599779720 s is what solve_ivp's Radau finds with rtol 1e-9 and 1e-10
    follower, torque = 5.65e-6, 0.0113
    clock, unit = math.sqrt(follower / torque), torque / RADIUS**2
    own = esc.Escapement(
        esc.Geneva(4, crank_radius=RADIUS, clearance=1e-5),
        esc.Inertia(3.39e-7, follower),
        torque=torque,
        friction=0.6,
        stiffness=1e6 * unit,
        damping=1e3 * unit * clock,
    )
    found = esc.simulate(own, 1, rtol=rtol)
    assert found.handoff_times[0] == pytest.approx(0.0599779720, rel=max(rtol, 2e-9))


@pytest.mark.parametrize(
    ("friction", "period", "handoff", "angles"),
    [
        (0.7, 0.0661821699, 50.2349875, (25.7419, 36.2461, 40.2465)),
        (0.5, 0.0583947, 60.71825, (26.4836, 36.0936)),
    ],
)
def test_the_rule_for_rigid_jams(friction, period, handoff, angles):
    found = esc.jam_rule(rigid(friction=friction))
    assert found.period == pytest.approx(period, rel=1e-6 if friction == 0.5 else 1e-9)
    assert found.handoff_velocity == pytest.approx(handoff, rel=1e-7)
    assert np.degrees(found.jam_angles) == pytest.approx(angles, abs=6e-5)
    with pytest.raises(esc.errors.InvalidValue, match="below it, use terminal"):
        esc.jam_rule(rigid(friction=0.3))


@pytest.mark.parametrize("e", [0.1, 0.4, 0.8])
def test_the_force_of_hunt_and_crossley_is_that_of_the_paper(e):
    """N = k d^1.5 (1 + 8 (1 - e)/(5 e v) d') with the speed v at which the pin touches the wall."""
    law = {"contact_law": "hunt-crossley", "damping": None, "restitution": e}
    own = timer(play=1e-3, stiffness=1e5, friction=0.1, **law)
    motion = esc.simulate(own, 1, rtol=1e-11)
    wheel, blow = (
        own.mechanism,
        np.flatnonzero(motion.impacts.approach_speed * CLOCK > 0.1 * RADIUS)[0],
    )
    start, touch = motion.impacts.time[blow], motion.impacts.approach_speed[blow] * CLOCK / RADIUS
    piece = np.flatnonzero(motion.trajectory.start == start)[-1]
    ends = np.append(motion.trajectory.start, motion.end_time)
    times = start + np.linspace(0.01, 0.9, 7) * (ends[piece + 1] - start)
    state = motion.within(np.full(7, piece), times)
    pin = wheel.centre_distance - np.exp(-1j * state.theta)
    along = np.exp(1j * state.phi)
    across = (pin / along).imag
    moves = 1j * np.exp(-1j * state.theta) * state.theta_dot
    rate = (moves / along).imag - (pin / along).real * state.phi_dot
    side = motion.impacts.wall[blow]
    depth, pressing = side * across - 1e-3, side * rate * CLOCK
    force = 1e5 * depth**1.5 * (1.0 + 8.0 * (1.0 - e) / (5.0 * e * touch) * pressing)
    assert state.contact_force * side * RADIUS / TORQUE == pytest.approx(force, rel=1e-5)


@pytest.mark.parametrize(("rho", "slots"), [(0.06, 4), (0.3, 6), (2.0, 3)])
def test_walls_have_critical_damping_by_default(rho, slots):
    """Both bodies on the spring of one wall: m D'' + b D' + k D = 0 has a double root."""
    wheel = esc.Geneva(slots, crank_radius=RADIUS)
    own = esc.Escapement(
        wheel, esc.Inertia(rho * FOLLOWER, FOLLOWER), TORQUE, 0.1, stiffness=1e4 * UNIT
    )
    mass = 1.0 / (RADIUS**2 * (1.0 / (rho * FOLLOWER) + 1.0 / FOLLOWER))
    roots = np.roots([mass, own.critical_damping, own.stiffness])
    assert roots.real == pytest.approx([-math.sqrt(own.stiffness / mass)] * 2, rel=1e-6)
    given = replace(own, damping=own.critical_damping)
    one, two = (esc.simulate(drive, 2) for drive in (own, given))
    assert one.handoff_times.tolist() == two.handoff_times.tolist()
    assert f"critical damping, {own.critical_damping:.6g} N s/m, is taken" in one.message
    assert (
        f"critical damping, {own.critical_damping:.6g} N s/m, is taken" in esc.terminal(own).message
    )
    assert "damping" not in two.message


BARREL = {"slots": 5, "rho": 0.017, "efficiency": 0.58, "inertia": 1.36, "friction": 0.679}
HEAVY = {"slots": 3, "rho": 0.41, "efficiency": 0.71, "inertia": 23.8, "friction": 2.317}
LIGHT = {"slots": 6, "rho": 0.013, "efficiency": 0.42, "inertia": 2.1, "friction": 0.95}


@pytest.mark.parametrize("case", [BARREL, HEAVY, LIGHT])
def test_the_rule_for_jams_holds_behind_trains_that_lose_power(case):
    wheel = esc.Geneva(case["slots"], crank_radius=RADIUS)
    driver = case["rho"] * FOLLOWER
    barrel = esc.Train(5, case["efficiency"], 25.0 * case["inertia"] * driver)
    bodies = wheel, esc.Inertia(driver, FOLLOWER), 5.0 * TORQUE, case["friction"]
    rule = esc.jam_rule(esc.Escapement(*bodies, barrel=barrel))
    yields = esc.Escapement(
        *bodies, barrel=barrel, stiffness=1e8 * UNIT, damping=1e4 * UNIT * CLOCK
    )
    found = esc.terminal(yields, rtol=1e-7)
    assert found.spread is None
    assert rule.period == pytest.approx(found.period, rel=rule.error)
    assert rule.handoff_velocity == pytest.approx(found.handoff_velocity, rel=rule.error)
    assert rule.velocity_max == pytest.approx(found.velocity_max, rel=0.01)


def test_contact_summary_counts_what_the_motion_does():
    motion = esc.simulate(timer(play=1e-3, share=0.1, stiffness=1e5), 3)
    found = esc.contact_summary(motion)
    times = np.linspace(0.0, motion.end_time, 200_001)
    force = np.abs(motion.at(times).contact_force)
    assert found.force_max >= force.max() * (1.0 - 1e-9)
    assert found.force_max == pytest.approx(force.max(), rel=1e-3)
    assert abs(motion.at(found.force_max_time).contact_force) == pytest.approx(found.force_max)
    loose = esc.contact_summary(
        esc.simulate(timer(play=1e-3, share=0.1, stiffness=1e5), 3, rtol=1e-7)
    )
    assert loose.impulses[:5] == pytest.approx(found.impulses[:5], rel=1e-4)
    assert found.counts.sum() == (found.impulses > 0.0).sum()
    assert found.bounces.min() > 0
    assert found.energy == pytest.approx(motion.ledger.blows, rel=1e-12)
    # all impulses together are no more than that of the force
    whole = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(times)))
    assert found.impulses.sum() < whole


def test_stiffness_of_a_line_contact_is_that_of_its_stresses():
    force, radius, width, modulus, nu, depth = 20.0, 1e-3, 2e-3, 210e9, 0.3, 3e-3
    half = math.sqrt(4.0 * force / width * radius * 2.0 * (1.0 - nu**2) / (math.pi * modulus))
    peak = 2.0 * force / (math.pi * half * width)

    def strain(z):
        root = math.hypot(half, z)
        ahead = -peak / half * ((half**2 + 2.0 * z**2) / root - 2.0 * z)
        below = -peak * half / root
        return (1.0 - nu**2) / modulus * (below - nu / (1.0 - nu) * ahead)

    wall = -quad(strain, 0.0, depth, points=[half], epsabs=0.0, epsrel=1e-10, limit=500)[0]
    numbers = {"radius": radius, "width": width, "modulus": modulus, "depth": depth}
    # a pin that is next to rigid leaves the wall alone, of half the compliance
    half_wall = esc.contact_stiffness(
        2.0 * force, **{**numbers, "modulus": 1e6 * modulus, "wall_modulus": modulus}
    )
    assert half_wall > 0.0
    soft = esc.contact_stiffness(force, **numbers)
    pin = (1.0 - nu**2) / (math.pi * modulus * width) * (2.0 * math.log(4.0 * radius / half) - 1.0)
    assert 1.0 / soft == pytest.approx(wall / force + pin, rel=1e-3)
    with pytest.raises(esc.errors.InvalidValue, match="narrow"):
        esc.contact_stiffness(1e7, **numbers)


def test_a_load_that_the_drive_cannot_carry_stalls():
    assert esc.simulate(timer(load_torque=2.0 * TORQUE, stiffness=1e4)).status is Status.STALL


@pytest.mark.parametrize("friction", [0.45, 0.5, 0.6])
def test_the_rule_for_jams_finds_the_peak_on_the_rear_wall(friction):
    found = esc.jam_rule(rigid(friction=friction))
    compliant = esc.terminal(timer(friction=friction, stiffness=1e8), rtol=1e-7)
    assert found.velocity_max == pytest.approx(compliant.velocity_max, rel=0.02)
    assert found.velocity_max > 1.05 * found.handoff_velocity


def test_a_duration_ends_the_motion_to_the_digit():
    motion = esc.simulate(timer(play=1e-3, stiffness=1e5), duration=0.05)
    assert motion.end_time == 0.05
    assert motion.at(0.05).theta > motion.at(0.049).theta
