"""Difficult simulations: events close together, extreme numbers, long runs and stops.

Units are natural ones throughout: follower inertia and torque are 1, so that the inertia
ratio is the driver's inertia and the load ratio the load torque.
"""

import math

import numpy as np
import pytest

import escapement as esc
from escapement.base.status import Status
from escapement.dynamics.painleve import critical_friction
from random_drives import drive

BOTH = ("energy", "ivp")


def limit(slots=4, pins=None, *, rho=0.06, internal=False):
    model = drive(slots, pins, rho=rho, internal=internal)
    return critical_friction(model.mechanism, model.inertia)


def run(model, engine="energy", *, engagements=3, rtol=None, speed=0.0):
    if rtol is None:
        rtol = 1e-12 if engine == "energy" else 1e-10
    return esc.simulate(model, engagements, engine=engine, rtol=rtol, initial_speed=speed)


def numbers(motion):
    """Handoff times and speeds and, of a motion that stops, when."""
    end = [motion.end_time] if motion.status is Status.STALL else []
    return np.concatenate([motion.handoff_times, motion.handoff_velocities, end])


def turns(motion):
    """Pin reversals per engagement completed."""
    count = motion.handoff_times.size
    return [int(np.sum(motion.reversals.engagement == k)) for k in range(count)]


def both(model, **options):
    """The motion by the fast engine and by the reference engine."""
    return [run(model, name, **options) for name in BOTH]


def assert_same(model, *, tolerance=1e-9, speed=0.0, engagements=3):
    """Both engines tell the same story to within a tolerance; returns theirs."""
    fast, judge = both(model, speed=speed, engagements=engagements)
    assert fast.status is judge.status, (fast.message, judge.message)
    assert turns(fast) == turns(judge)
    np.testing.assert_allclose(numbers(fast), numbers(judge), rtol=tolerance)
    return fast, judge


def assert_repeats(model):
    """The terminal cycle is an engagement that gives back its speed; returns figures, motion."""
    figures = esc.terminal(model)
    assert figures.status is Status.OK
    again = run(model, engagements=1, speed=figures.handoff_velocity)
    assert again.handoff_velocities[0] == pytest.approx(figures.handoff_velocity, rel=1e-11)
    return figures, again


# close switches


def test_two_reversals_that_merge():
    """At the speed where the force just touches zero nothing jumps."""
    model = drive(3, 6, rho=400.0, mu=0.1, load=0.1)
    low, high = 0.01, 1.0
    while low < (middle := 0.5 * (low + high)) < high:
        none = turns(run(model, engagements=1, speed=middle)) == [0]
        low, high = (middle, high) if none else (low, middle)
    below, above = (run(model, engagements=1, speed=v) for v in (low, high))
    assert (turns(below), turns(above)) == ([0], [2])
    np.testing.assert_allclose(numbers(below), numbers(above), rtol=1e-12)
    for factor in (1.0 - 1e-6, 1.0 + 1e-6, 1.0 - 1e-12, 1.0 + 1e-12):
        fast, judge = both(model, engagements=1, speed=low * factor)
        np.testing.assert_allclose(numbers(fast), numbers(judge), rtol=1e-9)


@pytest.mark.parametrize("internal", [False, True])
@pytest.mark.parametrize("slots", [3, 5, 13, 1000])
def test_start_from_rest_is_a_start_on_the_reversal(slots, internal):
    """There the contact moment is zero but for the rounding error of pin entry."""
    friction = 0.3 * limit(slots, 1, rho=0.5, internal=internal)
    fast, _judge = assert_same(drive(slots, 1, rho=0.5, mu=friction, internal=internal))
    assert fast.status is Status.OK
    assert turns(fast) == [1, 1, 1]


@pytest.mark.parametrize(("slots", "pins", "rho"), [(4, 4, 0.06), (6, 3, 2.0)])
def test_stop_or_not_at_the_last_instant(slots, pins, rho):
    """Either side of the load at which the first engagement just comes through."""
    mu = 0.9 * limit(slots, pins, rho=rho)

    def under(load):
        return drive(slots, pins, rho=rho, mu=mu, load=load)

    low, high = 0.0, 100.0
    for _ in range(60):
        load = 0.5 * (low + high)
        stops = run(under(load), engagements=1).outcome is Status.STALL
        low, high = (low, load) if stops else (load, high)
    assert high - low <= 1e-13 * high
    assert run(under(low), engagements=1).outcome is Status.OK
    for factor in (0.999, 1.0 - 1e-6, 1.0 + 1e-6, 1.001):
        fast, judge = both(under(low * factor), engagements=1)
        assert fast.outcome is judge.outcome
        assert fast.end_time == pytest.approx(judge.end_time, rel=1e-7)


# extremes


EXTREMES = {
    "light driver": drive(rho=1e-8, mu=1e-5),
    "heavy driver": drive(rho=1e8),
    "no friction to speak of": drive(mu=1e-12),
    "1000 slots": drive(1000, 1, rho=0.06, mu=0.3),
    "1000 slots, internal": drive(1000, 1, rho=0.06, mu=0.3, internal=True),
}


@pytest.mark.parametrize("name", EXTREMES)
def test_extremes(name):
    for motion in assert_same(EXTREMES[name], tolerance=1e-8 if "light" in name else 1e-9):
        assert motion.status is Status.OK
        assert abs(motion.ledger.residual) <= 1e-11
    figures, again = assert_repeats(EXTREMES[name])
    assert figures.period == pytest.approx(again.end_time, rel=1e-10)


@pytest.mark.parametrize(("slots", "rho"), [(3, 0.6), (4, 0.06), (9, 1e-3)])
def test_just_below_the_painleve_limit(slots, rho):
    model = drive(slots, rho=rho, mu=0.999999 * limit(slots, rho=rho))
    fast, _judge = assert_same(model)
    assert fast.status is Status.OK
    rough = run(model, rtol=1e-6)
    np.testing.assert_allclose(numbers(rough), numbers(fast), rtol=1e-5)


# what the drive can carry


@pytest.mark.parametrize("engine", BOTH)
def test_a_drive_that_cannot_start(engine):
    """From rest, with friction at entry times load above the torque: no time passes."""
    motion = run(drive(11, 2, rho=3.0, mu=1.0, load=4.4), engine)
    assert motion.status is Status.STALL
    assert motion.end_time == 0.0
    assert float(motion.at(0.0).theta_dot) == 0.0
    assert motion.ledger.work == 0.0


# long runs


def test_a_million_engagements_do_not_drift_in_energy():
    """Without friction the speed at every handoff has a closed form."""
    motion = run(drive(rho=1.0, mu=0.0), engagements=1_000_000)
    work = np.arange(1, 1_000_001) * math.pi / 2.0
    np.testing.assert_allclose(motion.handoff_velocities**2, 2.0 * work, rtol=2e-13)


@pytest.mark.slow
def test_a_million_engagements_do_not_drift_in_time():
    """They never settle, for the contraction is 1 - 4e-6; times of parts are added exactly."""
    million = run(drive(rho=1.0, mu=1e-6), engagements=1_000_000)
    speeds = np.concatenate([[0.0], million.handoff_velocities])
    pieces = []
    for k in range(0, 1_000_000, 1000):
        part = run(drive(rho=1.0, mu=1e-6), engagements=1000, speed=float(speeds[k]))
        pieces.append(float(part.handoff_times[-1]))
    assert million.handoff_times[-1] == pytest.approx(math.fsum(pieces), rel=1e-13)


@pytest.mark.parametrize("rtol", [1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize(
    ("model", "speed"),
    [
        (drive(29, 1, rho=1.9, mu=0.004, load=13.333), 0.0),
        (drive(34, 1, rho=0.016, mu=0.14, load=43.7, internal=True), 0.061),
        (drive(40, 1, rho=470.0, mu=6800.0, load=17.1), 0.0015),
        (drive(5, 1, rho=2.6, mu=3.5e-4, load=3.86), 0.0),
        (drive(16, 1, rho=420.0, mu=0.0039, load=12.66), 0.0),
    ],
)
def test_time_and_angle_of_a_stop(model, speed, rtol):
    found = run(model, rtol=rtol, speed=speed)
    exact = run(model, "ivp", rtol=1e-12, speed=speed)
    assert found.status is exact.status is Status.STALL
    assert found.end_time == pytest.approx(exact.end_time, rel=10.0 * rtol + 1e-11)
    ends = [float(motion.at(motion.end_time).theta) for motion in (found, exact)]
    assert ends[0] == pytest.approx(ends[1], abs=10.0 * rtol + 1e-10)


@pytest.mark.parametrize("share", [0.5, 0.999, 1.0, 1.001, 10.0, 1e6])
@pytest.mark.parametrize(
    ("slots", "pins", "mu", "internal"),
    [(4, 4, 0.0, 0), (4, 4, 0.3, 0), (3, 2, 0.2, 0), (7, 1, 0.1, 0), (5, 1, 0.2, 1)],
)
def test_load_at_and_above_what_the_drive_can_carry(slots, pins, mu, internal, share):
    """The work of the load over a cell against that of the drive."""
    internal = bool(internal)
    bare = drive(slots, pins, mu=mu, internal=internal).mechanism
    load = share * bare.cell_angle / bare.follower_step
    model = drive(slots, pins, mu=mu, load=load, internal=internal, rho=0.5)
    fast, judge = both(model, engagements=6, speed=2.0)
    assert fast.status is judge.status
    np.testing.assert_allclose(numbers(fast), numbers(judge), rtol=1e-7)
    if share > 1.001:
        assert fast.status is Status.STALL
    if fast.status is Status.STALL:
        ends = [float(motion.at(motion.end_time).theta) for motion in (fast, judge)]
        assert ends[0] == pytest.approx(ends[1], abs=1e-8)
        for engine, motion in zip(BOTH, (fast, judge), strict=True):
            assert "stalls" in motion.message
            assert "degrees from dead centre" in motion.message
            if share <= 10.0:  # a greater load stops the driver within the error of its time
                assert motion.at(motion.end_time).theta_dot == pytest.approx(0.0, abs=4e-5)
            assert esc.terminal(model, engine=engine, initial_speed=2.0).status is Status.STALL


@pytest.mark.parametrize("speed", [1e-300, 1e-30, 1e-8, 1e-4, 1e-2])
@pytest.mark.parametrize("model", [drive(), drive(20, 2, rho=0.01, mu=0.5), drive(5, 3, rho=40.0)])
def test_start_from_almost_rest(model, speed):
    judge = run(model, "ivp", speed=speed, rtol=1e-12)
    assert (judge.status, turns(judge)) == (Status.OK, turns(run(model, speed=speed)))
    exact = numbers(judge)
    for rtol in (1e-4, 1e-8, 1e-12):
        found = run(model, rtol=rtol, speed=speed)
        allowed = 10.0 * rtol + 1e-11
        np.testing.assert_allclose(numbers(found), exact, rtol=allowed)
