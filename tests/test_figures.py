"""Figures of merit by their definitions, and the cycle that they belong to."""

from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from both_engines import each_engine
from escapement.base.status import Status
from escapement.dynamics import figures_of_merit as metrics
from random_drives import drive

BOTH = ("energy", "ivp")
NO_TERMINAL = Status.NO_TERMINAL


def test_terminal_figures_keep_the_tolerance_where_little_is_lost():
    """An engagement that hardly contracts magnifies the error of the map it is the root of."""
    scene = drive(rho=1.0, mu=1e-4)
    cycles = (esc.terminal(scene, engine=engine, rtol=1e-10) for engine in BOTH)
    fast, judge = ([cycle.velocity_max, cycle.period] for cycle in cycles)
    assert judge == pytest.approx(fast, rel=1e-9)


@pytest.mark.parametrize(
    ("mu", "load", "speed", "engines"), [(0.1, 0.76, 5.0, BOTH), (0.02, 0.94, 50.0, BOTH[:1])]
)
def test_the_search_for_a_cycle_does_not_stall_on_its_way(mu, load, speed, engines):
    scene = drive(rho=0.1, mu=mu, load=load)
    assert esc.simulate(scene, 200, initial_speed=speed).status is Status.OK
    for engine in engines:
        figures = esc.terminal(scene, engine=engine, initial_speed=speed, rtol=1e-6)
        assert figures.status is Status.OK


@each_engine
def test_a_stall_on_the_way_to_the_cycle_is_told_as_it_happens(engine):
    scene = drive(rho=1.0, mu=0.1, load=1.5)
    motion = esc.simulate(scene, 40, initial_speed=100.0)
    assert motion.status is Status.STALL
    assert esc.terminal(scene, engine=engine, initial_speed=100.0).message == motion.message
    # without friction a load may still stop the start, and nothing stops a fast one
    scene = drive(rho=1.0, mu=0.0, load=0.9)
    for speed, moves, ends in ((0.0, Status.STALL, Status.STALL), (5.0, Status.OK, NO_TERMINAL)):
        assert esc.simulate(scene, 50, engine=engine, initial_speed=speed).status is moves
        assert esc.terminal(scene, engine=engine, initial_speed=speed).status is ends


@pytest.mark.parametrize(
    ("slots", "pins", "ratio", "friction", "load", "speed"),
    [(22, 1, 8.95, 0.0921, 20.1, 397.0), (17, 2, 147.0, 0.659, 4.975, 0.76)],
)
def test_a_load_that_turns_the_pin_twice_between_points(slots, pins, ratio, friction, load, speed):
    """The cycle is found, and is one: an engagement gives back the speed it began with."""
    timer = drive(slots, pins, ratio, friction, load)
    figures = esc.terminal(timer, initial_speed=speed)
    assert figures.status is Status.OK
    assert len(figures.reversal_angles) == 2
    start = figures.handoff_velocity
    motion = esc.simulate(timer, engagements=1, initial_speed=start, engine="ivp")
    assert motion.handoff_velocities[0] == pytest.approx(start, rel=1e-9)


@pytest.mark.parametrize("engine", BOTH)
def test_peaks_are_looked_for_once_and_only_when_asked_for(engine, monkeypatch):
    """Speeds and times need no peaks of any motion; all peaks are found together."""
    looked, find = [], metrics.find_peaks
    monkeypatch.setattr(metrics, "find_peaks", lambda motion: looked.append(motion) or find(motion))
    figures = esc.terminal(drive(mu=0.3), engine=engine)
    assert figures.rise_time > 0.0
    assert not looked
    assert figures.acceleration_max > 0.0
    assert figures.follower_acceleration_max > 0.0
    assert looked == [figures.motion]


def test_terminal_motion_is_the_engagement_that_repeats_itself():
    """What the figures are read from is at hand; there is none without a terminal cycle."""
    figures = esc.terminal(drive(mu=0.3))
    (period,) = esc.sweep(drive(), friction=[0.3]).results["period"]  # by the engine's batch
    assert figures.motion.end_time == pytest.approx(period, rel=1e-11)
    (end,) = figures.motion.handoff_velocities
    assert end == pytest.approx(figures.handoff_velocity, rel=1e-11)
    for load in np.linspace(0.0, 0.3, 40):
        figures = esc.terminal(drive(mu=0.3, load=load))
        assert figures.motion.at(figures.period).theta_dot > 0.0  # not a digit beyond its end
    assert figures != replace(figures, motion=None)  # the peaks are another's
    none = esc.terminal(drive(mu=0.0))
    assert none.motion is None
    assert np.isnan(none.acceleration_max)
    assert np.isnan(none.energy_residual)
    assert none.reversal_angles == ()
