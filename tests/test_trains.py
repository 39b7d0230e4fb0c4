"""Gear trains before the driver and behind the follower."""

import math
from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from both_engines import agree, each_engine
from clearance_bodies import same_as_two_bodies

GENEVA = esc.Geneva(4, crank_radius=0.02)
OWN = esc.Inertia(3.39e-7, 5.65e-6)
BARREL = esc.Train(ratio=5.0, inertia=8e-6)
LOAD = esc.Train(ratio=3.0, inertia=6e-8)


def timer(**numbers):
    model = {"torque": 0.0565, "friction": 0.25, "load_torque": 2e-4, **numbers}
    return esc.Escapement(GENEVA, OWN, barrel=BARREL, load_train=LOAD, **model)


def same_by_hand(mine):
    """The same without trains, from the balance of each train's power."""
    i, j = BARREL.ratio, LOAD.ratio
    return esc.Escapement(
        GENEVA,
        esc.Inertia(OWN.driver + BARREL.inertia / i**2, OWN.follower + LOAD.inertia * j**2),
        torque=mine.torque / i,
        friction=mine.friction,
        load_torque=j * mine.load_torque,
        spring_rate=mine.spring_rate / i**2,
    )


@each_engine
@pytest.mark.parametrize("rate", [0.0, 2e-4])
def test_a_lossless_train_is_a_change_of_numbers(engine, rate):
    mine = timer(spring_rate=rate)
    found = [esc.simulate(one, 12, engine=engine) for one in (mine, same_by_hand(mine))]
    for name in ("handoff_times", "handoff_velocities"):
        one, other = (getattr(motion, name) for motion in found)
        np.testing.assert_allclose(one, other, rtol=1e-12)
    figures = [esc.terminal(motion.escapement, engine=engine) for motion in found]
    for name in ("period", "velocity_max", "contact_force_max", "critical_friction"):
        one, other = (getattr(it, name) for it in figures)
        assert one == pytest.approx(other, rel=1e-12)


def test_the_ledger_counts_what_the_barrel_gives():
    motion = esc.simulate(timer(), 5)
    ledger = esc.ledger_of(motion) if hasattr(esc, "ledger_of") else motion.ledger
    ends = motion.at([0.0, motion.end_time])
    turned = (ends.theta[1] - ends.theta[0]) / BARREL.ratio
    assert ledger.work == pytest.approx(0.0565 * turned, rel=1e-12)
    assert abs(ledger.residual) < 1e-12


def test_a_curve_is_over_the_angle_of_the_barrel():
    curve = esc.TorqueCurve([0.0, 4.0], [0.0565, 0.03])
    falling = timer(torque=curve)
    at_driver = esc.TorqueCurve([0.0, 20.0], [0.0565 / 5.0, 0.03 / 5.0])
    plain = esc.Escapement(
        GENEVA, falling.without_trains.inertia, at_driver, friction=0.25, load_torque=6e-4
    )
    times = [esc.simulate(one, 15).handoff_times for one in (falling, plain)]
    np.testing.assert_allclose(*times, rtol=1e-12)


MEYER = 0.45359237 * 9.80665 * 0.0254  # one in-lbf [N m]


def worked(barrel=0.8, train=0.9, **numbers):
    """Four slots, friction 0.30, K = 0.10 in-lbf behind a barrel of ratio 5."""
    follower, torque = 50e-6 * MEYER, 0.10 * MEYER
    own = esc.Inertia(3e-6 * MEYER, follower)
    model = {
        "torque": 5.0 * torque / 0.8,
        "friction": 0.30,
        "load_torque": 0.01 * torque,
        **numbers,
    }
    return esc.Escapement(
        esc.Geneva(4), own, **model, barrel=esc.Train(5.0, barrel, 1.5 * follower),
        load_train=esc.Train(3.0, train, 0.01 * follower),
    )  # fmt: skip


@each_engine
def test_the_worked_example_with_losses(engine):
    """Reference: two methods of others, who agree to 3e-9, gave these numbers."""
    found = esc.terminal(worked(), engine=engine)
    assert found.period == pytest.approx(0.0423001965, rel=3e-9)
    assert found.velocity_max == pytest.approx(111.684289, rel=1e-8)
    assert found.velocity_min == pytest.approx(17.9581900, rel=1e-8)


def test_engines_agree_where_power_turns_back():
    """With a heavy barrel the driver pushes it back; with a load train the follower does."""
    rng = np.random.default_rng(1973)
    turned_back = set()
    for _ in range(3):
        numbers = {"friction": rng.uniform(0.0, 0.3), "spring_rate": rng.choice([0.0, 2e-3])}
        timer = worked(barrel=rng.uniform(0.6, 1.0), train=rng.uniform(0.6, 1.0), **numbers)
        heavier = 10.0 ** rng.uniform(0.0, 2.0)
        timer = esc.Escapement(
            esc.Geneva(int(rng.integers(3, 8))), timer.inertia, timer.torque, **numbers,
            load_torque=rng.choice([0.0, 1e-4]), load_train=timer.load_train,
            barrel=esc.Train(5.0, timer.barrel.efficiency, heavier * timer.barrel.inertia),
        )  # fmt: skip
        fast, slow = agree(timer, 4, rtol=1e-9)
        np.testing.assert_allclose(fast.flow_changes.time, slow.flow_changes.time, rtol=1e-6)
        turned_back |= {*fast.flow_changes.train.tolist()}
    assert turned_back == {"barrel", "load_train"}


def test_every_train_takes_its_share():
    """At each instant a mesh passes eta of what reaches it, forwards or backwards."""
    timer = worked(barrel=0.7, train=0.8)
    timer = replace(timer, barrel=esc.Train(5.0, 0.7, 30.0 * timer.barrel.inertia))
    motion = esc.simulate(timer, 6)
    state = motion.at(np.linspace(0.02, 0.98, 301) * motion.end_time)
    reaches = timer.torque / 5.0 - timer.barrel.inertia / 25.0 * state.theta_ddot
    assert reaches.min() < 0.0 < reaches.max()
    taken = np.where(reaches > 0.0, 0.3, 1.0 / 0.7 - 1.0) * np.abs(reaches) * state.theta_dot
    np.testing.assert_allclose(state.power_lost["barrel"], taken, rtol=1e-9)
    asked = 3.0 * timer.load_torque + 9.0 * timer.load_train.inertia * state.phi_ddot
    taken = np.where(asked > 0.0, 1.0 / 0.8 - 1.0, 0.2) * np.abs(asked) * state.phi_dot
    np.testing.assert_allclose(state.power_lost["load_train"], taken, rtol=1e-9, atol=1e-15)
    driver = timer.inertia.driver * state.theta_ddot
    passes = np.where(reaches > 0.0, 0.7, 1.0 / 0.7) * reaches
    slid = state.power_lost["friction"] / state.theta_dot
    ratio = state.phi_dot / state.theta_dot
    np.testing.assert_allclose(passes - driver, ratio * state.contact_moment + slid, atol=1e-12)


def loose(play=5e-4, stiffness=0.0, share=10.0, **numbers):
    """The worked example with a play of so many crank radii; `share` of sqrt(k I_f)/r damps."""
    wheel = esc.Geneva(4, crank_radius=0.02, clearance=2.0 * play * 0.02)
    tight = worked(**numbers)
    torque, follower = tight.referred["torque"], tight.referred["follower_inertia"]
    walls = {"stiffness": stiffness * torque / 4e-4}
    walls["damping"] = share * math.sqrt(stiffness * follower * torque) / 4e-4
    return replace(tight, mechanism=wheel, **walls)


@pytest.mark.parametrize("stiffness", [0.0, 1e6])
def test_every_train_takes_its_share_with_clearance(stiffness):
    drive = loose(2e-3, stiffness, friction=0.1)
    motion = esc.simulate(drive, 4)
    assert abs(motion.ledger.residual) < (1e-12 if stiffness == 0.0 else 1e-8)
    state = motion.at(np.linspace(0.05, 0.99, 2001) * motion.end_time)
    barrel, train = drive.barrel, drive.load_train
    load = 3.0 * drive.load_torque * np.sign(state.phi_dot)
    passed = {
        "barrel": drive.torque / 5.0 - barrel.inertia / 25.0 * state.theta_ddot,
        "load_train": -load - 9.0 * train.inertia * state.phi_ddot,
    }
    for (place, torque), eta in zip(passed.items(), (0.8, 0.9), strict=True):
        speed = state.theta_dot if place == "barrel" else state.phi_dot
        power = torque * speed
        taken = np.where(power > 0.0, 1.0 - eta, 1.0 - 1.0 / eta) * power
        # where walls yield, the losses fade while a body is nearly at rest
        moves = np.abs(speed) > (0.0 if stiffness == 0.0 else 2.0)
        settings = {"rtol": 1e-5, "atol": 1e-9 * np.abs(power).max()}
        np.testing.assert_allclose(state.power_lost[place][moves], taken[moves], **settings)


def test_walls_that_yield_tend_to_rigid_ones():
    rigid, hard = esc.terminal(loose()), esc.terminal(loose(stiffness=1e9))
    assert hard.period == pytest.approx(rigid.period, rel=2e-5)
    assert hard.handoff_velocity == pytest.approx(rigid.handoff_velocity, rel=3e-5)
    soft, bounce = (
        esc.terminal(loose(stiffness=1e9, share=1.0)),
        esc.terminal(loose(restitution=0.3)),
    )
    # what rebounds costs more with a train that loses power: here 4e-4, without one 1e-5
    assert bounce.period / rigid.period - 1.0 > 2e-4
    assert soft.period == pytest.approx(bounce.period, rel=1e-4)


def test_a_driver_that_an_impact_throws_back_turns_its_barrel_back():
    """Behind the reversal the driver pushes the barrel, which then resists by 1/eta."""
    wheel = esc.Geneva(4, crank_radius=0.01, clearance=2e-4)
    barrel = esc.Train(0.2, 0.787, 3.5e-9)
    drive = esc.Escapement(
        wheel, esc.Inertia(1.1e-7, 5.65e-6), 0.0113 * 0.2, friction=0.005, restitution=0.788,
        barrel=barrel,
    )  # fmt: skip
    motion = same_as_two_bodies(drive, 2, 60.0)
    assert motion.at(np.linspace(0.0, motion.end_time, 9001)).theta_dot.min() < -1.0


@pytest.mark.parametrize("walls", [{}, {"stiffness": 1e8, "damping": 4e3}])
def test_a_lossless_train_is_a_change_of_numbers_with_clearance_too(walls):
    wheel = esc.Geneva(4, crank_radius=0.02, clearance=4e-5)
    mine = timer(spring_rate=2e-4)
    pair = [replace(one, mechanism=wheel, **walls) for one in (mine, same_by_hand(mine))]
    found = [esc.simulate(one, 5) for one in pair]
    for name in ("handoff_times", "handoff_velocities"):
        one, other = (getattr(motion, name) for motion in found)
        np.testing.assert_allclose(one, other, rtol=1e-9)
    one, other = (motion.impacts.energy for motion in found)
    np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-12)
    assert one.size > 5
    assert all(abs(motion.ledger.residual) < 1e-8 for motion in found)


def test_every_shaft_obeys_newton():
    """Moments on barrel, driver, follower and last shaft, with the forces of the meshes."""
    mine = timer(friction=0.0)
    motion = esc.simulate(mine, 3)
    state = motion.at(np.linspace(0.1, 0.9, 41) * motion.end_time)
    at_barrel = mine.torque - BARREL.inertia * state.theta_ddot / BARREL.ratio
    at_last = mine.load_torque + LOAD.inertia * state.phi_ddot * LOAD.ratio
    follower = state.contact_moment - LOAD.ratio * at_last
    ratio = state.phi_dot / state.theta_dot
    driver = at_barrel / BARREL.ratio - ratio * state.contact_moment
    scale = mine.torque / BARREL.ratio
    np.testing.assert_allclose(follower / scale, OWN.follower * state.phi_ddot / scale, atol=1e-9)
    np.testing.assert_allclose(driver / scale, OWN.driver * state.theta_ddot / scale, atol=1e-9)
