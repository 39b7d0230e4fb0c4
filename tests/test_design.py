"""Inverse design: requirements, fronts and reasons."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import escapement as esc
from escapement.cli import main
from escapement.inverse_design import timer_search
from escapement.inverse_design.front import spread_out, undominated
from escapement.inverse_design.similarity import UnitWheel
from escapement.outlines.parts import parts_of

ANY_THICK = dict.fromkeys(("driver_thickness", "follower_thickness"), (0.0, 10.0))
RUNS = Path(__file__).resolve().parents[1] / "runs"


@pytest.fixture(scope="module")
def thirty():
    requirement, _system = esc.load_requirement(RUNS / "thirty_seconds.toml")
    return esc.design(requirement)


def test_nothing_on_a_front_is_dominated_and_all_else_is():
    costs = np.random.default_rng(29).random((300, 3))
    front = undominated(costs)
    beaten = [((costs <= row).all(axis=1) & (costs < row).any(axis=1)).any() for row in costs]
    assert np.array_equal(front, np.flatnonzero(~np.array(beaten)))
    some = spread_out(costs[front], 9)
    assert len(set(some.tolist())) == 9
    assert {*costs[front].argmin(axis=0)} <= {*some.tolist()}


@pytest.mark.slow
def test_the_thirty_second_timer_is_found(thirty):
    designs, requirement = thirty.designs, thirty.requirement
    assert len(designs) >= 20
    costs = np.array([[one.values[name] for name in requirement.objectives] for one in designs])
    assert undominated(costs).size == len(designs)
    for one in designs:
        for name, (low, high) in requirement.bounds.items():
            assert low <= one.values[name] <= high
        run = esc.rundown(one.timer, turns=180)
        assert run.time_of(180) == pytest.approx(30.0, rel=1e-9)
        left = 1.0 - one.timer.spring_rate * 180 * 2.0 * np.pi / one.timer.torque
        assert left == pytest.approx(0.8, rel=1e-12)


@pytest.mark.parametrize("turns", [10, 30, 100])
def test_a_wish_for_whole_turns(turns):
    """However the turns are rounded, they are whole engagements."""
    requirement = esc.Requirement(
        total_time=0.2 * turns, turns=turns, torque=(0.005, 0.02), torque_lost=0.2, slots=6
    )
    (one,) = esc.design(requirement, count=1).designs
    assert esc.rundown(one.timer, turns=turns).time_of(turns) == pytest.approx(0.2 * turns)


def test_figures_scale_by_similarity():
    requirement = esc.Requirement(period=0.05, torque=0.01)
    wheel = UnitWheel(requirement, 4, False)
    numbers = {"inertia_ratio": 0.2, "crank_radius": 0.02, "torque": 0.01}
    found = wheel.values({name: np.array([x]) for name, x in numbers.items()}, exact=True)
    found = {name: x.item() for name, x in found.items()}
    timer = esc.Escapement(
        esc.Geneva(4, crank_radius=0.02, pin_radius=0.001),
        esc.Inertia(found["driver_inertia"], found["follower_inertia"]),
        torque=0.01,
        friction=0.3,
    )
    figures = esc.terminal(timer)
    assert figures.period == pytest.approx(0.05, rel=1e-12)
    assert found["rise_time_98"] == pytest.approx(figures.rise_time_98, rel=1e-9)


LOSSY = {
    "period": 0.04, "torque": (0.005, 0.05), "slots": (4, 5, 6), "internal": False,
    "roller_radius": (0.001, 0.0015, 0.002), "driver_drag": 1e-10, "follower_drag": (0.0, 1e-8),
    "driver_bearing_torque": 2e-4, "driver_bearing_radius": 0.001, "driver_bearing_friction": 0.1,
    "follower_bearing_radius": (0.001, 0.002), "follower_bearing_friction": 0.1,
    "driver_thickness": 0.003, "follower_thickness": (0.001, 0.002, 0.003),
}  # fmt: skip


@pytest.mark.slow
def test_rollers_vanes_bearings_and_sheets_are_searched(monkeypatch):
    """Each number lies in its range or list; period, scatter and discs are found another way."""
    monkeypatch.setattr(timer_search, "_SLOW", 5)
    monkeypatch.setattr(timer_search, "_SLOW_STEPS", 5)
    found = esc.design(esc.Requirement(**LOSSY), count=2).designs
    assert found
    for one in found:
        timer, wheel, values = one.timer, one.timer.mechanism, one.values
        for name, asked in LOSSY.items():
            if name in ("period", "internal"):
                continue
            value = {**timer.settings, **wheel.settings, **values}[name]
            ends = asked if isinstance(asked, tuple) else (asked, asked)
            assert value == pytest.approx(min(ends, key=lambda x: abs(x - value))) or (
                len(ends) == 2 and ends[0] <= value <= ends[1]
            ), name
        periods = [
            esc.terminal(replace(timer, friction=mu), engine="ivp").period
            for mu in (0.25, 0.30, 0.35)
        ]
        assert periods[1] == pytest.approx(0.04, rel=1e-7)
        assert values["scatter"] == pytest.approx(0.5 * np.ptp(periods) / periods[1], rel=1e-5)
        parts = {part.name: part for part in parts_of(wheel)}
        thick = values["follower_thickness"]
        assert parts["follower"].inertia(thick, 7850.0) == pytest.approx(timer.inertia.follower)
        driver = sum(
            parts[n].inertia(0.003, 7850.0) for n in ("driver", "locking-disc") if n in parts
        )
        assert driver == pytest.approx(timer.inertia.driver)


def test_where_the_torque_is_given_the_crank_radius_follows_from_a_sheet():
    task = {"period": 0.04, "torque": 0.02, "slots": 4, "internal": False}
    sheet = dict.fromkeys(("driver_thickness", "follower_thickness"), 0.003)
    (one,) = esc.design(esc.Requirement(**task, **sheet), count=1).designs
    assert one.timer.torque == 0.02
    assert esc.terminal(one.timer).period == pytest.approx(0.04, rel=1e-9)
    part = {part.name: part for part in parts_of(one.mechanism)}["follower"]
    assert part.inertia(0.003, 7850.0) == pytest.approx(one.timer.inertia.follower)
    crank = one.mechanism.crank_radius
    beyond = esc.design(esc.Requirement(**task, **sheet, crank_radius=(0.5 * crank, 0.9 * crank)))
    assert beyond.message.startswith(f"crank_radius must be at most {0.9 * crank:.6g} m, and the")


def test_a_run_with_vanes_takes_its_time():
    requirement = esc.Requirement(
        total_time=2.0, turns=10, torque=(0.005, 0.02), slots=6, internal=False, torque_lost=0.2,
        follower_drag=2e-8, inertia_ratio=0.1, crank_radius=0.02,
    )  # fmt: skip
    (one,) = esc.design(requirement, count=1).designs
    assert esc.rundown(one.timer, turns=10).time_of(10) == pytest.approx(2.0, rel=1e-9)


@pytest.mark.parametrize(("bounds", "told"), [
    ({"scatter": 0.01}, r"^scatter must be at most 0\.01, and the least is 0\.05"),
    ({"size": 0.001}, r"^size must be at most 0\.001 m, and the least is 0\.042.* m, if all"),
    ({"size": 0.001, **ANY_THICK}, r"^size must be at most 0\.001 m, .* is 0\.014.* m, if all"),
    ({"size": 0.01, "contact_force_max": 1.0}, r"size must .*; contact_force_max .*; no single"),
])  # fmt: skip
def test_an_impossible_wish_gets_its_reason(bounds, told):
    requirement = esc.Requirement(
        period=0.04, torque=0.01, slots=(3, 6), internal=False, bounds=bounds
    )
    found = esc.design(requirement)
    assert not found.designs
    assert re.search(told, found.message), found.message


def test_a_friction_at_which_all_wheels_jam_is_told():
    requirement = esc.Requirement(
        period=0.04, torque=0.01, friction=3.0, slots=6, inertia_ratio=0.02
    )
    assert "moves at a friction of 3" in esc.design(requirement).message


@pytest.mark.slow
def test_discs_are_as_thick_as_sheets_without_a_word():
    found = esc.design(
        esc.Requirement(period=0.04, torque=0.01, slots=(3, 6), objectives=("size", "mass")),
        count=5,
    )
    assert found.designs
    for one in found.designs:
        for name in ("driver_thickness", "follower_thickness"):
            assert 3e-4 <= one.values[name] <= 0.02
        assert one.can_be_cut


def test_a_greatest_thickness_keeps_the_least():
    bounds = {"driver_thickness": 0.005, "follower_thickness": 1e-4, "thinnest_wall": 5e-4}
    requirement = esc.Requirement(period=0.04, torque=0.01, bounds=bounds)
    assert requirement.bounds["driver_thickness"] == (3e-4, 0.005)
    assert requirement.bounds["follower_thickness"] == (-math.inf, 1e-4)
    assert requirement.bounds["thinnest_wall"] == (5e-4, math.inf)


def test_the_command_prints_designs(capsys, tmp_path):
    path = tmp_path / "wish.toml"
    path.write_text(
        'period = "40 ms"\ntorque = "0.1 in lbf"\nslots = 4\ninternal = false\n'
        'units = "in-lbf-s"\nobjectives = ["size", "mass"]\n[bounds]\nmass = 0.01\n'
    )
    assert main(["design", str(path), "--json", "--count", "5", "-o", str(tmp_path / "a.csv")]) == 0
    found = json.loads(capsys.readouterr().out)["designs"]
    assert 1 <= len(found) <= 5
    assert found[0]["torque"] == pytest.approx(0.1)
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert len(lines) == 1 + len(found)
    assert float(lines[1].split(",")[5]) == pytest.approx(0.1 * 0.45359237 * 9.80665 * 0.0254)


@pytest.mark.parametrize(("text", "told"), [
    ("period = 1\n", "torque must be given"),
    ("period = 1\ntorque = 1\nsize = 3\n", "size"),
    ("period = 1\ntorque = 1\nslots = [2, 3]\n", "at least 3, got 2; give a number in this range"),
    ("period = 1\ntorque = 1\nslots = 7.9\n", "a whole number of at least 3, got 7.9"),
    ("period = 1\ntorque = 1\nslots = [3, 6.5]\n", "whole number of at least 3, got 6.5"),
    ("period = 1\ntorque = 1\nfriction = [0.1, 0.2, 0.3]\n", "friction must be a number or two"),
    ("period = 1\ntorque = 1\nroller_radius = [1]\n", "a number, two ends or a longer list"),
    ("period = 1\ntorque = 1\ndriver_bearing_radius = 1\n", "left out without driver_bearing_f"),
    ("torque = 1\n", "period must be given, or total_time"),
    ("period = 1\ntorque = [2, 1]\n", "torque must be [low, high]"),
    ('period = 1\ntorque = "5 N"\n', "torque must be in N m"),
    ("period = 1\ntorque = 1\n[bounds]\nspeed = 1\n", "speed"),
])  # fmt: skip
def test_a_wrong_wish_is_told_in_a_line(capsys, tmp_path, text, told):
    path = tmp_path / "wish.toml"
    path.write_text(text)
    assert main(["design", str(path)]) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1


@pytest.mark.slow
def test_what_is_promised_is_simulated_by_the_other_engine(thirty):
    """Period, scatter, force and thickness of one design, each found another way."""
    one = thirty.designs[len(thirty.designs) // 2]
    timer = one.timer.held
    three = [
        esc.terminal(esc.Escapement(timer.mechanism, timer.inertia, timer.torque, mu), engine="ivp")
        for mu in (0.25, 0.30, 0.35)
    ]
    periods = [figures.period for figures in three]
    assert one.values["scatter"] == pytest.approx(0.5 * np.ptp(periods) / periods[1], rel=1e-7)
    force = max(figures.contact_force_max for figures in three)
    assert one.values["contact_force_max"] == pytest.approx(force, rel=1e-7)
    parts = {part.name: part for part in parts_of(timer.mechanism)}
    thick = one.values["follower_thickness"]
    assert parts["follower"].inertia(thick, 7850.0) == pytest.approx(timer.inertia.follower)
    wall = min(part.wall.width for name, part in parts.items() if name != "plate")
    assert one.values["thinnest_wall"] == pytest.approx(wall, rel=1e-9)
