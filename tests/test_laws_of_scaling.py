"""Laws that hold for every drive: units, scales, and what is more of something."""

import math
from dataclasses import replace

import numpy as np
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


@few
@given(settling, factors)
def test_accelerations_and_contact_moments_go_as_torque(drive, factor):
    one, other = esc.terminal(drive), esc.terminal(replace(drive, torque=factor))
    for name in ("acceleration_max", "follower_acceleration_max", "contact_moment_max"):
        close(getattr(other, name), factor * getattr(one, name), 1e-9)
    close(other.velocity_min, one.velocity_min * math.sqrt(factor))
    close(other.rise_time, one.rise_time / math.sqrt(factor))
    close(other.contraction, one.contraction, scale=1.0)


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
