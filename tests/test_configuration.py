"""Study configurations: what they accept, what they refuse and how they say it."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from escapement.base.errors import EscapementError, InputFileError, InvalidValue, MissingInput
from escapement.base.units import INCH, INCH_POUND
from escapement.engines.solver import DEFAULT_ENGINE
from escapement.mechanisms import Geneva
from escapement.model.escapement import Escapement, Inertia
from escapement.study.parse import load_plan, parse_plan, plan_from

GOOD = {
    "mechanism": {"kind": "geneva", "slots": 4},
    "inertia": {"driver": 3e-6, "follower": 50e-6},
    "torque": 0.1,
    "sweep": {"friction": [0.2, 0.3]},
}
TIMER = Escapement(Geneva(slots=4), Inertia(3e-7, 5e-6), torque=0.01, friction=0.3)
RUNS = Path(__file__).parent.parent / "runs"


def changed(**changes):
    return {key: value for key, value in (GOOD | changes).items() if value is not ...}


def test_units_order_and_defaults():
    plan = parse_plan(
        changed(
            units="in-lbf-s",
            mechanism={"slots": 4, "crank_radius": 0.5},
            sweep={"torque": {"start": 0.08, "stop": 0.14, "num": 4}, "friction": 0.2},
            solver={"rtol": 1e-8},
        )
    )
    assert list(plan.dimensions) == ["torque", "friction"]
    assert plan.shape == (4, 1)
    assert plan.dimensions["torque"] == pytest.approx([0.08, 0.10, 0.12, 0.14], rel=1e-15)
    assert (plan.unit("torque"), plan.unit("friction")) == ("in lbf", "1")
    assert plan.solver.given == {"engine": DEFAULT_ENGINE, "rtol": 1e-8}
    case = plan.escapement(3)
    assert case.torque == 0.14 * INCH_POUND
    assert case.inertia == Inertia(3e-6 * INCH_POUND, 50e-6 * INCH_POUND)
    assert case.mechanism == Geneva(slots=4, crank_radius=0.5 * INCH)
    assert (case.friction, case.load_torque, plan.values(3)["initial_speed"]) == (0.2, 0.0, 0.0)


def test_every_number_of_the_model_can_be_an_axis():
    axes = {
        "friction": [0.1, 0.2],
        "torque": [0.1],
        "load_torque": [0.0, 0.01],
        "driver_inertia": [3e-6],
        "follower_inertia": [5e-5, 6e-5],
        "initial_speed": [0.0, 1.0],
        "slots": [3, 4.0],
        "pins": {"start": 1, "stop": 3, "num": 3},
    }
    plan = parse_plan({"sweep": axes})
    assert plan.shape == (2, 1, 2, 1, 2, 2, 2, 3)
    last = plan.escapement(plan.cases - 1)
    assert last.mechanism == Geneva(slots=4, pins=3)
    assert plan.dimensions["slots"].dtype == np.int64
    for start, stop in ((0, 5), (90, plan.cases)):
        columns = plan.columns(np.arange(start, stop))
        for row, case in enumerate(range(start, stop)):
            assert {n: c[row] for n, c in columns.items()}.items() <= plan.values(case).items()


def test_an_axis_replaces_its_fixed_value():
    plan = parse_plan(changed(sweep={"torque": [0.2]}, friction=0.3))
    assert plan.escapement(0).torque == 0.2
    assert "torque" not in plan.configuration


def test_pins_follow_an_axis_of_slots_unless_they_were_chosen():
    for mechanism, pins in ((Geneva(slots=4), (6, 4, 3)), (Geneva(slots=4, pins=2), (2, 2, 2))):
        escapement = Escapement(mechanism, Inertia(1.0, 1.0), torque=1.0)
        plan = plan_from(escapement, {"slots": [3, 4, 6]})
        assert tuple(plan.escapement(i).mechanism.pins for i in range(3)) == pins


def test_from_python_and_from_a_file_are_one_plan():
    plan = plan_from(TIMER, {"friction": np.linspace(0.1, 0.3, 3)}, rtol=1e-9, title="t")
    again = parse_plan(json.loads(json.dumps(plan.configuration)))
    assert again.configuration == plan.configuration
    assert [again.escapement(i) for i in range(3)] == [plan.escapement(i) for i in range(3)]


def test_a_mechanism_of_the_users_own_is_kept_as_it_is():
    class Mine(Geneva):
        pass

    escapement = Escapement(Mine(slots=5), Inertia(1.0, 1.0), torque=1.0)
    plan = plan_from(escapement, {"friction": [0.1]})
    assert plan.escapement(0).mechanism is escapement.mechanism
    assert "Mine" in json.dumps(plan.configuration)
    with pytest.raises(InvalidValue, match="unknown key 'slots'"):
        plan_from(escapement, {"slots": [3]})


def test_mechanisms_of_the_users_own_are_told_apart_by_their_numbers():
    class Mine(Geneva):
        __repr__ = object.__repr__  # with its place in memory

    plans = [
        plan_from(Escapement(mine, Inertia(1.0, 1.0), torque=1.0), {"friction": [0.1]})
        for mine in (Mine(5), Mine(5), Mine(6))
    ]
    assert plans[0].configuration == plans[1].configuration
    assert plans[0].configuration != plans[2].configuration
    assert "Mine object>, checksum" in plans[0].configuration["mechanism"]["description"]


STUDIES = sorted(path for path in RUNS.glob("*.toml") if path.stem != "thirty_seconds")  # a wish


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_the_studies_of_the_repository_are_valid(path):
    plan = load_plan(path)
    assert plan.cases == 1 or plan.escapement(0) != plan.escapement(plan.cases - 1)
    assert parse_plan(plan.configuration).configuration == plan.configuration


EVEN = {"start": 0.1, "stop": 0.3, "num": 3}
REFUSED = [
    ({"frictoin": 0.3}, "unknown key 'frictoin' at the top level; did you mean 'friction'?"),
    ({"slots": 4}, "unknown key 'slots' at the top level; it belongs in [mechanism]"),
    ({"driver_inertia": 1.0}, "it belongs in [inertia] as 'driver'"),
    ({"zzz": 4}, "unknown key 'zzz' at the top level; known are title, date,"),
    ({"inertia": {"driver": 1.0, "folower": 1.0}}, "'folower' in [inertia]; did you mean 'follow"),
    ({"mechanism": {"slots": 4, "pin": 4}}, "'pin' in [mechanism]; did you mean 'pins'?"),
    ({"solver": {"rtoll": 1}}, "unknown key 'rtoll' in [solver]; did you mean 'rtol'?"),
    ({"sweep": {"frction": [1]}}, "unknown key 'frction' in [sweep]; did you mean 'friction'?"),
    ({"sweep": {"crank_radius": [1]}}, "'crank_radius' in [sweep]; it belongs in [mechanism]"),
    ({"sweep": {"rtol": [1e-6]}}, "unknown key 'rtol' in [sweep]; it belongs in [solver]"),
    ({"sweep": {"friction": EVEN | {"nun": 3}}}, "'nun' in axis friction; did you mean 'num'?"),
    ({"torque": ...}, "the study lacks torque (driving torque); give"),
    ({"inertia": {}}, "lacks inertia.driver (moment of inertia of the driver), inertia.follower"),
    ({"mechanism": ...}, "the study lacks mechanism.slots (slots"),
    ({"sweep": ...}, "the study must sweep at least one parameter, got none; add an axis"),
    ({"mechanism": 4}, "mechanism must be a table, got 4; write [mechanism]"),
    ({"mechanism": {"kind": "genva", "slots": 4}}, "mechanism.kind must be one of geneva, "),
    ({"title": "two\nlines"}, "title must be one line of text"),
    ({"sweep": {"friction": []}}, "friction must have at least one value, got an empty axis"),
    ({"sweep": {"friction": [0.1, -0.2]}}, "friction[1] must be at least 0, got -0.2"),
    ({"sweep": {"friction": [0.1, "0.2"]}}, "friction[1] must be a finite number, got '0.2'"),
    ({"sweep": {"friction": "0.1"}}, "friction[0] must be a finite number, got '0.1'"),
    ({"sweep": {"torque": {"start": 1}}}, "torque.stop must be a finite number, got None"),
    ({"sweep": {"torque": EVEN | {"num": 0}}}, "torque.num must be a whole number of at least 2"),
    ({"sweep": {"torque": EVEN | {"start": "a"}}}, "torque.start must be a finite number"),
    ({"sweep": {"torque": EVEN | {"log": 1}}}, "torque.log must be true or false, got 1"),
    (
        {"sweep": {"friction": EVEN | {"start": 0.0, "log": True}}},
        "friction.start must be greater than 0, got 0.0; a logarithmic axis",
    ),
    (
        {"sweep": {"slots": {"start": 3, "stop": 4, "num": 3}}},
        "slots[1] must be a whole number of at least 3, got 3.5",
    ),
    (
        {"sweep": dict.fromkeys(("friction", "torque"), EVEN | {"num": 2 * 10**6})},
        "the grid must have at most 1e+12 cases, got 4e+12",
    ),
    ({"sweep": {"friction": np.zeros((2, 2))}}, "friction[0] must be a finite number, got [0.0"),
    ({"sweep": {"friction": np.ma.array([0.1, 0.2], mask=[0, 1])}}, "friction[1] must be a finite"),
    ({"solver": {"engine": "ivp", "atol": 10}}, "atol must be at most 1 unless max_step is given"),
]


@pytest.mark.parametrize(("changes", "message"), REFUSED, ids=[m for _, m in REFUSED])
def test_a_refusal_is_one_line_that_helps(changes, message):
    with pytest.raises(InvalidValue) as caught:
        parse_plan(changed(**changes))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 2


@pytest.mark.parametrize("lobes", [[1, 100001], [0.1234567], [1, "1/2000"]])
def test_lobes_are_refused_before_anything_is_computed(lobes):
    machine = {"kind": "gear-driven", "curve": "epicycloid", "stations": 5}
    with pytest.raises(InvalidValue, match=r"lobes\[\d\] must be"):
        parse_plan(GOOD | {"mechanism": machine, "sweep": {"lobes": lobes}})


@pytest.mark.parametrize(
    ("content", "error", "message"),
    [
        (None, MissingInput, "does not exist; check its name"),
        ("torque = 1\nfriction 3\n", InputFileError, "got in line 2: friction 3 ("),
        (b"torque = 1\n\xff\xfe = 2\n", InputFileError, "got in line 2: ÿþ = 2 ("),
        ("a = " + "[" * 100_000, InputFileError, "must be valid TOML"),
        ("torque = 1979-05-27\n[sweep]\nfriction=[1]", InvalidValue, "torque must be a finite"),
        ("", InvalidValue, "must sweep at least one parameter"),
    ],
)
def test_unusable_files_are_told_from_bad_values(tmp_path, content, error, message):
    path = tmp_path / "study.toml"
    if content is not None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(EscapementError) as caught:
        load_plan(path)
    assert type(caught.value) is error
    assert str(path) in str(caught.value)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_engine_is_loaded_to_read_a_configuration():
    code = (
        "import sys; from escapement.study.parse import load_plan\n"
        f"load_plan({str(RUNS / 'meyer_four_pins.toml')!r})\n"
        "assert not {'numba', 'scipy', 'h5py'} & set(sys.modules), 'loaded too much'"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@settings(deadline=None)
@given(st.floats(1e-9, 1e9), st.floats(1e-9, 1e9), st.integers(2, 50), st.booleans())
def test_even_steps_reach_both_ends(start, stop, num, log):
    form = {"start": start, "stop": stop, "num": num, "log": log}
    values = parse_plan(changed(sweep={"torque": form})).dimensions["torque"]
    assert (values.size, values[0], values[-1]) == (num, start, stop)
    scale = np.log if log else np.asarray
    step = (scale(stop) - scale(start)) / (num - 1)
    np.testing.assert_allclose(np.diff(scale(values)), step, atol=1e-9 * max(1.0, start, stop))


def test_powers_of_two_are_whole():
    form = {"start": 4, "stop": 64, "num": 5, "log": True}
    slots = parse_plan(changed(sweep={"slots": form})).dimensions["slots"]
    assert slots.tolist() == [4, 8, 16, 32, 64]
