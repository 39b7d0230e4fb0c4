"""Laws that hold for every wheel, inertia, friction, load and speed, drawn at random.

Natural units throughout: the follower's inertia and the torque are 1 unless a property varies
them, so the driver's inertia is rho and the load torque the load ratio.
"""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

import escapement as esc
from escapement.dynamics import acceleration, critical_angle
from escapement.status import Status

# the first drive drawn compiles the kernels
slow_to_draw = [HealthCheck.too_slow, HealthCheck.filter_too_much]
few = settings(deadline=None, max_examples=30, suppress_health_check=slow_to_draw)
very_few = settings(few, max_examples=8)


@st.composite
def wheels(draw, most_slots=40, internal=None, crank_radius=None):
    inside = draw(st.booleans()) if internal is None else internal
    n = draw(st.integers(3, most_slots))
    pins = draw(st.integers(1, 1 if inside else 2 * n // (n - 2)))
    return esc.Geneva(n, pins, inside, crank_radius)


def bearable(wheel, mu):
    """Load ratio up to which no engagement can stop: p_+ M_f < tau everywhere."""
    found = wheel.transmission(np.linspace(*wheel.breaks[::2], 801))
    return 0.99 / float((found.g + mu * np.abs(found.u)).max())


@st.composite
def drives(draw, share=(0.0, 0.97), load=True, rho=(-2.0, 2.0), **wheel):
    """An escapement that never stalls; `share` bounds friction over the Painleve limit."""
    mechanism = draw(wheels(**wheel))
    inertia = esc.Inertia(10.0 ** draw(st.floats(*rho)), 1.0)
    mu = draw(st.floats(*share)) * esc.critical_friction(mechanism, inertia)
    carried = draw(st.floats(0.0, 0.8)) * bearable(mechanism, mu) if load else 0.0
    return esc.Escapement(mechanism, inertia, 1.0, mu, carried)


speeds = st.one_of(st.just(0.0), st.floats(-1.0, 3.0).map(lambda x: 10.0**x))
settling = drives(share=(0.05, 0.97), load=False)  # has a terminal cycle within reach
factors = st.floats(-3.0, 3.0).map(lambda x: 10.0**x)


def close(found, expected, rtol=1e-11, scale=0.0):
    np.testing.assert_allclose(found, expected, rtol=rtol, atol=rtol * scale)


def dense(motion, count=400):
    return motion.at(np.linspace(0.0, motion.end_time, count))


def contacts(motion, count=12):
    """Side of the slot, transmission and state at points inside each piece in contact."""
    ends = [*motion.trajectory.start[1:], motion.end_time]
    cell = motion.escapement.mechanism.cell_angle
    for piece, (start, end) in enumerate(zip(motion.trajectory.start, ends, strict=True)):
        sign = motion.trajectory.sign[piece]
        if sign == 0.0 or end - start <= 1e-9 * motion.end_time:
            continue
        state = motion.within(piece, start + (end - start) * np.linspace(0.01, 0.99, count))
        local = state.theta - motion.trajectory.engagement[piece] * cell
        yield sign, motion.escapement.mechanism.transmission(local), state


# scaling


@few
@given(drives(load=False), speeds, factors)
def test_speeds_go_as_the_root_of_torque(drive, speed, factor):
    one = esc.simulate(drive, 4, initial_speed=speed)
    faster = speed * math.sqrt(factor)
    other = esc.simulate(replace(drive, torque=factor), 4, initial_speed=faster)
    close(other.handoff_velocities, one.handoff_velocities * math.sqrt(factor))
    close(other.handoff_times, one.handoff_times / math.sqrt(factor))
    close(other.reversals.theta, one.reversals.theta, scale=1.0)


@few
@given(settling, factors)
def test_accelerations_and_contact_moments_go_as_torque(drive, factor):
    one, other = esc.terminal(drive), esc.terminal(replace(drive, torque=factor))
    for name in ("acceleration_max", "follower_acceleration_max", "contact_moment_max"):
        close(getattr(other, name), factor * getattr(one, name), 1e-9)
    close(other.velocity_min, one.velocity_min * math.sqrt(factor))
    close(other.rise_time, one.rise_time / math.sqrt(factor))
    close(other.contraction, one.contraction, scale=1.0)


@few
@given(drives(), speeds, factors)
def test_times_go_as_the_root_of_both_inertias(drive, speed, factor):
    one = esc.simulate(drive, 4, initial_speed=speed)
    heavy = replace(drive, inertia=esc.Inertia(factor * drive.inertia.driver, factor))
    other = esc.simulate(heavy, 4, initial_speed=speed / math.sqrt(factor))
    close(other.handoff_times, one.handoff_times * math.sqrt(factor))


@few
@given(drives(), speeds, factors)
def test_units_of_force_and_mass_do_not_matter(drive, speed, factor):
    inertia = esc.Inertia(factor * drive.inertia.driver, factor)
    other = esc.Escapement(
        drive.mechanism, inertia, factor, drive.friction, factor * drive.load_torque
    )
    one, other = (esc.simulate(scene, 4, initial_speed=speed) for scene in (drive, other))
    close(other.handoff_times, one.handoff_times)
    close(other.ledger.friction, factor * one.ledger.friction, scale=factor * one.ledger.work)


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
    best, rough = (esc.simulate(drive, 4, initial_speed=speed, rtol=r) for r in (1e-13, rtol))
    close(rough.handoff_times, best.handoff_times, 10.0 * rtol)
    close(rough.handoff_velocities, best.handoff_velocities, 10.0 * rtol)


@very_few
@given(drives(most_slots=12, rho=(-1.5, 1.5)), speeds)
@example(
    esc.Escapement(esc.Geneva(5, 1), esc.Inertia(1.0, 1.0), 1.0), 10.0
)  # least at the very end
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


# monotony


@few
@given(settling, st.floats(0.05, 0.97))
def test_more_friction_is_slower_in_every_way(drive, share):
    more = share * esc.critical_friction(drive.mechanism, drive.inertia)
    assume(more > 1.001 * drive.friction)
    low, high = esc.terminal(drive), esc.terminal(replace(drive, friction=more))
    for name in ("velocity_max", "velocity_min", "velocity_mean", "handoff_velocity"):
        assert getattr(high, name) < getattr(low, name)
    assert high.period > low.period
    assert high.contraction < low.contraction


@few
@given(drives(share=(0.05, 0.97)), st.floats(1.001, 10.0))
def test_more_torque_is_faster_under_any_load(drive, factor):
    weak, strong = esc.terminal(drive), esc.terminal(replace(drive, torque=factor))
    assert strong.velocity_mean > weak.velocity_mean
    assert strong.period < weak.period


@few
@given(drives(share=(0.05, 0.97), most_slots=12, internal=False), st.floats(0.0, 0.9))
def test_a_load_slows_a_drive_of_ordinary_friction(drive, part):
    """Not every drive: where mu |u| > g in the second half, a load brakes less than it relieves."""
    drive = replace(drive, friction=min(drive.friction, 0.35))
    assume(drive.load_torque > 1e-3)
    lighter = replace(drive, load_torque=part * drive.load_torque)
    loaded, easy = esc.terminal(drive), esc.terminal(lighter)
    assert loaded.velocity_mean < easy.velocity_mean
    assert loaded.period > easy.period


@few
@given(drives(), speeds, st.floats(1.001, 10.0))
def test_motions_do_not_cross(drive, speed, factor):
    slow = esc.simulate(drive, 4, initial_speed=speed)
    fast = esc.simulate(drive, 4, initial_speed=speed * factor + 0.1)
    assert np.all(fast.handoff_velocities >= slow.handoff_velocities * (1.0 - 1e-11))
    assert np.all(fast.handoff_times < slow.handoff_times)


# closed forms


@few
@given(drives(share=(0.0, 0.0)), speeds)
def test_without_friction_the_energy_is_the_work(drive, speed):
    motion = esc.simulate(drive, 3, initial_speed=speed)
    state, rho = dense(motion), drive.inertia.driver
    energy = 0.5 * (rho * state.theta_dot**2 + state.phi_dot**2)
    work = state.theta - state.theta[0] - drive.load_torque * (state.phi - state.phi[0])
    close(energy, 0.5 * rho * speed**2 + work, scale=energy.max())
    np.testing.assert_array_equal(motion.trajectory.friction_loss, 0.0)
    assert esc.terminal(drive).status is Status.NO_TERMINAL


@few
@given(wheels(), st.floats(-2.0, 2.0), st.floats(0.0, 1.0), st.floats(0.0, 10.0))
def test_without_friction_both_halves_are_mirror_images(wheel, exponent, place, w):
    theta, rho = place * wheel.breaks[-1], 10.0**exponent
    left, right = wheel.transmission(-theta), wheel.transmission(theta)
    assert (float(left.g), float(left.u)) == (float(right.g), -float(right.u))
    assert float(left.dg) == -float(right.dg)
    a = [
        acceleration(float(x.g), float(x.u), float(x.dg), w, 1.0, rho, (0.0, 0.0), 0.0)
        for x in (left, right)
    ]
    reduced = rho + right.g**2
    close(0.5 * (a[0] + a[1]), 1.0 / reduced, scale=abs(a[0]))
    close(0.5 * (a[0] - a[1]), right.g * right.dg * w / reduced, scale=abs(a[0]))


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


@few
@given(wheels(most_slots=1000), st.floats(-1.0, 1.0))
def test_transmission_runs_on_a_circle(wheel, place):
    found = wheel.transmission(place * wheel.breaks[-1])
    a = wheel.centre_distance
    ends = (1 / (a + 1), -1 / (a - 1)) if wheel.internal else (1 / (a - 1), -1 / (a + 1))
    product = (ends[0] - found.g) * (found.g - ends[1])
    close(found.u**2, product, 1e-9, scale=(ends[0] - ends[1]) ** 2)


# contact


@few
@given(drives(), speeds)
def test_both_members_obey_newton(drive, speed):
    """Follower: N R - M_f = I_f phi_ddot; driver: tau - I_d theta_ddot = p_s N R."""
    motion = esc.simulate(drive, 2, initial_speed=speed)
    for sign, found, state in contacts(motion):
        p = found.g + sign * drive.friction * np.abs(found.u)
        scale = np.abs(state.contact_moment).max() * (1.0 + np.abs(p).max())
        follower = state.phi_ddot + drive.load_torque
        close(follower, state.contact_moment, 1e-9, scale)
        drawn = 1.0 - drive.inertia.driver * state.theta_ddot
        close(drawn, p * state.contact_moment, 1e-9, scale + 1.0)


@few
@given(drives(), speeds)
def test_force_is_carried_by_the_side_it_is_said_to_be(drive, speed):
    motion = esc.simulate(drive, 3, initial_speed=speed)
    largest = np.abs(motion.contact_moment).max()
    for sign, _, state in contacts(motion):
        assert np.all(sign * state.contact_moment >= -1e-9 * largest)


@few
@given(drives(), speeds)
def test_a_reversal_lies_on_its_locus(drive, speed):
    """Within 1e-8 of a radian of where rho (g' w + load) + g vanishes; there the driver is free."""
    motion = esc.simulate(drive, 3, initial_speed=speed)
    turns, rho = motion.reversals, drive.inertia.driver
    angle = turns.theta - turns.engagement * drive.mechanism.cell_angle
    found, w = drive.mechanism.transmission(angle), turns.theta_dot**2
    beside = [drive.mechanism.transmission(angle + h).dg for h in (-1e-5, 1e-5)]
    slope = rho * w * (beside[1] - beside[0]) / 2e-5 + 3.0 * found.dg  # w' = 2/rho
    nothing = rho * (found.dg * w + drive.load_torque) + found.g
    terms = found.g + rho * (np.abs(found.dg) * w + drive.load_torque)
    assert np.all(np.abs(nothing) <= 1e-8 * np.abs(slope) + 1e-12 * terms)
    close(motion.at(turns.time).theta_ddot * rho, np.ones(turns.time.size), 1e-6)


@few
@given(drives(load=False), speeds)
def test_without_a_load_the_force_turns_once_after_dead_centre(drive, speed):
    motion = esc.simulate(drive, 4, initial_speed=speed)
    assert motion.reversals.engagement.tolist() == [0, 1, 2, 3]
    place = motion.reversals.theta - np.arange(4) * drive.mechanism.cell_angle
    assert np.all((place > 0.0) & (place < drive.mechanism.breaks[-1]))


@few
@given(drives(), speeds)
def test_extrema_alternate_and_nothing_goes_beyond_them(drive, speed):
    motion = esc.simulate(drive, 3, initial_speed=speed)
    extrema = motion.extrema
    assert np.all(extrema.maximum[1:] != extrema.maximum[:-1])
    assert np.all(np.diff(extrema.time) > 0.0)
    marks = np.concatenate([[0.0], extrema.time, [motion.end_time]])
    for start, end in pairwise(marks):
        between = np.diff(motion.at(np.linspace(start, end, 40)).theta_dot)
        slack = 1e-11 * motion.theta_dot.max()
        assert np.all(between >= -slack) or np.all(between <= slack)


@few
@given(drives(), speeds)
def test_nothing_turns_backwards(drive, speed):
    state = dense(esc.simulate(drive, 3, initial_speed=speed))
    assert np.all(np.diff(state.theta) > 0.0)
    assert np.all(np.diff(state.phi) >= -1e-15)
    assert np.all(state.phi_dot >= -1e-12 * state.theta_dot.max())


# energy


@few
@given(drives(), speeds)
def test_the_ledger_closes(drive, speed):
    motion = esc.simulate(drive, 5, initial_speed=speed)
    ledger = motion.ledger
    assert abs(ledger.residual) <= 1e-11
    assert ledger.friction >= 0.0
    assert np.all(motion.trajectory.friction_loss >= 0.0)
    close(ledger.work, 5 * drive.mechanism.cell_angle)
    close(ledger.load, 5 * drive.mechanism.follower_step * drive.load_torque, scale=1e-300)


@few
@given(drives(share=(0.05, 0.97)))
def test_in_the_terminal_cycle_all_work_is_lost(drive):
    figures = esc.terminal(drive)
    ledger = esc.simulate(drive, 1, initial_speed=figures.handoff_velocity).ledger
    close(ledger.friction + ledger.load, ledger.work)
    assert abs(ledger.kinetic) <= 1e-11 * max(ledger.work, drive.inertia.driver)
    assert abs(figures.energy_residual) <= 1e-11


# terminal cycle


@few
@given(drives(share=(0.05, 0.97)))
def test_the_terminal_cycle_is_a_fixed_point(drive):
    figures = esc.terminal(drive)
    cycle = esc.simulate(drive, 1, initial_speed=figures.handoff_velocity)
    close(cycle.handoff_velocities[0], figures.handoff_velocity)
    close(cycle.end_time, figures.period)
    close(figures.velocity_mean * figures.period, drive.mechanism.cell_angle)
    assert figures.velocity_min <= figures.velocity_mean <= figures.velocity_max
    turns = cycle.reversals.theta
    close(figures.reversal_angles, turns, 1e-9, scale=1.0)


@few
@given(drives(share=(0.05, 0.97)), speeds)
def test_the_terminal_cycle_does_not_depend_on_the_start(drive, speed):
    one, other = esc.terminal(drive), esc.terminal(drive, initial_speed=speed)
    for name in ("velocity_max", "velocity_min", "period", "handoff_velocity"):
        close(getattr(other, name), getattr(one, name))


@few
@given(drives(share=(0.02, 0.6)))
def test_contraction_is_what_a_small_deviation_shrinks_by(drive):
    figures = esc.terminal(drive)
    w, step = figures.handoff_velocity**2, 1e-3
    ends = [
        esc.simulate(drive, 1, initial_speed=math.sqrt(w * (1.0 + s))).handoff_velocities[0]
        for s in (-step, step)
    ]
    measured = (ends[1] ** 2 - ends[0] ** 2) / (2.0 * step * w)
    assert measured == pytest.approx(figures.contraction, rel=1e-3, abs=1e-6)


# the Painleve limit


@few
@given(wheels(), st.floats(-6.0, 6.0), st.floats(1.0, 3.0), st.floats(0.0, 1e3))
def test_at_the_limit_and_beyond_nothing_is_integrated(wheel, exponent, factor, load):
    inertia = esc.Inertia(10.0**exponent, 1.0)
    mu = factor * esc.critical_friction(wheel, inertia)
    drive = esc.Escapement(wheel, inertia, 1.0, mu, load)
    outcomes = [esc.simulate(drive, engine=engine) for engine in ("energy", "ivp")]
    for outcome in [*outcomes, esc.terminal(drive), esc.terminal(drive, engine="ivp")]:
        assert outcome.status is Status.PAINLEVE
        assert f"{esc.critical_friction(wheel, inertia):.6g}" in outcome.message


@few
@given(wheels(), st.floats(-6.0, 6.0), st.floats(1.0, 3.0))
def test_the_limit_is_met_where_it_is_said_to_be(wheel, exponent, factor):
    rho = 10.0**exponent
    mu = factor * esc.critical_friction(wheel, esc.Inertia(rho, 1.0))
    angle = critical_angle(wheel, esc.Inertia(rho, 1.0), mu)
    found = wheel.transmission(angle)
    reduced = rho + found.g**2 - mu * abs(found.g * found.u)
    assert abs(reduced) <= 1e-7 * (rho + found.g**2)
    before = wheel.transmission(angle - (angle - wheel.breaks[0]) * np.linspace(1e-6, 1.0, 500))
    assert np.all(rho + before.g**2 - mu * np.abs(before.g * before.u) > 0.0)
    assert math.isnan(critical_angle(wheel, esc.Inertia(rho, 1.0), 0.999 * mu / factor))
