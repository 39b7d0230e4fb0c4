"""Engines against motions computed in 40-digit arithmetic (``reference/generate.py``)."""

import json
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import escapement as esc
from escapement.engines.time import terminal

CASES = json.loads(
    Path(__file__).with_name("reference").joinpath("motions.json").read_text(encoding="utf-8")
)


class Engine(NamedTuple):
    """Name, tolerance asked for, relative error allowed, absolute error of the contraction."""

    name: str
    rtol: float
    allowed: float
    contraction: float


# ivp takes the contraction from a difference quotient over 2e-4 of w, at an rtol of 1e-10.
ENGINES = [Engine("energy", 1e-12, 1e-11, 1e-9), Engine("ivp", 1e-10, 1e-9, 1e-5)]

each_engine = pytest.mark.parametrize("engine", ENGINES, ids=lambda engine: engine.name)
each_case = pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
with_cycle = pytest.mark.parametrize(
    "case", [case for case in CASES if case["terminal"]], ids=lambda case: case["name"]
)


def numbers(strings):
    return np.array([float(x) for x in strings])


def model(case):
    return esc.Escapement(
        mechanism=esc.Geneva(slots=case["slots"], pins=case["pins"], internal=case["internal"]),
        inertia=esc.Inertia(driver=case["driver_inertia"], follower=case["follower_inertia"]),
        friction=case["friction"],
        torque=case["torque"],
        load_torque=case["load_torque"],
    )


@cache
def simulated(name, engine):
    """One motion serves all the tests of a case."""
    case = next(case for case in CASES if case["name"] == name)
    return esc.simulate(
        model(case),
        engagements=case["engagements"],
        engine=engine.name,
        initial_speed=case["initial_speed"],
        rtol=engine.rtol,
    )


def cumulative(case, events):
    """Driver angle from the first dead centre: local angle + engagement * cell."""
    return numbers(events["angle"]) + np.array(events["engagement"]) * 2 * np.pi / case["pins"]


def test_reference_is_far_more_accurate_than_a_double():
    assert all(float(case["error"]) <= 1e-16 for case in CASES)


def test_reference_contains_the_published_check_value():
    """Four pins, mu = 0.35, 0.10 in-lbf: 20th handoff as two other derivations have it."""
    (case,) = [case for case in CASES if case["name"] == "meyer four pins"]
    assert abs(float(case["handoff_times"][-1]) - 0.881247098654620) < 2e-15
    assert abs(float(case["handoff_velocities"][-1]) - 74.6834608876848) < 1e-13


def test_reference_sees_none_one_and_two_reversals():
    counts = {case["reversals"]["engagement"].count(k) for case in CASES for k in range(20)}
    (case,) = [case for case in CASES if case["name"] == "load on a heavy driver"]
    assert {0, 1, 2} == counts
    assert case["reversals"]["engagement"].count(0) == 0


@each_engine
@each_case
def test_handoffs_reversals_and_extrema(case, engine):
    motion, close = simulated(case["name"], engine), engine.allowed
    times, speeds = numbers(case["handoff_times"]), numbers(case["handoff_velocities"])
    np.testing.assert_allclose(motion.handoff_times, times, rtol=close)
    np.testing.assert_allclose(motion.handoff_velocities, speeds, rtol=close)
    found, expected = motion.reversals, case["reversals"]
    assert len(found.time) == len(expected["time"])
    np.testing.assert_allclose(found.time, numbers(expected["time"]), rtol=close)
    np.testing.assert_allclose(found.theta, cumulative(case, expected), atol=close)
    found, expected = motion.extrema, case["extrema"]
    # Start and end of the run are corners only by convention.
    inner = (found.time > 0) & (found.time < motion.handoff_times[-1] * (1 - 1e-9))
    assert list(found.maximum[inner]) == expected["maximum"]
    np.testing.assert_allclose(found.time[inner], numbers(expected["time"]), rtol=close)
    np.testing.assert_allclose(found.theta[inner], cumulative(case, expected), atol=close)
    np.testing.assert_allclose(found.theta_dot[inner], numbers(expected["velocity"]), rtol=close)


@each_engine
@with_cycle
def test_terminal_cycle(case, engine, monkeypatch):
    # The tests below do not ask for the way there, which may take thousands of engagements.
    monkeypatch.setattr(terminal, "LONGEST_TRANSIENT", 0)
    cycle = esc.terminal(model(case), engine=engine.name, rtol=engine.rtol)
    expected = case["terminal"]
    for name in ("velocity_max", "velocity_min", "period"):
        assert getattr(cycle, name) == pytest.approx(float(expected[name]), rel=engine.allowed)
    # Near the Painleve limit it is 1e-175: only its absolute error means something.
    assert abs(cycle.contraction - float(expected["contraction"])) <= engine.contraction


@each_engine
def test_without_friction_there_is_no_terminal_cycle(engine):
    for case in (case for case in CASES if not case["terminal"]):
        cycle = esc.terminal(model(case), engine=engine.name, rtol=engine.rtol)
        assert np.isnan(cycle.velocity_max)


def test_next_to_no_driver_is_as_accurate_as_any_other():
    """All is decided within 1e-4 rad of pin exit, a small part of which 1e-16 rad is not."""
    (case,) = [case for case in CASES if case["name"] == "next to no driver"]
    motion = simulated("next to no driver", Engine("energy", 1e-13, 0.0, 0.0))
    times, speeds = motion.handoff_times, motion.handoff_velocities
    np.testing.assert_allclose(times, numbers(case["handoff_times"]), rtol=2e-14)
    np.testing.assert_allclose(speeds, numbers(case["handoff_velocities"]), rtol=2e-14)
