"""Mechanisms that come to rest: a spring that is spent, and a drive that drives nothing."""

import time
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import escapement as esc
from clearance_bodies import TwoBodies
from escapement.base.status import Status

RADIUS, TORQUE = 0.01, 0.0113
INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
CLOCK = (INERTIA.follower / TORQUE) ** 0.5
REST = 1e-3 / CLOCK
"""Speed [rad/s] of a driver that counts as at rest."""


def timer(clearance=0.0, slots=4, pins=None, **given):
    wheel = esc.Geneva(slots, pins, crank_radius=RADIUS, clearance=clearance)
    return esc.Escapement(
        wheel, **({"inertia": INERTIA, "torque": TORQUE, "friction": 0.3} | given)
    )


@pytest.mark.parametrize(("rate", "engagements"), [(0.05, 18), (0.05, 40), (0.02, 200)])
def test_a_spring_that_runs_down_ends_with_clearance_as_without(rate, engagements):
    given = {"inertia": esc.Inertia(0.06, 1.0), "torque": 1.0, "friction": 0.35}
    own = timer(1e-5, spring_rate=rate, **given)
    esc.simulate(own, 1)
    start = time.process_time()
    motion = esc.simulate(own, engagements)
    assert time.process_time() - start < 2.0
    ideal = esc.simulate(timer(spring_rate=rate, **given), engagements)
    assert motion.status is ideal.status is Status.SPENT
    assert motion.handoff_times.size == ideal.handoff_times.size
    assert motion.end_time == pytest.approx(ideal.end_time, rel=0.1)
    # the speed counts as that of a driver at rest, and the one before does not
    assert motion.handoff_velocities[-1] <= 1e-3 < motion.handoff_velocities[-2]
    assert abs(motion.ledger.residual) < 1e-13


@pytest.mark.parametrize(
    "more",
    [
        {"restitution": 0.5},
        {"restitution": 0.5, "driver_drag": 1e-8},
        {"driver_viscous": 2e-6, "follower_viscous": 1e-6},
        {"pins": 1, "follower_drag": 1e-8},
        {"slots": 3, "friction": 0.1, "driver_bearing_torque": 0.02 * TORQUE},
        {"stiffness": 1e8, "friction": 0.2},
    ],
)
@pytest.mark.parametrize("cells", [3.5, 6.2])
def test_a_spent_spring_is_said_whatever_else_acts(more, cells):
    """It is spent at dead centre, or between two of them."""
    own = timer(1e-5, **more)
    own = replace(own, spring_rate=TORQUE / (cells * own.mechanism.cell_angle))
    motion = esc.simulate(own, 300)
    assert motion.status in (Status.SPENT, Status.STALL)
    turned = motion.at(motion.end_time).theta - motion.at(0.0).theta
    left = max(TORQUE - own.spring_rate * turned, 0.0)
    assert (motion.status is Status.SPENT) == (left == 0.0)
    assert left <= own.driver_bearing_torque
    assert abs(motion.ledger.residual) < (1e-8 if own.stiffness else 1e-12)


def test_viscous_drag_ends_where_the_energy_is_that_of_a_driver_at_rest():
    drag = {"driver_viscous": 2e-6, "follower_viscous": 1e-6, "spring_rate": TORQUE / 6.0}
    plays = np.array([2e-7, 2e-8, 2e-9])
    found = [esc.simulate(timer(play, **drag), 30) for play in plays]
    exact = esc.simulate(timer(**drag), 30).end_time
    for motion in found:
        state = motion.at(motion.end_time)
        energy = INERTIA.driver * state.theta_dot**2 + INERTIA.follower * state.phi_dot**2
        assert energy == pytest.approx(INERTIA.driver * REST**2, rel=1e-8)
    errors = [motion.end_time / exact - 1.0 for motion in found]
    assert_allclose(np.diff(np.log(errors)) / np.diff(np.log(plays)), 1.0, atol=0.07)


@pytest.mark.parametrize("more", [{}, {"driver_bearing_torque": 0.05 * TORQUE}])
def test_two_bodies_in_time_run_down_alike(more):
    own = timer(1e-4, friction=0.2, spring_rate=TORQUE / 8.0, **more)
    motion = esc.simulate(own, 8)
    until = motion.handoff_times[3] + 1e-9
    times, speeds = TwoBodies(own).run(8, until=until)
    assert_allclose(times, motion.handoff_times[:4], rtol=1e-9)
    assert_allclose(speeds, motion.handoff_velocities[:4], rtol=1e-8)


ENGINES = {
    "energy": {"engine": "energy"},
    "ivp": {"engine": "ivp"},
    "rigid": {"clearance": 2e-5},
    "bouncing": {"clearance": 2e-5, "restitution": 0.4},
    "compliant": {"clearance": 2e-5, "stiffness": 1e7},
}


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("held", [1.0, 1.3])
@pytest.mark.parametrize(
    "more",
    [
        {},
        {"follower_viscous": 1e-7},
        {"torque": esc.TorqueCurve((0.0, 0.4, 3.0), (TORQUE, 0.3 * TORQUE, 0.9 * TORQUE))},
        {"follower_bearing_friction": 0.2, "follower_bearing_radius": 0.1 * RADIUS},
    ],
    ids=["plain", "oil", "curve", "journal"],
)
def test_a_bearing_that_holds_the_drive_stalls_it(name, held, more):
    settings = dict(ENGINES[name])
    engine = {"engine": settings.pop("engine")} if "engine" in settings else {}
    own = timer(driver_bearing_torque=held * TORQUE, **settings | more)
    still = esc.simulate(own, 3, **engine)
    assert still.status is Status.STALL
    assert still.end_time < 1e-6 * CLOCK
    assert esc.terminal(own, **engine).status is Status.STALL
    moved = esc.simulate(own, 60, initial_speed=0.5 / CLOCK, **engine)
    assert moved.status is Status.STALL
    assert moved.handoff_times.size < 10
    states = moved.at(np.linspace(0.0, moved.end_time, 400))
    # friction never drives: the energy falls, and the driver turns back in a rebound only
    energy = INERTIA.driver * states.theta_dot**2 + INERTIA.follower * states.phi_dot**2
    assert energy.max() <= energy[0] * (1.0 + 1e-6)
    if name not in ("bouncing", "compliant"):
        assert states.theta_dot.min() >= -1e-9 * states.theta_dot.max()
    assert abs(moved.ledger.residual) < (1e-6 if name == "compliant" else 1e-9)


def test_a_bearing_holds_the_driver_while_the_follower_flies_on():
    own = timer(4e-4, friction=0.05, driver_bearing_torque=1.6 * TORQUE)
    speed = 2.2 / CLOCK
    motion = esc.simulate(own, 4, initial_speed=speed)
    states = motion.at(np.linspace(0.0, motion.end_time, 4000))
    held = (states.theta_dot == 0.0) & (states.phi_dot > 0.0)
    assert held.sum() > 5
    assert motion.impacts.time.max() > motion.impacts.time.min()
    assert abs(motion.ledger.residual) < 1e-12


def test_a_motion_says_where_it_stands_when_its_steps_are_used_up(monkeypatch):
    from escapement.dynamics import compliant_march as compliant
    from escapement.engines.contact.rigid import simulate as rigid

    monkeypatch.setattr(compliant, "MOST_TRIES", 2000)
    own = timer(2e-5, stiffness=1e8, damping=0.0)
    motion = esc.simulate(own, 20)
    assert motion.status is Status.NOT_CONVERGED
    assert f"after {motion.end_time:.6g} s" in motion.message
    assert "steps were used up; leave out damping" in motion.message
    # the advice helps
    assert esc.simulate(replace(own, damping=None), 3).status is Status.OK
    monkeypatch.setattr(rigid, "MOST_OVERALL", 0)
    monkeypatch.setattr(rigid, "MOST_EACH", 1)
    motion = esc.simulate(timer(2e-5, spring_rate=1e-9), 30_000)
    assert motion.status is Status.NOT_CONVERGED
    assert f"engagement {motion.handoff_times.size + 1}," in motion.message
    assert 0 < motion.handoff_times.size < 30_000


def test_a_ledger_that_does_not_close_says_so():
    from escapement.dynamics import energy_balance as ledger

    motion = esc.simulate(timer(driver_bearing_torque=1.2 * TORQUE), 1, initial_speed=20.0)
    closed = ledger.ledger_of(motion)
    assert abs(closed.residual) < 1e-11
    # the driver bearing's loss with the wrong sign, as of a friction that drives
    bearing = list(motion.trajectory.losses)
    motion.trajectory.losses = np.array(bearing) * np.array([1, -1, 1, 1, 1, 1, 1.0])[:, None]
    assert abs(ledger.ledger_of(motion).residual) > 0.5


def test_a_motion_ends_with_the_blow_that_stops_both_bodies():
    """The spring is spent, the bearing holds the driver, and the follower runs up to its pin."""
    timer = esc.Escapement(
        esc.Geneva(4, crank_radius=0.02, clearance=4e-5), esc.Inertia(3.4e-7, 5.65e-6),
        0.0113, 0.1, spring_rate=2e-3, driver_bearing_torque=1e-3,
    )  # fmt: skip
    motion = esc.simulate(timer, 12)
    assert motion.status is Status.SPENT
    assert motion.impacts.time[-1] == pytest.approx(motion.end_time, rel=1e-14)
    assert motion.impacts.time[-1] <= motion.end_time
    end = motion.at(motion.end_time)
    assert (float(end.theta_dot), float(end.phi_dot)) == (0.0, 0.0)


def test_a_follower_that_the_load_stops_beyond_a_wall_strikes_where_that_wall_is():
    """The driver is held; the follower would come to rest just beyond the wall behind the pin."""
    wheel = esc.Geneva(5, 1, crank_radius=RADIUS, clearance=1.5e-5)
    own = esc.Escapement(
        wheel, esc.Inertia(2.23e-7, 5e-6), 0.01, 0.07, load_torque=2e-4, spring_rate=7e-4,
        driver_bearing_torque=0.01, restitution=0.11,
    )  # fmt: skip
    for speed in np.linspace(9.0, 15.0, 25):
        motion = esc.simulate(own, 4, initial_speed=speed)
        impacts = motion.impacts
        phi = motion.at(impacts.time).phi
        # the pin as seen from the follower's axis
        x = RADIUS / np.sin(np.pi / 5) - RADIUS * np.cos(impacts.theta)
        y = RADIUS * np.sin(impacts.theta)
        ahead = y * np.cos(phi) - x * np.sin(phi)
        assert_allclose(ahead, 0.5 * wheel.clearance * impacts.wall, rtol=0, atol=1e-12 * RADIUS)
        assert abs(motion.ledger.residual) < 1e-13
