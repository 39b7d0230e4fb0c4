"""Laws that hold for every drive: units, scales, more of something, energy, terminal cycles."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import escapement as esc
from random_drives import close, drives, factors, few, settling, speeds


# scaling
@few
@given(drives(), speeds, factors, factors)
def test_times_go_as_the_root_of_inertia_over_torque(drive, speed, heavier, stronger):
    """Equal factors are another unit of force and mass, which changes no time."""
    inertia = esc.Inertia(heavier * drive.inertia.driver, heavier)
    load = stronger * drive.load_torque
    changed = replace(drive, inertia=inertia, torque=stronger, load_torque=load)
    slower = math.sqrt(heavier / stronger)
    one = esc.simulate(drive, 4, initial_speed=speed)
    other = esc.simulate(changed, 4, initial_speed=speed / slower)
    close(other.handoff_times, one.handoff_times * slower)
    close(other.handoff_velocities, one.handoff_velocities / slower)
    close(other.reversals.theta, one.reversals.theta, scale=1.0)
    work = stronger * one.ledger.work
    close(other.ledger.friction, stronger * one.ledger.friction, scale=work)


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


# energy
@few
@given(drives(), speeds)
def test_the_ledger_closes(drive, speed):
    motion = esc.simulate(drive, 5, initial_speed=speed)
    ledger = motion.ledger
    assert abs(ledger.residual) <= 1e-11
    assert ledger.friction >= 0.0
    assert np.all(motion.trajectory.losses >= 0.0)
    close(ledger.work, 5 * drive.mechanism.cell_angle)
    close(ledger.load, 5 * drive.mechanism.follower_step * drive.load_torque, scale=1e-300)


# terminal cycle
@few
@given(drives(share=(0.05, 0.97)))
def test_the_terminal_cycle_is_a_fixed_point_and_loses_all_work(drive):
    figures = esc.terminal(drive)
    cycle = esc.simulate(drive, 1, initial_speed=figures.handoff_velocity)
    close(cycle.handoff_velocities[0], figures.handoff_velocity)
    close(cycle.end_time, figures.period)
    close(figures.velocity_mean * figures.period, drive.mechanism.cell_angle)
    assert figures.velocity_min <= figures.velocity_mean <= figures.velocity_max
    turns = cycle.reversals.theta
    close(figures.reversal_angles, turns, 1e-9, scale=1.0)
    ledger = cycle.ledger
    close(ledger.friction + ledger.load, ledger.work)
    assert abs(ledger.kinetic) <= 1e-11 * max(ledger.work, drive.inertia.driver)
    assert abs(figures.energy_residual) <= 1e-11


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


@few
@given(settling, factors)
def test_accelerations_and_contact_moments_go_as_torque(drive, factor):
    one, other = esc.terminal(drive), esc.terminal(replace(drive, torque=factor))
    for name in ("acceleration_max", "follower_acceleration_max", "contact_moment_max"):
        close(getattr(other, name), factor * getattr(one, name), 1e-9)
    close(other.velocity_min, one.velocity_min * math.sqrt(factor))
    close(other.rise_time, one.rise_time / math.sqrt(factor))
    close(other.contraction, one.contraction, scale=1.0)
