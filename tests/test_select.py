"""A single case of a study file, simulated again as a full motion."""

import h5py
import numpy as np
import pytest

import escapement as esc
from escapement.study.reader import read_study
from escapement.study.result import SCHEMA_VERSION

STUDY = """
units = "in-lbf-s"
[mechanism]
slots = 4
[inertia]
driver = 3e-6
follower = 50e-6
[sweep]
friction = [0.2, 0.35]
torque = { start = 0.08, stop = 0.14, num = 4 }
load_torque = 0.001
"""


@pytest.fixture(autouse=True)
def study(tmp_path, command):
    """A study in the working folder."""
    (tmp_path / "s.toml").write_text(STUDY)
    assert command("sweep", "s.toml", "--quiet", "--workers", "1")[0] == 0


@pytest.mark.parametrize("engine", [(), ("--engine", "energy", "--rtol", "1e-9")])
def test_a_case_is_redone(command, report, engine):
    record = report("run", "--from", "s.h5", "--select", "friction=0.35, torque=.1", *engine)
    results = read_study("s.h5").results
    for name in ("velocity_max", "period", "rise_time"):
        assert record[name] == pytest.approx(results[name][1, 1, 0], rel=1e-8)
    assert len(record["handoff_times"]) == 20
    words = ("--from", "s.h5", "--select", "friction=0.2,torque=0.14", "-o", "m.h5")
    assert command("run", *words)[0] == 0
    assert command("plot", "m.h5")[0] == 0


REFUSED = {
    "friction=0.3,torque=0.1": "error: friction must be a value of s.h5, got 0.3; the nearest is",
    "torque=0.1": "--select must choose one of the 2 values of friction in s.h5, got none",
    "slots=4": "--select must name axes of s.h5, got 'slots'; it has friction, torque, load_torque",
    "friction": "--select must be NAME=VALUE[,NAME=VALUE...], got 'friction'",
    "friction=nan,torque=.1": "friction must be a value of s.h5, got nan",
    "torque=.1,friction=.2, torque=.12": "--select must give torque once, got 'torque=.1,friction",
}


@pytest.mark.parametrize("selection", REFUSED)
def test_a_selection_that_names_no_case(refusal, selection):
    assert REFUSED[selection] in refusal(2, "run", "--from", "s.h5", "--select", selection)


def test_a_case_that_cannot_be_built_is_named_as_selected(tmp_path, command, refusal):
    pins = STUDY.replace("slots = 4\n", "").replace(
        "[sweep]", "[sweep]\nslots = [4, 5]\npins = [3, 4]"
    )
    (tmp_path / "p.toml").write_text(pins)
    assert command("sweep", "p.toml", "--quiet")[0] == 3
    wanted = "slots=5,pins=4,friction=0.2,torque=0.1"
    said = refusal(2, "run", "--from", "p.h5", "--select", wanted)
    assert f"--select must name a case that can be built, got '{wanted}': pins must be" in said


@pytest.mark.parametrize(
    ("argv", "code", "message"),
    [
        (["--select", "friction=1"], 2, "--select must come with --from"),
        (["--from", "s.h5", "--friction", "0"], 2, "--friction must not come with --from"),
        (["--from", "s.h5", "--initial-speed", "0"], 2, "--initial-speed must not come with"),
        (["--from", "s.h5", "--slots", "5"], 2, "--slots must not come with --from"),
        (["--from", "none.h5"], 66, "does not exist"),
        (["--from", "s.toml"], 65, "must be an HDF5 file"),
    ],
)
def test_wrong_use(refusal, argv, code, message):
    assert message in refusal(code, "run", *argv)


def test_files_of_other_versions(command, refusal):
    """An older file and one with more in it are read, a newer layout is refused."""
    with h5py.File("s.h5", "r+") as file:
        file["note"] = 1.0
        file.attrs["package_version"] = "0.0.1"
    words = ("run", "--from", "s.h5", "--select", "friction=0.2,torque=0.1")
    assert command(*words)[0] == 0
    with h5py.File("s.h5", "r+") as file:
        file.attrs["schema_version"] = SCHEMA_VERSION + 1
    assert "install a newer" in refusal(65, *words)


def test_a_value_is_named_by_the_six_figures_that_are_shown(tmp_path):
    from escapement.cli._cases import load_case

    timer = esc.Escapement(esc.Geneva(4), esc.Inertia(3e-6, 50e-6), 0.1, friction=0.35)
    torques = np.geomspace(0.05, 0.2, 101)
    esc.sweep(timer, torque=torques, path=tmp_path / "torques.h5")
    for place in range(torques.size):
        _plan, case = load_case(tmp_path / "torques.h5", f"torque={torques[place]:g}")
        assert case == place
