"""Pins with width, rollers, bearings and drag in studies, files and commands."""

import json
from dataclasses import dataclass, replace

import h5py
import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.base.units import INCH, INCH_POUND
from escapement.cli.plot import in_units
from escapement.dynamics.law import LOSSES
from escapement.engines import simulate as simulation
from escapement.motion_file import read_motion, write_motion
from escapement.study.parse import plan_from
from escapement.study.result import RESULTS
from escapement.study.running import run_plan
from test_real_mechanism import CRANK, DRAG, INERTIA, JOURNALS, OIL, TORQUE, everything

IDEAL = esc.Escapement(esc.Geneva(4, crank_radius=CRANK), INERTIA, TORQUE, 0.2)
WHEELS = {
    "external": IDEAL.mechanism,
    "internal": esc.Geneva(6, internal=True, crank_radius=CRANK),
    "gear-driven": esc.GearDriven(6, "1/2", fixed_radius=CRANK),
}
MODEL = ["--torque", ".1", "--driver-inertia", "3e-6", "--follower-inertia", "50e-6"]
RUN = ["run", *MODEL, "--friction", ".3", "--units", "in-lbf-s"]
PINS = """
units = "in-lbf-s"
torque = 0.1
friction = 0.3
driver_bearing_friction = 0.1
driver_bearing_radius = 0.02
[mechanism]
slots = 4
crank_radius = 0.4
[inertia]
driver = 3e-6
follower = 50e-6
[sweep]
pin_radius = [0.0, 0.04, 0.2]
driver_drag = [0.0, 1e-6]
driver_viscous = [1e-5]
"""


def random_numbers(wheel, cases, seed):
    """Columns of numbers of real parts; some pins are too wide, and some rollers too small."""
    rng, widest = np.random.default_rng(seed), wheel.widest_pin * CRANK

    def some(greatest, share=1.0):
        return rng.uniform(0.0, greatest, cases) * (rng.random(cases) < share)

    greatest = {"friction": 0.4, "driver_bearing_torque": 0.1 * TORQUE}
    greatest |= {name: 2.0 * value for name, value in (DRAG | OIL).items()}
    greatest |= {name: 2.0 * JOURNALS[name] for name in JOURNALS if "follower" in name}
    if wheel.plain_crank:
        greatest |= {name: 2.0 * JOURNALS[name] for name in JOURNALS}
    pin, inertia = some(0.5 * widest, 0.9), 10.0 ** rng.uniform(-7.5, -5.5, cases)
    drawn = {"pin_radius": pin, "roller_radius": some(1.2 * widest, 0.4)}
    drawn |= {"load_torque": some(0.2 * TORQUE, 0.5), "initial_speed": some(30.0, 0.5)}
    drawn |= {"torque": TORQUE * rng.uniform(0.5, 2.0, cases), "driver_inertia": inertia}
    return drawn | {name: some(value, 0.8) for name, value in greatest.items()}


def assert_alone(plan, found, case):
    """A case of a study is what `terminal` says of it alone."""
    outcome = {name: found[name][case] for name in RESULTS}
    try:
        speed = plan.values(case)["initial_speed"]
        alone = simulation.terminal(plan.escapement(case), initial_speed=speed)
    except InvalidValue:
        assert outcome.pop("status") == Status.INVALID
        assert np.isnan([*outcome.values()]).all()
        return
    expected = {name: getattr(alone, name) for name in RESULTS}
    assert outcome == pytest.approx(expected, rel=1e-12, nan_ok=True)


@pytest.mark.parametrize("name", WHEELS)
def test_every_case_with_all_effects_is_what_it_is_alone(name):
    sample = {"method": "list"} | random_numbers(WHEELS[name], 60, seed=2)
    plan = plan_from(replace(IDEAL, mechanism=WHEELS[name]), {}, sample=sample)
    found = run_plan(plan).results
    for case in range(plan.cases):
        assert_alone(plan, found, case)
    assert {Status.OK, Status.INVALID} <= set(found["status"].tolist())


def test_python_sweeps_pins_and_mechanisms_of_the_users_own():
    widest = IDEAL.mechanism.widest_pin * CRANK
    grid = esc.sweep(IDEAL, pin_radius=[0.0, 5e-4, widest], driver_drag=[0.0, 1e-8])
    assert grid.results["status"].tolist() == [[0, 0], [0, 0], [Status.INVALID] * 2]
    assert grid.units["driver_drag"] == "N m s2 rad-2"

    @dataclass(frozen=True)
    class Own(esc.Geneva):
        pass

    own = replace(IDEAL, mechanism=Own(4, crank_radius=CRANK, pin_radius=5e-4))
    alone = esc.sweep(own, driver_drag=[0.0, 1e-8]).results["period"]
    np.testing.assert_allclose(alone, grid.results["period"][1], rtol=1e-13)


def test_a_study_file_has_units_and_converts_drag_by_its_kind(command, tmp_path):
    (tmp_path / "pins.toml").write_text(PINS)
    code, out, _ = command("sweep", "pins.toml", "--json", "--units", "SI")
    assert code == 3
    cases = json.loads(out)["some_cases"]
    assert [case["status"] for case in cases] == ["ok"] * 4 + ["invalid"] * 2
    assert cases[3]["pin_radius"] == pytest.approx(0.04 * INCH)
    assert cases[3]["driver_drag"] == pytest.approx(1e-6 * INCH_POUND)
    study = esc.read_study("pins.h5")
    assert study.long_names["pin_radius"] == "radius of the pins"
    shown = {"pin_radius": "in", "driver_drag": "in lbf s2 rad-2"}
    shown |= {"driver_viscous": "in lbf s rad-1"}
    assert {name: study.units[name] for name in shown} == shown
    metric = in_units(study, "SI")
    assert [metric.units[name] for name in shown] == ["m", "N m s2 rad-2", "N m s rad-1"]
    assert metric.axes["driver_viscous"][0] == pytest.approx(1e-5 * INCH_POUND)
    (panel, *_) = esc.plots.plot_study(study).axes[-1:]
    assert panel.get_xlabel() == "Radius of the pins (in)"
    chosen = ["--select", "pin_radius=0.04,driver_drag=1e-6"]
    record = json.loads(command("run", "--from", "pins.h5", *chosen, "--json")[1])
    assert record["period"] == pytest.approx(study.results["period"][1, 1, 0], rel=1e-12)
    assert record["inputs"]["driver_drag"]["in-lbf-s"] == pytest.approx(1e-6)


def test_run_tells_what_is_there_and_nothing_that_is_absent(command):
    options = ["--crank-radius", ".4", "--pin-radius", ".02", "--driver-viscous", "1e-5"]
    code, out, err = command(*RUN, *options, "--friction", ".395", "--json")
    record = json.loads(out)
    assert code == 0
    assert "a second motion is possible" in record["message"]
    assert "a second motion is possible" in err
    assert record["uniqueness_friction"] == pytest.approx(0.3902965, abs=5e-8)
    assert record["critical_friction"] == pytest.approx(0.4231149, abs=5e-8)
    assert record["inputs"]["driver_viscous"]["SI"] == pytest.approx(1e-5 * INCH_POUND)
    assert {"load_torque", "friction"} < set(record["inputs"])
    assert record["inputs"].keys().isdisjoint({"roller_radius", "follower_drag", *JOURNALS})
    table = command(*RUN, *options)[1]
    assert "uniqueness friction" in table
    assert "in-lbf-s/rad = 1.12985e-06 N m s/rad" in table
    assert "uniqueness friction" not in command(*RUN)[1]


@pytest.mark.parametrize("slots", [4, 5])
def test_a_motion_file_keeps_reactions_and_losses(slots, tmp_path):
    motion = esc.simulate(everything(slots=slots, friction=0.2), 3)
    write_motion(motion, tmp_path / "motion.h5")
    again = read_motion(tmp_path / "motion.h5")
    assert again.escapement == motion.escapement
    for name in LOSSES:
        assert getattr(again.ledger, name) == pytest.approx(getattr(motion.ledger, name), rel=1e-13)
    grid = np.linspace(0.0, motion.end_time, 999)
    found, written = again.at(grid), motion.at(grid)
    for body in ("driver", "follower"):
        name = f"{body}_bearing_reaction"
        scale = 1e-9 * getattr(written, name).max()
        np.testing.assert_allclose(getattr(found, name), getattr(written, name), atol=scale)
    with h5py.File(tmp_path / "motion.h5") as hdf5:
        assert hdf5["driver_bearing_reaction"].attrs["units"] == "N"
