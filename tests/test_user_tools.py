"""Studies and motions in other tools: xarray, pandas, NumPy and tables."""

import json
import pickle
import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

import escapement as esc
from crash_tools import NAMES
from escapement.base.errors import CannotCreate, InputFileError, InvalidValue, MissingPackage
from escapement.study.reader import read_configuration
from escapement.study.table_files import read_rows
from study_tools import TIMER, study

OLD = Path(__file__).parent / "reference" / "schema_1"
ENGINES = ["h5netcdf", *["netcdf4"] * (find_spec("netCDF4") is not None)]
"""Libraries with which xarray opens a file here."""
SAMPLE = {"method": "sobol", "size": 8, "friction": {"tolerance": 0.02}}
GRID = {"friction": [0.0, 0.2, 0.5], "torque": np.linspace(0.01, 0.02, 70)}
SCENES = {
    "grid": (TIMER, GRID),
    "sample": (TIMER, {"sample": SAMPLE, "torque": [0.01, 0.02]}),
    "one": (TIMER, {"slots": [4]}),
    "chosen": (TIMER, {"friction": [0.1, 0.5], "results": ["jam_margin", "contact_moment_max"]}),
    "sizes": (replace(TIMER, mechanism=esc.Geneva(4, crank_radius=0.02)), {"pin_radius": [0.001]}),
    "table": (
        esc.Escapement(
            esc.Tabulated(np.linspace(0.0, 1.5, 601), np.linspace(0.0, 1.0, 601)),
            TIMER.inertia,
            0.01,
            efficiency=0.9,
        ),
        {"load_torque": [0.001, 0.002]},
    ),
}


@pytest.fixture(params=SCENES)
def scene(request):
    return SCENES[request.param]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_study_is_to_xarray_what_its_file_is(tmp_path, scene, engine):
    timer, varied = scene
    written = esc.sweep(timer, **varied, path=tmp_path / "a.h5")
    with xarray.open_dataset(tmp_path / "a.h5", engine=engine) as opened:
        assert esc.read_study(tmp_path / "a.h5").to_xarray().identical(opened)
        assert written.to_xarray().identical(opened)
        assert esc.sweep(timer, **varied).to_xarray().equals(opened)
        assert set(opened.data_vars) == set(written.results)
        assert opened.driver_inertia.attrs["units"] == "kg m2"
        assert opened.driver_inertia == timer.inertia.driver
        assert opened.attrs["Conventions"].startswith("CF-")


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_motion_is_to_xarray_what_its_file_is(tmp_path, engine, friction):
    timer = esc.Escapement(
        esc.Geneva(3, pins=1, crank_radius=0.02), TIMER.inertia, 0.01, friction=friction
    )
    motion = esc.simulate(timer, 2)
    esc.write_motion(motion, tmp_path / "a.h5")
    ours = motion.to_xarray()
    with xarray.open_dataset(tmp_path / "a.h5", engine=engine) as opened:
        assert set(ours.variables) == set(opened.variables)
        assert all(ours[name].identical(opened[name]) for name in ours.variables)
        assert ours.attrs.items() <= opened.attrs.items()
    frame = motion.to_dataframe()
    np.testing.assert_array_equal(frame.index, motion.t)
    np.testing.assert_array_equal(frame.contact_force, motion.contact_force)
    assert frame.attrs["units"]["theta_ddot"] == "rad s-2"
    esc.write_motion(motion, tmp_path / "a.csv")
    table = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table, frame.reset_index().to_numpy())


@pytest.mark.parametrize("name", NAMES[1:])
def test_a_table_holds_every_number_exactly(tmp_path, scene, name):
    timer, varied = scene
    path, memory = tmp_path / name, esc.sweep(timer, **varied)
    written = esc.sweep(timer, **varied, path=path)
    assert written.to_xarray().equals(memory.to_xarray())
    frame = memory.to_dataframe()
    columns = frame.reset_index()
    if name.endswith(".csv"):
        assert path.read_text().partition("\n")[0] == ",".join(columns)
        table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
        np.testing.assert_array_equal(table, columns.to_numpy())
    else:
        import pandas

        table = pandas.read_parquet(path)
        pandas.testing.assert_frame_equal(table, columns)
        assert table.attrs.keys() == frame.attrs.keys()
        assert table.attrs["units"] == memory.units
    rows = read_rows(path)
    path.unlink()
    esc.write_study(memory, path)
    again = read_rows(path)
    assert list(again) == list(rows) == list(columns)
    for key, values in rows.items():
        np.testing.assert_array_equal(again[key], values)


@pytest.mark.parametrize("name", NAMES)
def test_a_complete_file_of_the_same_study_is_left_alone(tmp_path, name):
    path = tmp_path / name
    esc.sweep(TIMER, **GRID, path=path)
    before = path.read_bytes(), path.stat().st_mtime_ns
    esc.sweep(TIMER, **GRID, path=path, resume=True)
    other = replace(TIMER, load_torque=1e-3)
    with pytest.raises(CannotCreate, match="must be of this study to be resumed") as caught:
        esc.sweep(other, **GRID, path=path, resume=True)
    assert "\n" not in str(caught.value)
    assert (path.read_bytes(), path.stat().st_mtime_ns) == before
    esc.sweep(other, **GRID, path=path, resume=True, force=True)
    assert path.read_bytes() != before[0]
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["a.txt", "a", "a.CSVX", "a.h5.gz"])
def test_a_file_of_no_format_is_refused_before_anything_is_solved(tmp_path, name, monkeypatch):
    monkeypatch.setattr("escapement.study.running._run", None)
    with pytest.raises(InvalidValue, match=r"must end in \.h5, \.hdf5, \.nc, \.csv, \.parquet,"):
        esc.sweep(TIMER, **GRID, path=tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_the_command_writes_what_the_name_says(tmp_path, report, monkeypatch):
    monkeypatch.chdir(tmp_path)
    axes = "friction = [0.1, 0.2, 0.3]\ntorque = { start = 0.01, stop = 0.02, num = 50 }"
    text = f"[mechanism]\nslots = 4\n[inertia]\ndriver = 3e-7\nfollower = 6e-6\n[sweep]\n{axes}\n"
    Path("s.toml").write_text(text)
    tables, names = NAMES[1:], [*NAMES, "b.nc", "b.HDF5"]
    reports = [report("sweep", "s.toml", "--quiet", "-o", name) for name in names]
    assert len({json.dumps(found["some_cases"]) for found in reports}) == 1
    assert [name for name in names if not h5py.is_hdf5(name)] == tables


@pytest.mark.parametrize(
    ("package", "call"),
    [
        ("xarray", lambda: study().to_xarray()),
        ("pandas", lambda: study().to_dataframe()),
        ("xarray", lambda: esc.simulate(TIMER, 1).to_xarray()),
        ("pandas", lambda: esc.simulate(TIMER, 1).to_dataframe()),
        ("pyarrow", lambda: esc.sweep(TIMER, **GRID, path="a.parquet")),
    ],
)
def test_a_package_that_is_missing_is_told_in_a_line(tmp_path, monkeypatch, package, call):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingPackage) as caught:
        call()
    assert f"needs {package}, which is not installed; install it in a clone" in str(caught.value)
    assert caught.value.exit_code == 2
    assert list(tmp_path.iterdir()) == []


# --- arrays of a file ------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["axes", "sampled", "results"])
def test_a_column_of_a_file_is_a_numpy_array(tmp_path, kind):
    whole = esc.sweep(TIMER, sample=SAMPLE, torque=[0.01, 0.02, 0.03])
    esc.write_study(whole, tmp_path / "a.h5")
    found = esc.read_study(tmp_path / "a.h5")
    columns = getattr(found, kind)
    assert [*columns] == [*getattr(whole, kind)]
    assert "torque" in found.axes
    assert "periode" not in columns
    part, same = found.at(torque=0.02), pickle.loads(pickle.dumps(found))
    for name, values in columns.items():
        assert type(values) is np.ndarray
        assert values is columns[name]
        np.testing.assert_array_equal(values, whole[name])
        np.testing.assert_array_equal(same[name], values)
        np.testing.assert_array_equal(part[name], whole.at(torque=0.02)[name])
        np.testing.assert_array_equal(part.at(torque=0.02)[name], part[name])


def test_a_file_that_was_replaced_is_not_mixed_with_the_one_before(tmp_path):
    esc.write_study(study((4,), seed=1), tmp_path / "a.h5")
    before = esc.read_study(tmp_path / "a.h5")
    period = before["period"][:].copy()
    esc.write_study(study((4,), seed=2), tmp_path / "a.h5", force=True)
    for other in (before, before.at(friction=0.1)):
        with pytest.raises(InputFileError, match="was replaced since; read it again"):
            _ = other["rise_time"]
    assert not np.array_equal(esc.read_study(tmp_path / "a.h5")["period"], period, equal_nan=True)


def test_names(tmp_path):
    found = study((3, 5))
    assert [found[name] is found.columns[name] for name in found.columns] == [True] * 11
    assert found["driver_inertia"] == 3e-6
    with pytest.raises(InvalidValue, match="did you mean 'period'"):
        found["periode"]


# --- configuration, and files of the version before ------------------------------------------


def test_long_axes_are_named_in_the_configuration(tmp_path):
    esc.sweep(TIMER, **GRID, path=tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        swept = json.loads(file.attrs["configuration"])["sweep"]
    assert swept["friction"] == GRID["friction"]
    assert (swept["torque"]["dataset"], swept["torque"]["size"]) == ("torque", 70)
    assert read_configuration(tmp_path / "a.h5")["sweep"]["torque"] == GRID["torque"].tolist()
    other = GRID | {"torque": np.nextafter(GRID["torque"], 1.0)}
    with pytest.raises(CannotCreate, match=r"sweep\.torque\.checksum was"):
        esc.sweep(TIMER, **other, path=tmp_path / "a.h5", resume=True)


@pytest.mark.parametrize("name", ["grid.h5", "sample.h5"])
def test_a_study_of_the_version_before_reads_the_same(name, tmp_path):
    found = esc.read_study(OLD / name)
    assert found.fixed == {}
    with h5py.File(OLD / name) as file:
        assert found.configuration == json.loads(file["configuration"].asstr()[()])
        assert found.attributes == dict(file.attrs)
        assert found.columns.keys() == file.keys() - {"configuration"}
        for key, values in found.columns.items():
            np.testing.assert_array_equal(values, file[key][()])
            assert found.units[key] == file[key].attrs["units"]
            assert found.long_names[key] == file[key].attrs["long_name"]
    assert list(found.axes) == {"g": ["friction", "torque"], "s": ["slots", "case"]}[name[0]]
    esc.write_study(found, tmp_path / "new.h5")
    assert esc.read_study(tmp_path / "new.h5").to_xarray().identical(found.to_xarray())


def test_a_motion_of_the_version_before_reads_the_same():
    found = esc.read_motion(OLD / "motion.h5")
    with h5py.File(OLD / "motion.h5") as file:
        assert found.end_time == file.attrs["end_time"]
        np.testing.assert_array_equal(found.extrema.theta, file["extremum_theta"][()])
        states = found.at(file["t"][()])
        np.testing.assert_allclose(states.theta_dot, file["theta_dot"][()], rtol=1e-10, atol=1e-9)
