"""Stresses of the pin: hand formulas, the figures of every kind of study, bounds of designs."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import escapement as esc
from escapement.study.parse import plan_from
from escapement.study.scenes import cost_note

WHEEL = esc.Geneva(4, crank_radius=0.01, pin_radius=7e-4)
TIMER = esc.Escapement(
    WHEEL, esc.Inertia(3e-7, 5e-6), 0.0113, friction=0.2, pin_length=2e-3, pin_gap=1e-4,
    pin_material="steel", wheel_material="brass",
)  # fmt: skip
STEEL = 206e9 / (1.0 - 0.3**2)
BRASS = 106e9 / (1.0 - 0.324**2)


def test_figures_are_those_of_hand_formulas():
    found = esc.terminal(TIMER)
    force, radius, length = found.contact_force_max, 7e-4, 2e-3
    modulus = 1.0 / (1.0 / STEEL + 1.0 / BRASS)
    assert found.pressure_max == pytest.approx(
        math.sqrt(force * modulus / (math.pi * length * radius)), rel=1e-12
    )
    bending = 32.0 * force * (1e-4 + 0.5 * length) / (math.pi * (2.0 * radius) ** 3)
    assert found.pin_bending_max == pytest.approx(bending, rel=1e-12)
    assert found.pin_shear_max == pytest.approx(force / (math.pi * radius**2), rel=1e-12)
    assert found.pressure_speed_max == pytest.approx(
        found.rubbing_max / (2.0 * radius * length), rel=1e-12
    )
    assert found.pin_load_frequency == pytest.approx(1.0 / (4.0 * found.period), rel=1e-12)


def test_rubbing_is_what_friction_loses_over_its_coefficient():
    found = esc.terminal(TIMER)
    times = np.linspace(0.0, found.motion.end_time, 20_001)
    lost = found.motion.at(times).power_lost["friction"] / TIMER.friction
    assert found.rubbing_max == pytest.approx(lost.max(), rel=1e-5)
    assert found.rubbing_max >= lost.max() * (1.0 - 1e-9)
    assert esc.terminal(TIMER, engine="ivp").rubbing_max == pytest.approx(
        found.rubbing_max, rel=1e-7
    )


def test_stresses_are_figures_of_budgets_and_of_commands(command):
    limits = {"pressure_max": (0.0, 1e10)}
    found = esc.budget(TIMER, {"friction": {"tolerance": 0.02}}, limits=limits, size=64)
    assert found.figures["pressure_max"].inside.value == 1.0
    words = ["run", "--slots", "4", "--crank-radius", "10", "--pin-radius", "0.7", "--units", "mm"]
    drive = ["--torque", "11.3", "--driver-inertia", "300", "--follower-inertia", "5000"]
    code, out, err = command(*words, *drive, "--pin-length", "2", "--pin-material", "brass")
    assert code == 0, err
    assert "pressure max" in out
    assert "MPa" in out
    assert "pressure max" not in command(*words, *drive)[1]


def test_a_run_counts_the_loads_of_a_pin():
    run = esc.rundown(TIMER, turns=10.0)
    assert run.as_dict()["pin_loads"] == 10
    assert "pin_loads" not in esc.rundown(replace(TIMER, pin_length=0.0), turns=10.0).as_dict()


def test_a_roller_does_not_slide():
    rolling = replace(TIMER, mechanism=replace(WHEEL, roller_radius=1e-3))
    found = esc.terminal(rolling)
    assert math.isnan(found.pressure_speed_max)
    assert found.pressure_max < esc.terminal(TIMER).pressure_max


def test_a_design_keeps_a_pressure():
    task = {"period": 0.03, "torque": (0.005, 0.02), "slots": (4, 5), "friction": (0.2, 0.25)}
    free = esc.design(esc.Requirement(**task), count=5).designs
    most = 0.8 * min(one.values["pressure_max"] for one in free)
    bounded = esc.design(esc.Requirement(**task, bounds={"pressure_max": most}), count=5)
    for one in bounded.designs:
        timer, values = one.timer, one.values
        length = values["follower_thickness"]
        own = replace(timer, pin_length=length, friction=0.2)
        other = replace(timer, pin_length=length, friction=0.25)
        greatest = max(esc.terminal(x).pressure_max for x in (own, other))
        assert values["pressure_max"] == pytest.approx(greatest, rel=0.02)
        assert values["pressure_max"] <= most
    assert bounded.designs or "pressure_max must be at most" in bounded.message


def test_the_cost_of_a_study_is_told():
    axes = {
        "friction": np.linspace(0.0, 0.3, 1000),
        "driver_inertia": np.geomspace(1e-7, 1e-6, 300),
    }
    dear = plan_from(TIMER, axes, results=["period", "energy_residual"])
    assert "energy_residual is computed case by case" in cost_note(dear)
    assert cost_note(plan_from(TIMER, axes, results=["period", "pressure_max"])) == ""
    torque = esc.TorqueCurve((0.0, math.pi, 2.0 * math.pi), (0.01, 0.008, 0.01), True)
    own = cost_note(plan_from(replace(TIMER, torque=torque), axes, results=["period"]))
    assert own == (
        "all figures are computed case by case, about 3 ms for each: some 15 minutes on one "
        "processor"
    )
    by_steps = plan_from(TIMER, axes, results=["period"], engine="ivp")
    assert "all figures are computed case by case, about 300 ms" in cost_note(by_steps)
    few = plan_from(TIMER, {"friction": [0.1, 0.2]}, results=["energy_residual"])
    assert cost_note(few) == ""


def test_several_wheels_make_one_table(command):
    drive = ["--torque", "0.0113", "--driver-inertia", "3e-7", "--follower-inertia", "5e-6"]
    drive += ["--friction", "0.2"]
    code, out, err = command("run", "--slots", "4,6", *drive)
    assert code == 0, err
    row = next(line for line in out.splitlines() if line.startswith("period"))
    four = esc.terminal(esc.Escapement(esc.Geneva(4), TIMER.inertia, 0.0113, 0.2))
    assert f"{four.period:.6g}" in row.split()
    assert len(row.split()) == 4
    for words in (["mechanism"], ["index", "--speed", "3", "--load-torque", "1",
                                  "--follower-inertia", "0.1"]):  # fmt: skip
        code, out, err = command(*words, "--slots", "4,5,8")
        assert code == 0, err
        assert "4 slots" in out
        assert "8 slots" in out
    code, out, err = command("run", "--slots", "4,6", *drive, "--plot", "a.png")
    assert code == 2
    assert "--plot must come with one number of slots" in err
    assert not Path("a.png").exists()


def test_the_help_of_a_kind_has_its_options_alone(command):
    every, geneva = command("run", "--help")[1], command("run", "geneva", "--help")[1]
    for name in ("--stations", "--sun-radius", "--efficiency"):
        assert name in every
        assert name not in geneva.replace("--barrel-efficiency", "").replace(
            "--load-train-efficiency", ""
        )
    assert "--slots" in geneva
    assert "--friction" not in command("run", "elliptical-planetary", "--help")[1]


STUDY = """
units = "in-lbf-s"
[mechanism]
slots = 4
[inertia]
driver = 3e-6
follower = 50e-6
[sweep]
torque = [0.08, 0.1]
friction = [0.3, 0.2]
"""


def test_tables_are_drawn(command):
    Path("s.toml").write_text(STUDY)
    for suffix in ("h5", "csv", "parquet"):
        code, _, err = command("sweep", "s.toml", "-o", f"s.{suffix}", "--quiet")
        assert code == 0, err
        units = ["--units", "in-lbf-s"] if suffix == "csv" else []
        code, _, err = command("plot", f"s.{suffix}", "-o", f"{suffix}.svg", *units)
        assert code == 0, err
    assert Path("parquet.svg").read_bytes() == Path("h5.svg").read_bytes()
    code, _, err = command("plot", "s.csv")
    assert code == 2
    assert "give --units of the study" in err
    Path("other.csv").write_text("a,b\n1,2\n")
    assert command("plot", "other.csv", "--units", "SI")[0] == 65
