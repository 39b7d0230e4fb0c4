"""Kinds of mechanism: which kinds an option belongs to, in any order of the words typed."""

import argparse
import sys
import types
from dataclasses import dataclass, field
from typing import Any, ClassVar

import pytest

from escapement import mechanisms
from escapement.base.quantity import quantity
from escapement.cli import _arguments
from escapement.cli._arguments import Parser, UsageError
from escapement.mechanisms import Geneva
from escapement.mechanisms.kind import Kind


@dataclass(frozen=True)
class Cam(Kind):
    """A kind that stands for another in every question but what it is made of."""

    kind = "cam-drive"
    summary = "a cam"
    report_units: ClassVar = {"rise": "length"}

    rise: float = field(metadata=quantity("height of the cam", "length"))
    pins: Any = field(default=None, metadata=quantity("not shown", whole=True, metavar="P"))

    def report(self):
        return {"stations": 4, "rise": self.rise}

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


@pytest.mark.parametrize("argv", [("--rise", "1"), ("--rise", "1", "geneva", "--slots", "4")])
def test_the_default_kind_refuses_too(second_kind, argv):
    with pytest.raises(UsageError, match=r"--rise .* a geneva mechanism.* belongs to cam-drive"):
        _arguments.read_mechanism(understand(*argv))


def test_a_shared_option_is_accepted_by_both(second_kind):
    assert _arguments.read_mechanism(understand("--pins", "2")).pins == 2
    args = understand("--pins", "3", "cam-drive", "--rise", "1")
    assert _arguments.read_mechanism(args) == Cam(1.0, 3)


def test_what_a_kind_needs_is_named(second_kind):
    args = understand("cam-drive", "--pins", "2")
    with pytest.raises(UsageError, match="required with cam-drive: --rise"):
        _arguments.read_mechanism(args)


def test_help_and_reports_know_every_kind(second_kind, command):
    for name in ("run", "mechanism", "index"):
        text = " ".join(command(name, "--help")[1].split())
        for kind in mechanisms.KINDS:
            assert f"{kind}: {mechanisms.kind_of(kind).summary}" in text
        assert "geneva, gear-driven, cam-drive: pins of the driver" in text
        assert "cam-drive: height of the cam" in text
    out = command("mechanism", "cam-drive", "--rise", "1", "--units", "in-lbf-s")[1]
    assert out.partition("\n\n")[2].split() == ["stations", "4", "rise", "1", "in"]


def test_gear_driven_solutions(command, report, tmp_path):
    options = ["--stations", "4", "--lobes", "0", "--curve", "epicycloid", "--pins", "6"]
    record = report("mechanism", "gear-driven", *options)
    first, second = record["solutions"]
    assert record["alpha_deg"] == first["alpha_deg"] < second["alpha_deg"] == 90.0
    assert (first["pins"], second["pins"]) == (6, 1)
    assert "solutions" in command("mechanism", "gear-driven", *options, "--plot", "a.png")[1]
    assert (tmp_path / "a.png").stat().st_size > 10_000
