"""Two bodies whose outlines yield: rigid limit, balances, the slot engine, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.engines.two_bodies.compliant.simulate import March
from escapement.engines.two_bodies.march import PHI, SPEED, THETA, TURNING
from test_clock_page import CLOCK
from test_touching_overlap import random_runaways
from test_two_bodies import flat, pins, runaway

RIGID = 0.9554163897016
"""Period of the runaway with pins, from two programs that share nothing."""


def overdamped(delay, slip=1e-5, wheel=None, inertias=(1.0, 0.3), ratio=30.0):
    """So many times critical damping that blows are plastic; `delay` is damping/stiffness."""
    stiffness = 4.0 * ratio**2 / (delay**2 * sum(1.0 / inertia for inertia in inertias))
    damping = delay * stiffness
    return runaway(wheel, inertias, stiffness=stiffness, damping=damping, slip_speed=slip)


def last_period(timer, count=9, speed=0.0):
    motion = esc.simulate(timer, count, rtol=1e-9, initial_speed=speed)
    assert motion.status is Status.OK, motion.message
    return float(motion.handoff_times[-1] - motion.handoff_times[-2])


@pytest.mark.slow
def test_stiff_bodies_tend_to_rigid_ones_with_order_one():
    errors = [last_period(overdamped(delay)) - RIGID for delay in (1e-2, 1e-3, 1e-4)]
    slopes = np.diff(np.log10(np.abs(errors)))
    assert slopes == pytest.approx(-1.0, abs=0.08)
    # what is left of the last two when the first order is taken away
    assert abs(10.0 * errors[2] - errors[1]) / 9.0 < 1e-9


def geneva(slots, pin, half_clearance=5e-4):
    """A Geneva wheel as outlines: the pin is a circle, and each slot has two walls."""
    centre = 1.0 / math.sin(math.pi / slots)
    outer, entry = math.sqrt(centre**2 - 1.0), math.pi / slots - 0.5 * math.pi
    pins = 2 * slots // (slots - 2) if 2 * slots % (slots - 2) == 0 else 1
    at = complex(math.cos(entry), math.sin(entry))
    circle = [(at.real - pin, at.imag, 1.0), (at.real + pin, at.imag, 1.0)]
    along = (at - centre) / abs(at - centre)
    low, high = max(centre - 1.2, 0.05), math.sqrt(outer**2 - half_clearance**2)
    walls = []
    for side, ends in ((1.0, (low, high)), (-1.0, (high, low))):
        points = [(x + 1j * side * (half_clearance + pin)) * along for x in ends]
        walls.append([(point.real, point.imag) for point in points])
    driver = [[*circle, circle[0]]]
    return esc.Outlines(driver, walls, centre, driver_fold=pins, follower_fold=slots)


# with neighbouring pins the slot engine lets the next one begin pressed in, where an outline lets
# none begin from behind, so only the first engagement is the same
@pytest.mark.parametrize(("slots", "pin", "count"), [(3, 0.03, 6), (4, 0.05, 1), (6, 0.02, 1)])
def test_geneva_as_outlines_is_the_geneva_of_the_slot_engine(slots, pin, count):
    given = {"friction": 0.3, "stiffness": 1e6, "damping": 1e3, "slip_speed": 1e-4}
    wheel = esc.Geneva(slots, crank_radius=1.0, pin_radius=pin, clearance=1e-3)
    one, two = (
        esc.simulate(esc.Escapement(x, esc.Inertia(0.06, 1.0), 1.0, **given), count, rtol=1e-10)
        for x in (wheel, geneva(slots, pin))
    )
    assert two.handoff_times == pytest.approx(one.handoff_times, rel=1e-9)
    assert two.handoff_velocities == pytest.approx(one.handoff_velocities, rel=1e-8)
    assert two.ledger.friction == pytest.approx(one.ledger.friction, rel=1e-8)
    # the force in the hardest blow
    assert two.trajectory.hardest[0] == pytest.approx(one.trajectory.hardest[0], rel=1e-8)


@pytest.mark.parametrize(
    ("make", "inertias", "rigid", "stiffness", "driver", "follower"),
    [
        (pins, (1.0, 0.3), 1.1227055509, 1e6, 2.9e5, 8.4e5),
        (pins, (1.0, 0.3), 1.1227055509, 1e5, 9e4, 2.6e5),
        (pins, (0.06, 1.0), 1.7361262951, 1e6, 1.1e7, 5.6e5),
    ],
)
def test_accelerations_in_blows_are_those_of_another_program(
    make, inertias, rigid, stiffness, driver, follower
):
    # that program took explicit steps; periods are scaled to that of Meyer's Geneva wheel
    damping = math.sqrt(stiffness * min(inertias))
    timer = runaway(make(), inertias, 0.3, stiffness=stiffness, damping=damping)
    unit = (rigid / 0.041495034) ** 2
    found = esc.simulate(timer, 3).trajectory.peaks[:2, 0] * unit
    assert found == pytest.approx((driver, follower), rel=0.03)


_LOSSES = {
    "driver_bearing_torque": 0.02, "driver_viscous": 0.02, "follower_viscous": 0.01,
    "driver_drag": 0.05, "follower_drag": 0.02, "load_torque": 0.01, "spring_rate": 0.01,
    "driver_bearing_friction": 0.1, "driver_bearing_radius": 0.05,
    "follower_bearing_friction": 0.1, "follower_bearing_radius": 0.05,
    "follower_spring": 0.2, "follower_gravity": 0.1, "follower_rest_angle": 0.05,
}  # fmt: skip


@pytest.mark.parametrize(
    "numbers",
    [
        {"stiffness": 1e5, **_LOSSES},
        {"stiffness": 1e6, "damping": 100.0},
        {"stiffness": 1e7, "contact_law": "hunt-crossley", "restitution": 0.3},
    ],
)
def test_the_energy_balance_closes(numbers):
    motion = esc.simulate(runaway(**numbers), 4, rtol=1e-9)
    assert motion.status is Status.OK, motion.message
    ledger = motion.ledger
    assert abs(ledger.residual) < 1e-8
    assert min(ledger.blows, ledger.friction) > 0.0
    # the states are those of the law: speeds are the slopes of angles, work is power over time
    t = np.linspace(0.0, motion.end_time, 60_001)
    state = motion.at(t)
    assert np.trapezoid(state.theta_dot, t) == pytest.approx(state.theta[-1] - state.theta[0])
    lost = np.trapezoid(state.power_lost["friction"], t)
    assert lost == pytest.approx(ledger.friction, rel=0.01)
    assert (state.contact_force >= -1e-6).all()


def test_terminal_is_the_cycle_that_a_long_motion_reaches():
    timer = runaway(stiffness=1e6)
    cycle = esc.terminal(timer, rtol=1e-9)
    assert cycle.status is Status.OK
    assert "critical damping" in cycle.message
    assert cycle.period == pytest.approx(last_period(timer, 14), rel=1e-7)
    assert abs(cycle.energy_residual) < 1e-8
    rigid = esc.terminal(runaway())
    assert cycle.contact_force_max > 100.0 * rigid.contact_force_max


@pytest.mark.slow
def test_engagements_that_never_repeat_give_means_and_intervals():
    cycle = esc.terminal(runaway(flat(), (1.0, 0.1), stiffness=1e5), rtol=1e-8)
    assert cycle.status is Status.OK
    assert cycle.spread.interval["period"] > 0.0
    assert "do not repeat" in cycle.message


def test_designs_are_compared_in_their_blows():
    found = esc.compare(runaway(), runaway(friction=0.1), stiffness=1e6)
    for one in found:
        for name in ("acceleration_max", "follower_acceleration_max", "contact_force_max"):
            assert one.values[f"{name}_in_blows"] > 10.0 * one.values[name]


def test_bodies_that_sink_too_deep_are_said():
    motion = esc.simulate(runaway(flat(), (1.0, 0.1), stiffness=1.1e3), 4)
    assert motion.status is Status.NOT_CONVERGED
    assert "give a greater stiffness" in motion.message


SHARP = {"tip_radius": 0.0, "corner_radius": 0.0}


@pytest.mark.parametrize(
    ("timer", "named"),
    [
        (lambda: runaway(stiffness=10.0), "stiffness must be at least"),
        (lambda: runaway(flat(**SHARP), (1.0, 0.1), 0.05, stiffness=1e6), "sharp corners"),
        (lambda: runaway(stiffness=1e6, restitution=0.2), "restitution must be 0"),
        (lambda: runaway(stiffness=1e6, follower_gravity=0.1), "takes many swings"),
    ],
)
def test_what_it_cannot_compute_is_refused(timer, named):
    with pytest.raises(InvalidValue, match=named):
        esc.terminal(timer())


@pytest.mark.slow
def test_no_contact_is_missed():
    # a missed contact would change the times of handoffs by far more, or jam another design
    for k, wheel in enumerate(random_runaways(3, 8)):
        inertias = (1.0, (0.1, 1.0)[k // 2 % 2])
        own = overdamped(1e-3, 1e-6, wheel, inertias, ratio=300.0)
        yields = esc.simulate(own, 4, rtol=1e-9)
        rigid = esc.simulate(runaway(wheel, inertias), 4)
        assert yields.status is rigid.status
        assert yields.handoff_times == pytest.approx(rigid.handoff_times, rel=2e-3)


@pytest.mark.slow
def test_a_clock_swings_once_from_its_rigid_cycle():
    cycle = esc.terminal(CLOCK)
    begin, unit = cycle.motion.trajectory.begins[0], CLOCK.time_unit
    own = replace(CLOCK, stiffness=1e7, damping=4.0 * math.sqrt(1e7 * 1e-4), slip_speed=1e-5)
    march = March(own, 0.0, 1e-10)
    march.state[:4] = begin[[THETA, PHI, SPEED, TURNING]]
    motion = march.motion(*march.go(1), 1e-10)
    assert motion.status is Status.OK
    # another program took explicit steps, and agrees with rigid bodies to 5e-7
    assert motion.handoff_times[0] == pytest.approx(6.29167653, rel=5e-7)
    assert march.state[1] == pytest.approx(-0.02302350, abs=5e-7)
    assert march.state[3] / unit == pytest.approx(-0.09796936, abs=1e-8)


def _lightness(timer, time):
    """Acceleration that a unit of force gives the gap, from those just behind a touch."""
    state = esc.simulate(timer, duration=time + 1e-6, rtol=1e-10).at(time + 1e-6)
    force = float(state.contact_force)
    driver = (float(state.theta_ddot) - 1.0) / force
    follower = float(state.phi_ddot) / force
    return driver**2 * timer.inertia.driver + follower**2 * timer.inertia.follower


def test_bounces_give_back_the_share_that_the_damping_leaves():
    # without friction a linear contact of damping ratio z gives back this share of the speed
    stiffness, z = 1e8, 0.3
    timer = runaway(friction=0.0, stiffness=stiffness, damping=1.0)
    touch = esc.simulate(timer, 1).impacts.time[0]
    root = math.sqrt(1.0 - z * z)
    angle = math.atan2(2.0 * z * root, 2.0 * z * z - 1.0)
    share = math.exp(-z / root * angle)
    lightness = _lightness(timer, touch)
    own = replace(timer, damping=2.0 * z * math.sqrt(stiffness / lightness))
    blow = esc.simulate(own, duration=touch + 2e-3, rtol=1e-10).impacts
    kinetic = 0.5 * blow.approach_speed[0] ** 2 / lightness
    assert blow.energy[0] == pytest.approx((1.0 - share**2) * kinetic, rel=2e-3)


def test_error_of_the_slip_speed_is_of_first_order():
    # in one of the two blows the slip comes to zero
    speed = math.sqrt(2.0 * (0.14 - 0.05))
    errors = [
        last_period(overdamped(1e-3, slip, flat(), (1.0, 0.1)), speed=speed) - 0.9425425320853
        for slip in (1e-4, 1e-5)
    ]
    assert errors[0] / errors[1] == pytest.approx(10.0, abs=2.0)
