"""Samples as studies: one case each, stored and continued like a grid."""

import json

import h5py
import numpy as np
import pytest
import xarray

import escapement as esc
from escapement.base.errors import CannotCreate
from escapement.base.units import INCH_POUND
from escapement.study.parse import parse_plan, plan_from, sample
from escapement.study.reader import read_study
from escapement.study.result import RESULTS
from escapement.study.running import run_plan, sweep, write_plan
from study_tools import assert_as_alone, without_date

TIMER = esc.Escapement(esc.Geneva(slots=4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113, 0.3)
EVEN = {"low": 0.2, "high": 0.3}
FORMS = {"friction": EVEN, "torque": {"relative_tolerance": 0.1}, "driver_inertia": {"low": 3e-7,
         "high": 4e-7}}  # fmt: skip


@pytest.mark.parametrize("axes", [{}, {"slots": [4, 6], "load_torque": [0.0, 1e-4]}])
def test_a_case_is_what_terminal_says(axes):
    drawn = {"method": "sobol", "size": 4} | FORMS
    study = sweep(TIMER, sample=drawn, **axes)
    plan = plan_from(TIMER, axes, sample=drawn)
    assert list(study.axes) == [*axes, "case"]
    assert study.axes["case"].tolist() == [0, 1, 2, 3]
    for case in range(plan.cases):
        sampled = {name: values[case % 4] for name, values in study.sampled.items()}
        assert sampled.items() <= plan.values(case).items()
    assert_as_alone(plan, study.results)


def many(size=40_000, **changes):
    """A plan of three blocks."""
    return plan_from(
        TIMER, {}, sample={"method": "latin-hypercube", "size": size} | FORMS | changes
    )


def test_the_file_and_its_bytes(tmp_path):
    paths = [tmp_path / f"{workers}.h5" for workers in (1, 3)]
    for workers, path in zip((1, 3), paths, strict=True):
        write_plan(many(), path, workers=workers)
    assert without_date(paths[0]) == without_date(paths[1])
    memory, read = run_plan(many(), workers=2), read_study(paths[0])
    assert list(read.sampled) == list(FORMS)
    for name in FORMS:
        np.testing.assert_array_equal(read.sampled[name], memory.sampled[name])
    for name in RESULTS:
        np.testing.assert_array_equal(read.results[name], memory.results[name])
    with h5py.File(paths[0]) as file:
        assert file["case"].is_scale
        assert file["case"].dtype == "<i8"
        for name in (*FORMS, *RESULTS):
            assert file[name].shape == (40_000,)
            assert file[name].dims[0][0].name == "/case"
            assert file[name].attrs["units"]
        assert json.loads(file.attrs["configuration"])["sample"]["seed"] == 0


def test_xarray_opens_a_sample_with_its_parameters_as_coordinates(tmp_path):
    drawn = {"method": "sobol", "size": 8} | FORMS
    study = sweep(TIMER, sample=drawn, slots=[4, 6], path=tmp_path / "a.h5")
    with xarray.open_dataset(tmp_path / "a.h5", engine="h5netcdf") as data:
        assert data.period.dims == ("slots", "case")
        assert set(FORMS) < set(data.period.coords)
        assert data.torque.dims == ("case",)
        assert data.torque.attrs["units"] == "N m"
        slow = data.period.sel(slots=6).where(data.friction > 0.25, drop=True)
        expected = study.results["period"][1][study.sampled["friction"] > 0.25]
        np.testing.assert_array_equal(slow, expected)


def interrupt(path):
    """A sample of which one block is finished."""

    def stop(done, total, failed):
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_plan(many(), path, progress=stop)
    return path


def test_numbers_drawn_otherwise_are_not_mixed(tmp_path, monkeypatch):
    """As another version of SciPy might draw them of the same seed."""
    path, draw = interrupt(tmp_path / "a.h5"), sample.unit_cube
    monkeypatch.setattr(sample, "unit_cube", lambda *given: draw(*given)[:, ::-1].copy())
    with pytest.raises(CannotCreate, match="whose results may differ"):
        write_plan(many(), path, resume=True)


STUDY = """
units = "in-lbf-s"
torque = 0.1
friction = 0.3
[mechanism]
slots = 4
[inertia]
driver = 3e-6
follower = 50e-6
[sample]
method = "sobol"
size = 16
friction = { tolerance = 0.05 }
torque = { relative_tolerance = 0.1 }
"""


@pytest.fixture
def study_file(tmp_path):
    """The configuration of a sample in the working folder."""
    (tmp_path / "s.toml").write_text(STUDY)


@pytest.mark.usefixtures("study_file")
def test_on_the_command_line(command, report, monkeypatch):
    record = report("sweep", "s.toml", "--quiet")
    assert (record["axes"], record["cases"]) == ({"case": 16}, 16)
    assert record["some_cases"][-1]["case"] == 15
    study = read_study("s.h5")
    assert record["some_cases"][0]["torque"] == study.sampled["torque"][0]
    assert study.units["torque"] == "in lbf"
    plan = parse_plan(study.configuration)
    assert plan.escapement(3).torque == study.sampled["torque"][3] * INCH_POUND
    shown = report("sweep", "s.toml", "--quiet", "--force", "--units", "SI")
    shown = shown["some_cases"][0]["torque"]
    study = read_study("s.h5")
    assert shown == pytest.approx(study.sampled["torque"][0] * INCH_POUND, rel=1e-15)
    # redone as it was stored, whatever this version would draw
    monkeypatch.setattr(sample, "unit_cube", None)
    again = report("run", "--from", "s.h5", "--select", "case=11")
    assert again["period"] == pytest.approx(study.results["period"][11], rel=1e-11)
    code, _, err = command("plot", "s.h5", "--units", "SI")
    assert (code, err) == (0, "escapement: study drawn in s.png\n")
