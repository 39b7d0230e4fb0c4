"""Command line: what `run`, `mechanism` and `reproduce` print, write and return."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray

import escapement as esc
from escapement.base.text import plain
from escapement.base.units import INCH_POUND
from escapement.motion_file import read_motion

MEYER = [
    *("--torque", ".10", "--driver-inertia", "3e-6", "--follower-inertia", "50e-6"),
    *("--units", "in-lbf-s"),
]
TIMER = esc.Escapement(
    esc.Geneva(4), esc.Inertia(3e-6 * INCH_POUND, 50e-6 * INCH_POUND), 0.10 * INCH_POUND, 0.35
)
RUN = ["run", "--friction", ".35", *MEYER]
MOTIONS = json.loads((Path(__file__).parent / "reference" / "motions.json").read_text())
(REFERENCE,) = [case for case in MOTIONS if case["name"] == "meyer four pins"]


def test_run_json_is_one_object_with_numbers_that_are_right(command):
    code, out, err = command(*RUN, "--json")
    record = json.loads(out)
    assert (code, err) == (0, "")
    figures = esc.terminal(TIMER)
    for name in ("velocity_max", "period", "rise_time", "settling_time", "acceleration_max"):
        assert record[name] == pytest.approx(getattr(figures, name), rel=1e-12)
    moment = figures.contact_moment_max / INCH_POUND
    assert record["contact_moment_max"] == pytest.approx(moment, rel=1e-12)
    assert len(record["handoff_times"]) == 20
    for name in ("handoff_times", "handoff_velocities"):
        assert record[name] == pytest.approx([float(x) for x in REFERENCE[name]], rel=1e-9)
    assert abs(record["energy_residual"]) < 1e-9
    assert (record["status"], record["engine"]) == ("ok", "energy")


@pytest.mark.parametrize("extra", [["--engagements", "3"], ["--duration", "0.15"]])
def test_run_length(report, extra):
    record = report(*RUN, *extra)
    assert len(record["handoff_times"]) == 3
    expected = float(REFERENCE["terminal"]["velocity_max"])
    assert record["velocity_max"] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("extra", "code", "status", "said"),
    [
        ([], 0, "no_terminal", "no terminal velocity"),
        (["--friction", "0.5"], 3, "painleve", "0.406079"),
        (["--friction", "0.3", "--load-torque", "0.09"], 3, "stall", "degrees"),
    ],
)
def test_run_without_a_terminal_cycle(command, extra, code, status, said):
    found, out, err = command("run", *MEYER, *extra, "--json")
    record = json.loads(out)
    assert (found, record["status"]) == (code, status)
    assert record["velocity_max"] is record["rise_time"] is None
    assert said in record["message"]
    assert err == f"escapement: {record['message']}\n"


def test_run_gives_the_rule_for_jams_beyond_the_limit(command):
    code, out, err = command("run", *MEYER, "--friction", ".5", "--jam-rule", "--json")
    record = json.loads(out)
    assert (code, record["status"]) == (0, "painleve")
    assert record["jam_rule_period"] == pytest.approx(0.0583947, rel=1e-6)
    assert record["jam_rule_angles_deg"] == pytest.approx([26.4836, 36.0936], abs=6e-5)
    assert record["jam_rule_error"] == 0.03
    assert "relative error of the period is about 0.03" in err
    code, out, err = command("run", *MEYER, "--friction", ".3", "--jam-rule")
    assert (code, out) == (2, "")
    assert "friction must be at least the limit 0.406079, got 0.3" in err


def test_painleve_leaves_no_files(command, tmp_path):
    _, _, err = command("run", *MEYER, "--friction", ".5", "-o", "m.h5", "--plot", "m.png")
    assert list(tmp_path.iterdir()) == []
    assert "no m.h5 and no m.png was made" in err.splitlines()[0]


def test_run_writes_the_motion(command):
    assert command(*RUN, "--crank-radius", ".2", "-o", "m.h5")[0] == 0
    motion = esc.simulate(TIMER)
    with xarray.open_dataset("m.h5", engine="h5netcdf") as data:
        assert {"theta_ddot", "phi_dot", "contact_force", "handoff_velocities"} <= set(data)
        assert all({"units", "long_name"} <= set(data[name].attrs) for name in data)
        assert data["contact_force"].attrs["units"] == "lbf"
        assert data.attrs["content"] == "motion"
        np.testing.assert_allclose(data["handoff_times"], motion.handoff_times, rtol=1e-15)
        state = motion.at(data["t"].values)
        np.testing.assert_allclose(data["phi_ddot"], state.phi_ddot, rtol=1e-12)
        moments = state.contact_moment / INCH_POUND
        np.testing.assert_allclose(data["contact_moment"], moments, rtol=1e-12)


def test_a_geometry_without_dynamics_is_reported_with_a_warning(command):
    wheel = ("--stations", "4", "--lobes", "0", "--curve", "hypocycloid")
    code, out, err = command("mechanism", "gear-driven", *wheel, "--json")
    record = json.loads(out)
    assert (code, record["closest_radius_over_fixed"]) == (0, 0.0)
    assert record["message"].startswith("warning: stations 4, lobes 0, curve 'hypo")
    assert err == f"escapement: {record['message']}\n"
    err = command("mechanism", "gear-driven", *wheel, "--pins", "9")[2]
    assert (
        "pins must be at most 1, as each drives for a share 1 of a cycle, got 9; give 1, or two"
        in err
    )


def test_what_a_mechanism_lacks_is_null_with_a_reason(command, report):
    radii = ("--sun-radius", "1", "--planet-radius", ".5001234")
    inertias = ("--driver-inertia", "1e-6", "--follower-inertia", "1e-6")
    record = report("mechanism", "elliptical-planetary", *radii)
    assert [key for key, value in record.items() if value is None] == ["stations"]
    assert record["message"].startswith("stations is not given: ")
    code, out, err = command("mechanism", "elliptical-planetary", *radii, *inertias)
    assert (code, out) == (2, "")
    assert "which has no slots and so no critical friction" in err
    assert "message" not in report("mechanism")


def test_an_existing_motion_is_kept_unless_forced_and_a_picture_replaced(command, tmp_path):
    arguments = [*RUN, "-o", "m.h5", "--plot", "v.png"]
    for name in ("m.h5", "v.png"):
        (tmp_path / name).write_text("mine")
    assert command(*arguments)[0] == 73
    assert {path.read_text() for path in tmp_path.iterdir()} == {"mine"}
    assert command(*arguments, "--force")[0] == 0
    assert read_motion("m.h5").handoff_times.size == 20
    assert (tmp_path / "v.png").read_bytes().startswith(b"\x89PNG")


def test_json_knows_no_nan():
    values = {
        "a": math.nan,
        "b": [np.float64(math.inf), np.int64(3)],
        "c": np.array([1.0, math.nan]),
    }
    assert plain(values) == {"a": None, "b": [None, 3], "c": [1.0, None]}


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (KeyboardInterrupt(), 130),
        (OSError(5, "Input/output error"), 74),
        (MemoryError(), 74),
        (OverflowError("Result too large"), 2),
    ],
)
def test_what_strikes_from_outside_is_one_line(command, monkeypatch, error, code):
    def strike(_path):
        raise error

    monkeypatch.setattr("escapement.load_plan", strike)
    Path("x.toml").touch()
    found, out, err = command("sweep", "x.toml")
    assert (found, out) == (code, "")
    assert err.startswith("escapement: error: ")
    assert err.count("\n") == 1
