"""Laws that hold for every motion, and motions that have a closed formula."""

import numpy as np
from hypothesis import assume, example, given
from hypothesis import strategies as st

import escapement as esc
from escapement.base.status import Status
from random_drives import close, dense, drives, few, speeds, very_few


# one motion, however it is asked for
@few
@given(drives(), speeds, st.integers(1, 6))
def test_a_motion_goes_on_from_any_handoff(drive, speed, k):
    whole = esc.simulate(drive, 8, initial_speed=speed)
    rest = esc.simulate(drive, 8 - k, initial_speed=whole.handoff_velocities[k - 1])
    close(rest.handoff_velocities, whole.handoff_velocities[k:])
    close(rest.handoff_times + whole.handoff_times[k - 1], whole.handoff_times[k:])
    later = whole.reversals.engagement >= k
    cells = k * drive.mechanism.cell_angle
    close(rest.reversals.theta + cells, whole.reversals.theta[later], scale=1.0)


@few
@given(drives(), speeds, st.integers(1, 12))
def test_more_engagements_change_nothing_before(drive, speed, count):
    long, short = (esc.simulate(drive, n, initial_speed=speed) for n in (12, count))
    np.testing.assert_array_equal(short.handoff_times, long.handoff_times[:count])
    np.testing.assert_array_equal(short.handoff_velocities, long.handoff_velocities[:count])


@few
@given(drives(), speeds, st.floats(0.01, 1.0))
def test_a_duration_is_a_part_of_the_motion(drive, speed, part):
    whole = esc.simulate(drive, 4, initial_speed=speed)
    cut = esc.simulate(drive, duration=part * whole.end_time, initial_speed=speed)
    assert cut.end_time == part * whole.end_time
    done = whole.handoff_times <= cut.end_time
    np.testing.assert_array_equal(cut.handoff_times, whole.handoff_times[done])
    found, expected = dense(cut, 30), whole.at(np.linspace(0.0, cut.end_time, 30))
    close(found.theta, expected.theta, 1e-10, scale=1.0)
    close(found.theta_dot, expected.theta_dot, 1e-10, scale=whole.theta_dot.max())


@few
@given(drives(), speeds, st.permutations(range(12)))
def test_sample_times_are_only_looked_up(drive, speed, order):
    motion = esc.simulate(drive, 2, initial_speed=speed)
    times = np.linspace(0.0, motion.end_time, 12)
    state = motion.at(times)
    mixed = motion.at(times[list(order)].reshape(3, 4))
    for name in ("theta", "theta_dot", "phi_ddot", "contact_moment"):
        expected = getattr(state, name)[list(order)].reshape(3, 4)
        np.testing.assert_array_equal(getattr(mixed, name), expected)


@few
@given(drives(), speeds)
def test_states_and_events_tell_the_same_motion(drive, speed):
    motion = esc.simulate(drive, 3, initial_speed=speed)
    for events in (motion.reversals, motion.extrema):
        state = motion.at(events.time)
        close(state.theta, events.theta, 1e-10, scale=1.0)
        close(state.theta_dot, events.theta_dot, 1e-9)
    ends = motion.at(motion.handoff_times[:-1])
    cells = np.arange(1, 3) * drive.mechanism.cell_angle
    close(ends.theta, drive.mechanism.breaks[0] + cells, 1e-11)
    turned = (np.arange(1, 3) - 0.5) * drive.mechanism.follower_step
    close(ends.phi, turned, 1e-11)


@few
@given(drives(), speeds, st.sampled_from([1e-4, 1e-6, 1e-8, 1e-10]))
def test_a_looser_tolerance_stays_within_itself(drive, speed, rtol):
    best = esc.simulate(drive, 2, initial_speed=speed, rtol=1e-13)
    for engine, share in (("energy", 10.0), ("ivp", 50.0)):
        rough = esc.simulate(drive, 2, initial_speed=speed, rtol=rtol, engine=engine)
        close(rough.handoff_times, best.handoff_times, share * rtol)
        close(rough.handoff_velocities, best.handoff_velocities, share * rtol)


@very_few
@given(drives(most_slots=12, rho=(-1.5, 1.5)), speeds)
@example(
    esc.Escapement(esc.Geneva(5, 1), esc.Inertia(1.0, 1.0), 1.0), 10.0
)  # least at the very end
@example(  # at a start with great friction dt/dx is rougher than E
    esc.Escapement(
        esc.Geneva(12), esc.Inertia(10.0, 1.0), 1.0, friction=165.7, load_torque=0.01613
    ),
    0.0,
)
def test_both_engines_agree(drive, speed):
    fast, judge = (
        esc.simulate(drive, 2, initial_speed=speed, engine=e, rtol=1e-10) for e in ("energy", "ivp")
    )
    close(fast.handoff_times, judge.handoff_times, 1e-9)
    close(fast.handoff_velocities, judge.handoff_velocities, 1e-9)
    assert fast.extrema.maximum.tolist() == judge.extrema.maximum.tolist()
    close(fast.reversals.theta, judge.reversals.theta, 1e-8, scale=1.0)
    times = 0.9 * judge.end_time * np.linspace(0.0, 1.0, 9)
    found, expected = fast.at(times).theta_dot, judge.at(times).theta_dot
    close(found, expected, 1e-8, scale=expected.max())


# closed forms
@few
@given(drives(share=(0.0, 0.0)), speeds)
def test_without_friction_the_energy_is_the_work(drive, speed):
    motion = esc.simulate(drive, 3, initial_speed=speed)
    state, rho = dense(motion), drive.inertia.driver
    energy = 0.5 * (rho * state.theta_dot**2 + state.phi_dot**2)
    work = state.theta - state.theta[0] - drive.load_torque * (state.phi - state.phi[0])
    close(energy, 0.5 * rho * speed**2 + work, scale=energy.max())
    np.testing.assert_array_equal(motion.trajectory.losses, 0.0)
    assert esc.terminal(drive).status is Status.NO_TERMINAL


@few
@given(drives(internal=False), speeds)
def test_a_dwell_is_free_fall(drive, speed):
    assume(drive.mechanism.motion_ratio < 0.999)
    motion = esc.simulate(drive, 2, initial_speed=speed)
    locked = np.nonzero(motion.trajectory.sign == 0.0)[0]
    assert locked.size == 2
    start, end = motion.trajectory.start[locked[0]], motion.handoff_times[0]
    state = motion.within(locked[0], np.linspace(start, end, 9))
    free = drive.mechanism.cell_angle - drive.mechanism.engagement_angle
    gained = state.theta_dot[-1] ** 2 - state.theta_dot[0] ** 2
    close(gained, 2.0 * free / drive.inertia.driver, 1e-10, scale=state.theta_dot[-1] ** 2)
    close(state.theta_ddot, 1.0 / drive.inertia.driver)
    assert np.ptp(state.phi) == 0.0
    np.testing.assert_array_equal([state.phi_dot, state.phi_ddot, state.contact_moment], 0.0)
