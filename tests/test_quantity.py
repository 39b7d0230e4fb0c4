"""Numbers that are declared once: what follows from a declaration is there everywhere."""

import copy
import pickle
import re
from dataclasses import replace
from pathlib import Path

import pytest

import escapement as esc
from escapement.base.errors import EscapementError, UnknownArgument
from escapement.base.quantity import declared, quantities
from escapement.base.units import SYSTEMS, unit_name
from escapement.cli._arguments import Parser, option
from escapement.cli.run import configure
from escapement.mechanisms import KINDS, kind_of
from escapement.model.train import train_numbers
from escapement.study.parse import parse_plan
from escapement.study.plan import settings_of

OWNERS = [esc.Escapement, esc.Inertia, *map(kind_of, KINDS)]
NUMBERS = {name: entry for owner in OWNERS for name, entry in quantities(owner).items()}
STUDIES = (Path(__file__).parents[1] / "docs" / "studies.md").read_text("utf-8")
ROWS = [line.strip("|").split("|") for line in STUDIES.splitlines() if line.startswith("|")]
AXES, OTHERS = (
    {*re.findall(r"`(\w+)`", "".join(row[i] for row in ROWS if len(row) == 3))} for i in (1, 2)
)
INERTIA = esc.Inertia(1e-6, 1e-5)


@pytest.mark.parametrize(
    ("call", "wrong", "nearest"),
    [
        (lambda: esc.Geneva(slot=4), "slot", "slots"),
        (lambda: esc.Geneva(4, kind="x"), "kind", "pins"),
        (lambda: esc.Geneva(4, internl=True), "internl", "internal"),
        (lambda: esc.GearDriven(4, 0, curv="epicycloid"), "curv", "curve"),
        (lambda: esc.EllipticalPlanetary(sun_radus=2.0), "sun_radus", "sun_radius"),
        (lambda: esc.Tabulated(theta=[], fi=[]), "fi", "known are theta, phi, measured"),
        (lambda: esc.Inertia(driver=1.0, folower=1.0), "folower", "follower"),
        (lambda: esc.Escapement(esc.Geneva(4), INERTIA, tork=1.0), "tork", "torque"),
        (lambda: replace(esc.Geneva(4), slot=5), "slot", "slots"),
    ],
)
def test_an_unknown_keyword_names_the_nearest(call, wrong, nearest):
    with pytest.raises(UnknownArgument) as caught:
        call()
    assert isinstance(caught.value, TypeError)
    assert isinstance(caught.value, EscapementError)
    assert f"has no argument {wrong!r}; " in str(caught.value)
    assert nearest in str(caught.value).partition(";")[2]


def test_a_subclass_may_have_arguments_of_its_own():
    class Mine(esc.Geneva):
        def __init__(self, size):
            super().__init__(slots=size)

    assert Mine(size=5).slots == 5


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))]
)
def test_what_is_declared_can_be_copied(copied):
    timer = esc.Escapement(esc.Geneva(4), INERTIA, torque=0.1, friction=0.2)
    assert copied(timer) == timer


@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_is_told_everywhere(name):
    entry = NUMBERS[name]
    parser = Parser(prog="test")
    configure(parser)
    assert option(name) in parser._option_string_actions
    assert entry.metavar
    assert entry.remedy
    for system in SYSTEMS:
        assert unit_name(entry.unit, system)
    assert entry.key in (AXES if entry.axis else OTHERS)
    assert (name in AXES) == entry.axis


@pytest.mark.parametrize("kind", KINDS)
def test_every_number_of_a_kind_has_a_key_and_an_axis(kind):
    build = kind_of(kind)
    known = settings_of(build, build.meshed)
    assert {*declared(build)} <= {*known}
    for name, entry in known.items():
        no_number = "contact_law", "load_curve", "pin_material", "wheel_material"
        assert entry.axis or entry.section == "mechanism" or name in no_number
        assert entry.name == name
    lost = {"friction", "efficiency"} - {*known}
    assert lost == {"friction" if build.meshed else "efficiency"}


def test_every_number_of_the_model_decides_of_a_scene():
    """Or a study would share scenes that are not the same."""
    plan = parse_plan(
        {"torque": 1.0, "mechanism": {"slots": 4}, "sweep": {"driver_inertia": [1.0]}}
        | {"inertia": {"follower": 1.0}}
    )
    model = {name for owner in (esc.Escapement, esc.Inertia) for name in quantities(owner)}
    model |= {*train_numbers()}
    wheel = {"slots", "pins", "pin_radius", "roller_radius", "clearance", "centre_distance_error"}
    assert {*plan.parameters} == model - {"efficiency"} | wheel | {"initial_speed", "turns"}
