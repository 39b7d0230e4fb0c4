"""Laws that hold for every terminal cycle, and for energy on the way to it."""

import math

import numpy as np
import pytest
from hypothesis import given

import escapement as esc
from random_drives import close, drives, few, speeds


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
