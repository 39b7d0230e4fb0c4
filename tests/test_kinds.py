"""Kinds of mechanism: an option belongs to its kinds, in whatever order things are typed."""

import argparse
import sys
import types

import pytest

from escapement.cli import _kinds, main
from escapement.cli._parser import Parser, UsageError, number, whole
from escapement.configuration import parse_plan
from escapement.configuration._kinds import KINDS, Kind
from escapement.configuration._parameters import Parameter
from escapement.errors import InvalidValue
from escapement.mechanisms import Geneva


@pytest.fixture
def second_kind(monkeypatch):
    """Another kind of mechanism, which shares the pins of the Geneva wheel."""
    module = types.ModuleType("escapement.cli._kind_cam_drive")
    module.OPTIONS = {
        "pins": {"type": whole("--pins", 1, ""), "metavar": "P", "help": "not shown"},
        "lift": {"type": number("--lift", lambda name, x, _: x, ""), "help": "height of the cam"},
    }
    module.QUANTITIES = {"lift": "length"}
    module.read = lambda args: Geneva(4, pins=1, crank_radius=args.lift)
    module.describe = lambda mechanism: {"stations": 4, "lift": mechanism.crank_radius}
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(_kinds.KINDS, "cam-drive", "a cam")


def understand(*argv):
    parser = Parser(prog="test")
    _kinds.add_mechanism(parser)
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
        _kinds.read_mechanism(understand(*argv))


@pytest.mark.parametrize("argv", [("--lift", "1"), ("--lift", "1", "geneva", "--slots", "4")])
def test_the_default_kind_refuses_too(second_kind, argv):
    with pytest.raises(UsageError, match=r"--lift .* a geneva mechanism.* belongs to cam-drive"):
        _kinds.read_mechanism(understand(*argv))


def test_a_shared_option_is_accepted_by_both(second_kind):
    assert _kinds.read_mechanism(understand("--pins", "2")).pins == 2
    assert _kinds.read_mechanism(understand("--pins", "2", "cam-drive")).pins == 1


def test_what_a_kind_needs_is_named(second_kind):
    args = understand("cam-drive", "--pins", "2")
    with pytest.raises(UsageError, match="required with cam-drive: --lift"):
        _kinds.require(args, "pins", "lift")


def test_help_and_reports_know_every_kind(second_kind, capsys):
    for command in ("run", "mechanism", "drive-torque"):
        assert main([command, "--help"]) == 0
        text = " ".join(capsys.readouterr().out.split())
        for name, summary in _kinds.KINDS.items():
            assert f"{name}: {summary}" in text
        assert "geneva, cam-drive: pins of the driver" in text
        assert "cam-drive: height of the cam" in text
    assert main(["mechanism", "cam-drive", "--lift", "0.0254", "--units", "in-lbf-s"]) == 0
    assert capsys.readouterr().out.split() == ["stations", "4", "lift", "1", "in"]


def test_a_study_says_to_which_kind_a_key_belongs(monkeypatch):
    lift = Parameter("height of the cam", "length", "", key="lift", section="mechanism")
    monkeypatch.setitem(KINDS, "cam-drive", Kind("nowhere:Cam", {"lift": lift}))
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
def test_a_mechanism_beside_a_study_is_refused(words, named, capsys):
    assert main(["run", "--from", "study.h5", *words]) == 2
    assert f"{named} must not come with --from" in capsys.readouterr().err
