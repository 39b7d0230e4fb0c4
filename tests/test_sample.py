"""Samples: drawn as asked for, one case each, stored and continued like a grid."""

import json
from statistics import NormalDist

import h5py
import numpy as np
import pytest
import xarray

import escapement as esc
from escapement import simulation
from escapement.configuration import _sample, parse_plan, plan_from
from escapement.errors import CannotCreate, InvalidValue
from escapement.store import RESULTS, read_study
from escapement.sweeping import run_plan, sweep, write_plan
from escapement.units import INCH_POUND

TIMER = esc.Escapement(esc.Geneva(slots=4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113, 0.3)
GOOD = {
    "mechanism": {"slots": 4},
    "inertia": {"driver": 3e-6, "follower": 50e-6},
    "torque": 0.1,
    "friction": 0.3,
}
EVEN = {"low": 0.2, "high": 0.3}


def sample(method="latin-hypercube", size=64, **parameters):
    """Values of a sample around `GOOD`."""
    return parse_plan(GOOD | {"sample": {"method": method, "size": size} | parameters}).sample


@pytest.mark.parametrize("method", ["latin-hypercube", "sobol"])
def test_every_stratum_of_every_parameter_holds_one_case(method):
    drawn = sample(
        method,
        friction=EVEN,
        torque={"relative_tolerance": 0.1},
        driver_inertia={"low": 1e-6, "high": 8e-6, "log": True},
        follower_inertia={"relative_standard_deviation": 0.02},
        initial_speed={"low": 0.0, "high": 5.0},
    )
    values = drawn.values
    normal = NormalDist(50e-6, 1e-6)
    shares = {
        "friction": (values["friction"] - 0.2) / 0.1,
        "torque": (values["torque"] - 0.09) / 0.02,
        "driver_inertia": np.log(values["driver_inertia"] / 1e-6) / np.log(8.0),
        "follower_inertia": np.array([normal.cdf(v) for v in values["follower_inertia"]]),
        "initial_speed": values["initial_speed"] / 5.0,
    }
    for name, share in shares.items():
        assert sorted(np.floor(share * 64).astype(int)) == list(range(64)), name


def test_sobol_fills_every_elementary_box_of_a_plane():
    """A net in base 2: boxes of area 1/64, however shaped, hold one point each."""
    values = sample("sobol", friction=EVEN, torque={"low": 1.0, "high": 2.0}).values
    x, y = (values["friction"] - 0.2) / 0.1, values["torque"] - 1.0
    for power in range(7):
        boxes = np.floor(x * 2**power) * 2 ** (6 - power) + np.floor(y * 2 ** (6 - power))
        assert len(set(boxes)) == 64, power


def test_a_normal_distribution_can_be_cut_off():
    cut = {"standard_deviation": 0.1, "low": 0.25, "high": 0.5}
    values = sample(friction=cut).values["friction"]
    normal = NormalDist(0.3, 0.1)
    below, above = normal.cdf(0.25), normal.cdf(0.5)
    share = (np.array([normal.cdf(v) for v in values]) - below) / (above - below)
    assert sorted(np.floor(share * 64).astype(int)) == list(range(64))
    assert values.min() >= 0.25
    assert values.max() <= 0.5


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"relative_tolerance": 0.1}, {"tolerance": 0.03}),
        ({"tolerance": 0.03}, {"low": 0.27, "high": 0.33}),
        ({"relative_standard_deviation": 0.1}, {"standard_deviation": 0.03}),
    ],
)
def test_two_ways_to_say_the_same(one, other):
    values = [sample(friction=form).values["friction"] for form in (one, other)]
    np.testing.assert_allclose(*values, rtol=1e-14)


def test_the_seed_decides_and_is_always_recorded():
    one, again, other = (sample(friction=EVEN, **seed) for seed in ({}, {"seed": 0}, {"seed": 1}))
    assert one.form["seed"] == 0
    np.testing.assert_array_equal(one.values["friction"], again.values["friction"])
    assert not np.isin(one.values["friction"], other.values["friction"]).any()
    assert one.fingerprint == again.fingerprint != other.fingerprint


def test_a_list_is_taken_case_by_case():
    lists = {"friction": [0.1, 0.2, 0.3], "slots": [4, 3, 6], "torque": [0.1, 0.2, 0.4]}
    plan = parse_plan(GOOD | {"sample": {"method": "list"} | lists})
    assert plan.shape == (3,)
    assert [plan.escapement(i).mechanism.slots for i in range(3)] == lists["slots"]
    assert [plan.escapement(i).torque for i in range(3)] == lists["torque"]
    even = {"method": "list", "friction": {"start": 0.1, "stop": 0.3, "num": 3}, "slots": [4, 3, 6]}
    values = parse_plan(GOOD | {"sample": even}).sample.values
    np.testing.assert_array_equal(values["friction"], np.linspace(0.1, 0.3, 3))


@pytest.mark.parametrize("method", ["latin-hypercube", "sobol", "list"])
@pytest.mark.parametrize("axes", [{}, {"slots": [3, 4]}])
def test_a_plan_is_what_its_configuration_says(method, axes):
    forms = {"friction": EVEN, "torque": {"tolerance": 0.01}}
    if method == "list":
        forms = {"friction": [0.2, 0.3], "torque": [0.1, 0.2]}
    else:
        forms |= {"size": 8, "seed": 5}
    plan = parse_plan(GOOD | {"sweep": axes, "sample": {"method": method} | forms})
    again = parse_plan(json.loads(json.dumps(plan.configuration)))
    assert again.configuration == plan.configuration
    assert again.fixed == plan.fixed
    assert ("torque" in plan.fixed) == (method != "list")  # the nominal value
    for case in range(plan.cases):
        assert again.values(case) == plan.values(case)


REFUSED = [
    ({}, "the sample lacks a method; give one of latin-hypercube, sobol, list"),
    ({"method": "sobl", "friction": EVEN}, "sample.method must be one of latin-hypercube, sobol"),
    ({"method": "sobol", "friction": EVEN}, "the sample lacks size; give the number of cases"),
    ({"size": 4}, "the sample must vary at least one parameter, got none"),
    ({"size": 0, "friction": EVEN}, "sample.size must be a whole number of at least 1, got 0"),
    ({"size": 2.5, "friction": EVEN}, "sample.size must be a whole number of at least 1, got 2.5"),
    ({"size": 10**8, "friction": EVEN}, "sample.size must be at most 10000000, got 100000000"),
    (
        {"method": "sobol", "size": 1000, "friction": EVEN},
        "sample.size must be a power of two with method 'sobol', whose points are even only then, "
        "got 1000; give 512 or 1024",
    ),
    ({"size": 4, "seed": -1, "friction": EVEN}, "sample.seed must be a whole number of at least 0"),
    ({"size": 4, "seed": 2**63, "friction": EVEN}, "sample.seed must be below 2^63"),
    ({"sise": 4, "friction": EVEN}, "unknown key 'sise' in [sample]; did you mean 'size'?"),
    ({"size": 4, "frction": EVEN}, "unknown key 'frction' in [sample]; did you mean 'friction'?"),
    ({"size": 4, "friction": EVEN | {"hi": 1}}, "unknown key 'hi' in sample.friction; did you"),
    ({"size": 4, "friction": 0.1}, "sample.friction must be a table that says how it spreads"),
    ({"size": 4, "friction": {"low": 0.1}}, "sample.friction lacks high; write { low = ..., high"),
    ({"size": 4, "friction": {"low": 0.3, "high": 0.2}}, "high must be greater than low = 0.3"),
    ({"size": 4, "friction": {"low": -0.1, "high": 0.2}}, "sample.friction.low must be at least 0"),
    ({"size": 4, "friction": EVEN | {"tolerance": 1}}, "sample.friction.low must be left out with"),
    ({"size": 4, "friction": {"tolerance": 0.4}}, "the lowest value of sample.friction must be at"),
    ({"size": 4, "friction": {"tolerance": 0}}, "sample.friction.tolerance must be greater than 0"),
    ({"size": 4, "friction": EVEN | {"log": 1}}, "sample.friction.log must be true or false"),
    (
        {"size": 4, "friction": {"low": 0.0, "high": 0.2, "log": True}},
        "sample.friction.low must be greater than 0, got 0.0; a logarithmic spread",
    ),
    ({"size": 4, "friction": {"tolerance": 0.1, "log": True}}, "sample.friction.log must be left"),
    (
        {"size": 4, "friction": {"tolerance": 0.1, "relative_tolerance": 0.1}},
        "sample.friction must be spread in one way, got 'tolerance and relative_tolerance'",
    ),
    (
        {"size": 64, "friction": {"standard_deviation": 0.2}},
        "cut its distribution off with low or high",
    ),
    (
        {"size": 4, "friction": {"standard_deviation": 0.1, "low": 0.4}},
        "sample.friction must have its nominal value between low and high, got 0.3",
    ),
    (
        {"size": 4, "load_torque": {"relative_tolerance": 0.1}},
        "must be a part of a nominal value other than 0, got 0; give tolerance in its own unit",
    ),
    ({"size": 4, "slots": EVEN}, "whole numbers are not drawn at random; write slots in [sweep]"),
    ({"method": "list", "size": 2, "friction": [1]}, 'sample.size must be left out with method'),
    (
        {"method": "list", "friction": [0.1, 0.2], "torque": [1.0]},
        "sample.torque must have as many values as friction, got 1 and 2",
    ),
    ({"method": "list", "friction": [0.1, -0.2]}, "friction[1] must be at least 0, got -0.2"),
    (7, "sample must be a table, got 7"),
]  # fmt: skip


@pytest.mark.parametrize(("table", "message"), REFUSED, ids=[m for _, m in REFUSED])
def test_a_refusal_is_one_line_that_helps(table, message):
    if isinstance(table, dict) and table and "method" not in table:
        table = {"method": "latin-hypercube"} | table
    with pytest.raises(InvalidValue) as caught:
        parse_plan(GOOD | {"sample": table})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_missing_or_said_twice():
    lacking = {key: value for key, value in GOOD.items() if key != "torque"}
    drawn = {"method": "sobol", "size": 4}
    with pytest.raises(InvalidValue, match="nominal value to spread around, got none; give torque"):
        parse_plan(lacking | {"sample": drawn | {"torque": {"tolerance": 0.01}}})
    assert parse_plan(lacking | {"sample": drawn | {"torque": EVEN}}).cases == 4
    with pytest.raises(InvalidValue, match=r"friction must be in \[sweep\] or in \[sample\], got"):
        parse_plan(GOOD | {"sweep": {"friction": [0.1]}, "sample": drawn | {"friction": EVEN}})
    with pytest.raises(
        InvalidValue, match=r"unknown key 'size' at the top level; it belongs in \["
    ):
        parse_plan(GOOD | {"size": 4})


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
        alone = simulation.terminal(plan.escapement(case))
        sampled = {name: values[case % 4] for name, values in study.sampled.items()}
        assert sampled.items() <= plan.values(case).items()
        for name in RESULTS:
            value = study.results[name].reshape(-1)[case]
            assert value == pytest.approx(getattr(alone, name), rel=1e-11), name


def test_a_list_that_repeats_a_scene_solves_it_once(monkeypatch):
    from escapement.engines import _energy_batch

    counted = []
    solve = _energy_batch.solve

    def count(mechanism, rho, *rest):
        counted.append(rho.size)
        return solve(mechanism, rho, *rest)

    monkeypatch.setattr(_energy_batch, "solve", count)
    lists = {"friction": [0.1, 0.2, 0.1, 0.2], "torque": [0.01, 0.01, 0.02, 0.02]}
    study = sweep(TIMER, sample={"method": "list"} | lists)
    assert counted == [2]
    assert study.results["period"][0] == pytest.approx(
        study.results["period"][2] * 2**0.5, rel=1e-14
    )
    sweep(TIMER, sample={"method": "list", "torque": [0.01, 0.02, 0.03]})
    assert counted == [2, 1]


def many(size=40_000, **changes):
    """A plan of three blocks."""
    return plan_from(
        TIMER, {}, sample={"method": "latin-hypercube", "size": size} | FORMS | changes
    )


def without_date(path):
    created = read_study(path).attributes["created"].encode()
    return path.read_bytes().replace(created, b"0" * len(created))


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
        assert json.loads(file["configuration"].asstr()[()])["sample"]["seed"] == 0


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


def test_an_interrupted_sample_is_continued(tmp_path):
    path = tmp_path / "a.h5"

    def stop(done, total, failed):
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_plan(many(), path, progress=stop)
    with pytest.raises(CannotCreate, match=r"sample\.seed was 0 and is 1"):
        write_plan(many(seed=1), path, resume=True)
    tally = write_plan(many(), path, resume=True)
    assert 0 < tally.resumed < 40_000
    write_plan(many(), tmp_path / "b.h5")
    assert without_date(path) == without_date(tmp_path / "b.h5")


def test_numbers_drawn_otherwise_are_not_mixed(tmp_path, monkeypatch):
    """As another version of SciPy might draw them of the same seed."""

    def stop(done, total, failed):
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_plan(many(), tmp_path / "a.h5", progress=stop)
    draw = _sample._unit_cube
    monkeypatch.setattr(_sample, "_unit_cube", lambda *given: draw(*given)[:, ::-1].copy())
    with pytest.raises(CannotCreate, match="whose results may differ"):
        write_plan(many(), tmp_path / "a.h5", resume=True)


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
    assert shown == pytest.approx(study.sampled["torque"][0] * INCH_POUND, rel=1e-15)
    # redone as it was stored, whatever this version would draw
    monkeypatch.setattr(_sample, "_unit_cube", None)
    again = report("run", "--from", "s.h5", "--select", "case=11")
    assert again["period"] == pytest.approx(study.results["period"][11], rel=1e-11)
    code, _, err = command("plot", "s.h5", "--units", "SI")
    assert (code, err) == (0, "escapement: study drawn in s.png\n")


@pytest.mark.parametrize(
    ("selection", "message"),
    [
        ("", "--select must choose one of the 16 values of case in s.h5, got none; add case=0"),
        ("case=16", "case must be one of the 16 cases of s.h5, got 16; they are numbered from 0"),
        ("case=-1", "case must be one of the 16 cases of s.h5, got -1"),
        ("case=1.5", "case must be a whole number, got 1.5"),
        ("case=nan", "case must be a whole number, got nan"),
        ("case=1,torque=0.1", "--select must name axes of s.h5, got 'torque'; it has case"),
    ],
)
@pytest.mark.usefixtures("study_file")
def test_a_selection_that_names_no_case(command, refusal, selection, message):
    command("sweep", "s.toml", "--quiet")
    assert message in refusal(2, "run", "--from", "s.h5", "--select", selection)


def test_other_kinds_of_mechanism_scatter_alike():
    """A mechanism of its own in every case, and the loss of a mesh."""
    drawn = {"method": "latin-hypercube", "size": 5, "sun_radius": {"relative_tolerance": 0.01}}
    drawn |= {"efficiency": {"low": 0.85, "high": 0.95}, "torque": {"relative_tolerance": 0.1}}
    machine = {"kind": "elliptical-planetary", "sun_radius": 0.016, "planet_radius": 0.009}
    plan = parse_plan(
        {
            "torque": 0.01,
            "mechanism": machine,
            "inertia": {"driver": 1e-6, "follower": 1e-6},
            "sample": drawn,
        }
    )
    assert len({plan.escapement(i).mechanism.cell_angle for i in range(5)}) == 5
    study = run_plan(plan)
    for case in range(5):
        alone = simulation.terminal(plan.escapement(case))
        for name in RESULTS:
            value = study.results[name][case]
            assert value == pytest.approx(getattr(alone, name), rel=1e-11), name


def test_fractions_are_not_drawn():
    machine = {"kind": "gear-driven", "curve": "hypocycloid", "stations": 5, "lobes": "1/2"}
    with pytest.raises(InvalidValue, match=r"sample\.lobes must be left out, fractions are not"):
        parse_plan(
            GOOD | {"mechanism": machine, "sample": {"method": "sobol", "size": 4, "lobes": EVEN}}
        )
