"""Kinds of mechanism: which kinds an option belongs to, in any order of the words typed."""

import argparse

import pytest

from escapement import mechanisms
from escapement.base.errors import InvalidValue
from escapement.cli import _arguments
from escapement.cli._arguments import Parser, UsageError
from escapement.mechanisms import GearDriven
from escapement.study.parse import parse_plan


def understand(*argv):
    parser = Parser(prog="test")
    _arguments.add_common(parser)
    _arguments.add_mechanism(parser)
    args = parser.understand([*argv])
    assert isinstance(args, argparse.Namespace)
    return args


@pytest.mark.parametrize(
    "argv",
    [
        ("gear-driven", "--slots", "5"),
        ("--slots", "5", "gear-driven"),
        ("--slots=4", "gear-driven"),
    ],
)
def test_an_option_of_another_kind_is_refused_by_name(argv):
    words = r"--slots must not come with a gear-driven mechanism, got [45]; it belongs to geneva$"
    with pytest.raises(UsageError, match=words):
        _arguments.read_mechanism(understand(*argv))


@pytest.mark.parametrize("argv", [("--lobes", "1"), ("--lobes", "1", "geneva", "--slots", "4")])
def test_the_default_kind_refuses_too(argv):
    with pytest.raises(UsageError, match=r"--lobes .* a geneva mechanism.* belongs to gear-driven"):
        _arguments.read_mechanism(understand(*argv))


def test_a_shared_option_is_accepted_by_both():
    assert _arguments.read_mechanism(understand("--pins", "2")).pins == 2
    gears = ("--stations", "12", "--lobes", "5", "--curve", "epicycloid")
    args = understand("--pins", "3", "gear-driven", *gears)
    assert _arguments.read_mechanism(args) == GearDriven(12, 5, "epicycloid", 3)


def test_what_a_kind_needs_is_named():
    with pytest.raises(UsageError, match="required with gear-driven: --stations, --lobes"):
        _arguments.read_mechanism(understand("gear-driven", "--pins", "2"))


def test_help_knows_every_kind(command):
    for name in ("run", "mechanism"):
        text = " ".join(command(name, "--help")[1].split())
        for kind in mechanisms.KINDS:
            assert f"{kind}: {mechanisms.kind_of(kind).summary}" in text
        assert "geneva, gear-driven: pins of the driver" in text


def test_a_study_says_to_which_kind_a_key_belongs():
    study = {
        "mechanism": {"slots": 4, "lobes": 1},
        "inertia": {"driver": 1.0, "follower": 1.0},
        "torque": 1.0,
        "sweep": {"friction": [0.1]},
    }
    words = r"'lobes' in \[mechanism\]; it belongs in \[mechanism\] of kind 'gear-driven'$"
    with pytest.raises(InvalidValue, match=words):
        parse_plan(study)
    study["mechanism"] = {"kind": "gear-driven", "slots": 4}
    with pytest.raises(InvalidValue, match=r"'slots' .* of kind 'geneva'"):
        parse_plan(study)


def test_gear_driven_solutions(command, report, tmp_path):
    options = ["--stations", "4", "--lobes", "0", "--curve", "epicycloid", "--pins", "6"]
    record = report("mechanism", "gear-driven", *options)
    first, second = record["solutions"]
    assert record["alpha_deg"] == first["alpha_deg"] < second["alpha_deg"] == 90.0
    assert (first["pins"], second["pins"]) == (6, 1)
    assert "solutions" in command("mechanism", "gear-driven", *options, "--plot", "a.png")[1]
    assert (tmp_path / "a.png").stat().st_size > 10_000
