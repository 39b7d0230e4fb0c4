"""Kinds of mechanism: which kinds an option belongs to, in any order of the words typed."""

import argparse
import math
import sys
import types
from dataclasses import dataclass, field
from typing import Any, ClassVar

import pytest

from escapement import Escapement, GearDriven, Inertia, mechanisms, read_study
from escapement.base.errors import InvalidValue
from escapement.base.quantity import quantity
from escapement.cli import _arguments
from escapement.cli._arguments import Parser, UsageError
from escapement.mechanisms import Geneva
from escapement.mechanisms.kind import Kind
from escapement.study.parse import parse_plan, plan_from


@dataclass(frozen=True)
class Cam(Kind):
    """A kind that stands for another in every question but what it is made of."""

    kind = "cam-drive"
    summary = "a cam"
    report_units: ClassVar = {"lift": "length"}

    lift: float = field(metadata=quantity("height of the cam", "length"))
    pins: Any = field(default=None, metadata=quantity("not shown", whole=True, metavar="P"))

    def report(self):
        return {"stations": 4, "lift": self.lift}

    def __getattr__(self, name):
        return getattr(Geneva(4), name)


@pytest.fixture
def second_kind(monkeypatch):
    """Another kind of mechanism, which shares the pins of the Geneva wheel."""
    module = types.ModuleType("escapement.mechanisms.cam_drive")
    module.Cam = Cam
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(mechanisms.KINDS, "cam-drive", "cam_drive:Cam")


def understand(*argv):
    parser = Parser(prog="test")
    _arguments.add_common(parser)
    _arguments.add_mechanism(parser)
    args = parser.understand([*argv])
    assert isinstance(args, argparse.Namespace)
    return args


@pytest.mark.parametrize(
    "argv",
    [("cam-drive", "--slots", "5"), ("--slots", "5", "cam-drive"), ("--slots=4", "cam-drive")],
)
def test_an_option_of_another_kind_is_refused_by_name(second_kind, argv):
    words = r"--slots must not come with a cam-drive mechanism, got [45]; it belongs to geneva$"
    with pytest.raises(UsageError, match=words):
        _arguments.read_mechanism(understand(*argv))


@pytest.mark.parametrize(
    ("argv", "shown"), [(("--table", "a.csv"), "'a.csv'"), (("--lobes", "1/2"), "'1/2'")]
)
def test_such_an_option_is_shown_as_it_was_typed(argv, shown):
    with pytest.raises(UsageError, match=f"a geneva mechanism, got {shown}; it belongs"):
        _arguments.read_mechanism(understand(*argv))


@pytest.mark.parametrize("argv", [("--lift", "1"), ("--lift", "1", "geneva", "--slots", "4")])
def test_the_default_kind_refuses_too(second_kind, argv):
    with pytest.raises(UsageError, match=r"--lift .* a geneva mechanism.* belongs to cam-drive"):
        _arguments.read_mechanism(understand(*argv))


def test_a_shared_option_is_accepted_by_both(second_kind):
    assert _arguments.read_mechanism(understand("--pins", "2")).pins == 2
    args = understand("--pins", "3", "cam-drive", "--lift", "1")
    assert _arguments.read_mechanism(args) == Cam(1.0, 3)


def test_what_a_kind_needs_is_named(second_kind):
    args = understand("cam-drive", "--pins", "2")
    with pytest.raises(UsageError, match="required with cam-drive: --lift"):
        _arguments.read_mechanism(args)


def test_help_and_reports_know_every_kind(second_kind, command):
    for name in ("run", "mechanism", "index"):
        text = " ".join(command(name, "--help")[1].split())
        for kind in mechanisms.KINDS:
            assert f"{kind}: {mechanisms.kind_of(kind).summary}" in text
        assert "geneva, gear-driven, cam-drive: pins of the driver" in text
        assert "cam-drive: height of the cam" in text
    out = command("mechanism", "cam-drive", "--lift", "1", "--units", "in-lbf-s")[1]
    assert out.partition("\n\n")[2].split() == ["stations", "4", "lift", "1", "in"]


def test_a_study_says_to_which_kind_a_key_belongs(second_kind):
    study = {
        "mechanism": {"slots": 4, "lift": 1.0},
        "inertia": {"driver": 1.0, "follower": 1.0},
        "torque": 1.0,
        "sweep": {"friction": [0.1]},
    }
    words = r"'lift' in \[mechanism\]; it belongs in \[mechanism\] of kind 'cam-drive'$"
    with pytest.raises(InvalidValue, match=words):
        parse_plan(study)
    study["mechanism"] = {"kind": "cam-drive", "slots": 4}
    with pytest.raises(InvalidValue, match=r"'slots' .* of kind 'geneva'"):
        parse_plan(study)


@pytest.mark.parametrize(
    ("words", "named"),
    [(["geneva"], "KIND"), (["--slots", "4"], "--slots"), (["--internal"], "--internal")],
)
def test_a_mechanism_beside_a_study_is_refused(words, named, refusal):
    assert f"{named} must not come with --from" in refusal(2, "run", "--from", "study.h5", *words)


TWELVE = ["gear-driven", "--stations", "12", "--curve", "epicycloid"]


def test_gear_driven_report(report):
    """Figure 7 of Dijksman, and the same geometry in every solution."""
    record = report("mechanism", *TWELVE, "--lobes", "5")
    (solution,) = record.pop("solutions")
    del record["inputs"]
    assert record == solution
    assert record["stations"] == record["slots"] == 12
    assert record["gear_ratio"] == -2.0
    assert record["alpha_deg"] == record["follower_step_deg"] == 30.0
    assert record["motion_ratio"] == pytest.approx(1.0 / 6.0, rel=1e-15)
    assert record["cell_angle_deg"] == 180.0
    for key in ("arm_over_fixed", "entry_radius_over_fixed"):
        assert record[key] == pytest.approx(math.sqrt(0.75), rel=1e-15)
    assert record["carrier_over_fixed"] == 1.5
    assert record["closest_radius_over_fixed"] == pytest.approx(1.5 - math.sqrt(0.75), rel=1e-15)


def test_gear_driven_lengths(report):
    """With the radius of the fixed gear, here an inch, the report has lengths too."""
    inch = report(
        "mechanism", *TWELVE, "--lobes", "5", "--fixed-radius", "1", "--units", "in-lbf-s"
    )
    metre = report("mechanism", *TWELVE, "--lobes", "5", "--fixed-radius", "0.0254")
    expected = {"planet_radius": 0.5, "carrier": 1.5, "arm": math.sqrt(0.75)}
    for key, length in expected.items():
        assert inch[key] == pytest.approx(length, rel=1e-14)
        assert metre[key] == pytest.approx(0.0254 * length, rel=1e-14)
    assert inch["closest_radius"] == pytest.approx(inch["closest_radius_over_fixed"], rel=1e-14)


def test_gear_driven_solutions(command, report, tmp_path):
    options = ["--stations", "4", "--lobes", "0", "--curve", "epicycloid", "--pins", "6"]
    record = report("mechanism", "gear-driven", *options)
    first, second = record["solutions"]
    assert record["alpha_deg"] == first["alpha_deg"] < second["alpha_deg"] == 90.0
    assert (first["pins"], second["pins"]) == (6, 1)
    assert "solutions" in command("mechanism", "gear-driven", *options, "--plot", "a.png")[1]
    assert (tmp_path / "a.png").stat().st_size > 10_000


def test_gear_driven_study(tmp_path, report):
    """A sweep over lobes, a fraction among the fixed values, and one case of it again."""
    text = """
    friction = 0.05
    torque = 0.01
    [mechanism]
    kind = "gear-driven"
    stations = 12
    lobes = "5/1"
    curve = "epicycloid"
    pins = 2
    [inertia]
    driver = 3e-6
    follower = 5e-6
    [sweep]
    lobes = [5, 5.5]
    load_torque = [0.0, 1e-4]
    """
    (tmp_path / "g.toml").write_text(text)
    report("sweep", "g.toml", "--quiet")
    found = report("run", "--from", "g.h5", "--select", "lobes=5.5,load_torque=0")
    options = ["--lobes", "11/2", "--pins", "2", "--torque", ".01", "--friction", ".05"]
    options += ["--driver-inertia", "3e-6", "--follower-inertia", "5e-6"]
    again = report("run", *TWELVE, *options)
    assert found["velocity_max"] == pytest.approx(again["velocity_max"], rel=1e-12)
    study = read_study("g.h5")
    assert study.results["period"][1, 0] == pytest.approx(again["period"], rel=1e-10)


def test_gear_driven_study_from_python():
    drive = Escapement(
        GearDriven(5, "1/3", "epicycloid"), Inertia(3e-6, 5e-6), torque=0.01, friction=0.02
    )
    plan = plan_from(drive, {"torque": [0.01, 0.02]})
    assert parse_plan(plan.configuration).escapement(0).mechanism == drive.mechanism
