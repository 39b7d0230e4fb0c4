"""Command line: studies that are swept and drawn, and a single case simulated again."""

import json

import h5py
import numpy as np
import pytest

import escapement as esc
from escapement.study.reader import read_study
from escapement.study.selection import load_case
from escapement.study.stored import SCHEMA_VERSION

STUDY = """
units = "in-lbf-s"
[mechanism]
slots = 4
[inertia]
driver = 3e-6
follower = 50e-6
[sweep]
friction = {friction}
torque = [0.08, 0.10, 0.12, 0.14]
"""


@pytest.fixture
def study(tmp_path):
    """Writes a study configuration with the given frictions."""

    def write(friction="[0.20, 0.35]"):
        path = tmp_path / "four.toml"
        path.write_text(STUDY.format(friction=friction))
        return path

    return write


@pytest.fixture
def swept(tmp_path, command):
    """A study file in the working folder, with an axis of one value."""
    (tmp_path / "s.toml").write_text(STUDY.format(friction="[0.2, 0.35]") + "load_torque = 0.001\n")
    assert command("sweep", "s.toml", "--quiet", "--workers", "1")[0] == 0


def test_sweep_writes_beside_and_shows_a_table(command, study, tmp_path):
    code, out, _err = command("sweep", study())
    assert code == 0
    found = read_study(tmp_path / "four.h5")
    inputs, _, table = out.partition("\n\n")
    assert "friction" in inputs
    lines = table.splitlines()
    assert len(lines) == 2 + 8
    assert lines[0].split()[:2] == ["friction", "torque"]
    first = lines[2].split()
    assert first[:2] == ["0.2", "0.08"]
    assert float(first[2]) == pytest.approx(found.results["velocity_max"][0, 0], rel=1e-5)


def test_sweep_with_failed_cases(command, study):
    code, out, err = command("sweep", study("[0.35, 0.5]"), "--workers", "1", "--json")
    record = json.loads(out)
    assert code == 3
    assert record["failed"] == 4
    assert "4 of 8 cases failed" in err
    assert [case["status"] for case in record["some_cases"]] == ["ok"] * 4 + ["painleve"] * 4
    assert record["some_cases"][-1]["period"] is None


def test_plot_draws_the_slice_that_was_selected(command, refusal, study, tmp_path):
    path = study()
    path.write_text(path.read_text().replace("slots = 4\n", "") + "slots = [3, 4, 6]\n")
    command("sweep", path)
    assert command("plot", "four.h5", "--select", "slots=6")[0] == 0
    selected = (tmp_path / "four.png").read_bytes()
    command("plot", "four.h5")
    assert (tmp_path / "four.png").read_bytes() != selected
    for selection, said in {
        "slots=5": "--select, of four.h5: slots must be a value of the study, got 5; the nearest",
        "pins=2": "--select, of four.h5: axis must be one of friction, torque, slots, got 'pins'",
        "slots": "--select must be NAME=VALUE[,NAME=VALUE...], got 'slots'",
    }.items():
        assert said in refusal(2, "plot", "four.h5", "--select", selection)
    inertia = ("--driver-inertia", "3e-6", "--follower-inertia", "5e-5")
    command("run", "--friction", "0.2", "--torque", "0.01", *inertia, "-o", "m.h5")
    assert "--select must come with a study" in refusal(2, "plot", "m.h5", "--select", "slots=6")


@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_mechanism_that_no_case_could_have_is_refused_at_once(refusal, study, workers):
    path = study()
    path.write_text(path.read_text().replace("slots = 4", "slots = 4\npins = 9"))
    said = refusal(2, "sweep", path, "--workers", workers)
    assert "pins must be at most 4 for 4 slots, got 9" in said


# a case of a study file, as a full motion


def test_a_case_is_redone(swept, command, report):
    engine = "--engine", "energy", "--rtol", "1e-9"
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
    "friction=nan,torque=.1": "--select friction must be a finite number, got nan; give the value",
    "friction=0.25,torque=5 N": "--select torque must be in in-lbf or a unit of the same kind",
    "torque=.1,friction=.2, torque=.12": "--select must give torque once, got 'torque=.1,friction",
}
WRONG = [(("--from", "s.h5", "--select", chosen), 2, said) for chosen, said in REFUSED.items()]
WRONG += [
    (("--select", "friction=1"), 2, "--select must come with --from"),
    (("--from", "s.h5", "--friction", "0"), 2, "--friction must not come with --from"),
    (("--from", "s.h5", "--initial-speed", "0"), 2, "--initial-speed must not come with"),
    (("--from", "s.h5", "--slots", "5"), 2, "--slots must not come with --from"),
    (("--from", "none.h5"), 66, "does not exist"),
    (("--from", "s.toml"), 2, "--select must choose"),
]


def test_what_names_no_case_is_refused(swept, refusal):
    for words, code, said in WRONG:
        assert said in refusal(code, "run", *words)


def test_a_case_that_cannot_be_built_is_named_as_selected(study, command, refusal):
    path = study("[0.2]")
    text = path.read_text().replace("slots = 4\n", "")
    path.write_text(text.replace("[sweep]", "[sweep]\nslots = [4, 5]\npins = [3, 4]"))
    assert command("sweep", path, "--quiet")[0] == 3
    wanted = "slots=5,pins=4,torque=0.1"
    said = refusal(2, "run", "--from", "four.h5", "--select", wanted)
    assert f"--select must name a case with a possible mechanism, got '{wanted}': pins" in said


def test_files_of_other_versions(swept, command, refusal):
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
    timer = esc.Escapement(esc.Geneva(4), esc.Inertia(3e-6, 50e-6), 0.1, friction=0.35)
    torques = np.geomspace(0.05, 0.2, 101)
    esc.sweep(timer, torque=torques, path=tmp_path / "torques.h5")
    for place, torque in enumerate(torques):
        assert load_case(tmp_path / "torques.h5", f"torque={torque:g}")[1] == place
