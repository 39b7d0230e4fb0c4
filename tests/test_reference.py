"""Engines against motions computed in 40-digit arithmetic (``reference/generate.py``)."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import both_engines
import escapement as esc
from escapement.engines.ivp import terminal

CASES = json.loads(
    Path(__file__).with_name("reference").joinpath("motions.json").read_text(encoding="utf-8")
)


ENGINES = {"energy": (1e-12, 1e-11, 1e-9), "ivp": (1e-10, 1e-9, 1e-5)}
"""Tolerance asked for, relative error allowed, and absolute error of the contraction.

ivp takes the contraction from a difference quotient over 2e-4 of w, at an rtol of 1e-10.
"""

each_engine = pytest.mark.parametrize("engine", ENGINES)
each_case = pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])


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
def simulated(name, engine, rtol):
    """One motion serves all the tests of a case."""
    case = next(case for case in CASES if case["name"] == name)
    options = {"engine": engine, "rtol": rtol, "initial_speed": case["initial_speed"]}
    return case, esc.simulate(model(case), case["engagements"], **options)


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
    rtol, close, _ = ENGINES[engine]
    _, motion = simulated(case["name"], engine, rtol)
    for name in ("handoff_times", "handoff_velocities"):
        np.testing.assert_allclose(getattr(motion, name), numbers(case[name]), rtol=close)
    extrema, expected = motion.extrema, case["extrema"]
    # Start and end of the run are corners only by convention.
    inner = (extrema.time > 0) & (extrema.time < motion.handoff_times[-1] * (1 - 1e-9))
    assert list(extrema.maximum[inner]) == expected["maximum"]
    np.testing.assert_allclose(extrema.theta_dot[inner], numbers(expected["velocity"]), rtol=close)
    for found, places, name in (
        (motion.reversals, slice(None), "reversals"), (extrema, inner, "extrema"),
    ):  # fmt: skip
        expected = case[name]
        # driver angle from the first dead centre: local angle + engagement * cell
        cells = np.array(expected["engagement"]) * 2 * np.pi / case["pins"]
        theta = numbers(expected["angle"]) + cells
        np.testing.assert_allclose(found.time[places], numbers(expected["time"]), rtol=close)
        np.testing.assert_allclose(found.theta[places], theta, atol=close)


@both_engines.each_engine
@each_case
def test_terminal_cycle(case, engine, monkeypatch):
    # The tests below do not ask for the way there, which may take thousands of engagements.
    monkeypatch.setattr(terminal, "LONGEST_TRANSIENT", 0)
    rtol, close, contraction = ENGINES[engine]
    cycle, expected = esc.terminal(model(case), engine=engine, rtol=rtol), case["terminal"]
    if expected is None:
        assert np.isnan(cycle.velocity_max)
        return
    for name in ("velocity_max", "velocity_min", "period"):
        assert getattr(cycle, name) == pytest.approx(float(expected[name]), rel=close)
    # Near the Painleve limit it is 1e-175: only its absolute error means something.
    assert abs(cycle.contraction - float(expected["contraction"])) <= contraction


def test_next_to_no_driver_is_as_accurate_as_any_other():
    """All is decided within 1e-4 rad of pin exit, a small part of which 1e-16 rad is not."""
    case, motion = simulated("next to no driver", "energy", 1e-13)
    for name in ("handoff_times", "handoff_velocities"):
        np.testing.assert_allclose(getattr(motion, name), numbers(case[name]), rtol=2e-14)
