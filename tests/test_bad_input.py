"""Every wrong input gives one line: the argument, its rule, the value and a remedy.

What is refused follows from the declarations, wherever a value comes in.
"""

import json

import numpy as np
import pytest

import escapement as esc
from bad_calls import BAD, INERTIA, MACHINES, WHEEL, built, fault, maker, outside, study, wheel
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Truth
from escapement.cli import main
from escapement.cli._arguments import option, parser_of
from escapement.engines.solver import Solver
from escapement.model.escapement import Run


def check_message(message, name):
    assert message.isprintable()
    said, _, remedy = message.partition("; ")
    assert name in said
    assert " must be " in said
    assert ", got " in said
    assert len(remedy) > 5
    assert len(message) < 300


def faults(cases, call):
    """What is wrong with the messages of calls, each with a value that breaks a declaration."""
    found = []
    for case in cases:
        label, entry, value = case[-3:]
        try:
            message = f"{call(*case)}"
        except InvalidValue as error:
            message = str(error)
        found.append(fault(message, label, entry, value))
    return [text for text in found if text]


def test_a_constructor_refuses_as_declared():
    # `turns` is of studies alone
    cases = [
        (owner, kind, entry.name, entry, value) for owner, kind, name, entry, value in BAD
        if name != "turns"
    ]  # fmt: skip
    assert faults(cases, lambda owner, kind, *x: maker(owner, kind)(**{x[1].key: x[2]})) == []


def test_a_study_file_refuses_as_declared():
    def read(kind, label, entry, value):
        right = {"mechanism": {"kind": kind} | MACHINES[kind], "solver": {"engine": "ivp"}}
        right |= {"inertia": {"driver": 1.0, "follower": 1.0}, "": {}}
        wrong = right[entry.section] | {entry.key: value}
        study(kind, **({entry.section: wrong} if entry.section else wrong))

    cases = [
        (kind, entry.key if owner is Solver else entry.label, entry, value)
        for owner, kind, _, entry, value in BAD
        if owner is not Run and not isinstance(value, np.ndarray)
    ]
    assert faults(cases, read) == []


def test_the_command_line_refuses_as_declared(refusal):
    """Negative numbers too, which argparse would take for options."""

    def run(name, label, entry, text):
        line = refusal(2, "run", label, text)
        return line.removeprefix("escapement: error: ").strip()

    # kinds of mechanism may share an option, which is that of the first
    options = parser_of("run")[1].settings
    cases = [
        (name, option(name), options[name], str(value))
        for _, _, name, entry, value in BAD
        if not isinstance(entry, Truth) and name in options
        if value in ("x", "nonsense", *outside(entry))
    ]
    assert faults(cases, run) == []


def test_numbers_of_numpy_are_numbers():
    single = built(torque=np.float64(0.0113), friction=np.float32(0.25))
    assert single == built(friction=0.25)
    assert type(single.friction) is float
    assert wheel(slots=np.int8(5), internal=np.False_) == wheel(slots=5)
    with pytest.raises(InvalidValue, match="friction must be a finite number, got masked"):
        built(friction=np.ma.masked)


OBJECTS = [(built, "mechanism", value) for value in (4, None, "geneva", esc.Geneva, INERTIA)]
OBJECTS += [(built, "inertia", value) for value in ((1.0, 2.0), None, 1.0, esc.Inertia)]
OBJECTS += [(esc.simulate, "escapement", value) for value in (None, WHEEL, esc.Escapement)]


@pytest.mark.parametrize(("call", "name", "value"), OBJECTS)
def test_an_object_of_another_class_is_refused(call, name, value):
    with pytest.raises(InvalidValue) as caught:
        call(**{name: value})
    check_message(str(caught.value), name)


@pytest.mark.parametrize(("given", "told"), [
    ({"driver_bearing_friction": 0.2}, "driver_bearing_friction has no effect without driver_bear"),
    ({"follower_bearing_radius": 1e-3}, "has no effect without follower_bearing_friction"),
    ({"restitution": 0.3}, "restitution has no effect without clearance"),
    ({"damping": 3.0, "slip_speed": 1e-3}, "; slip_speed has no effect without stiffness"),
    ({"contact_law": "hunt-crossley"}, "contact_law has no effect without stiffness"),
    ({"driver_bearing_friction": 0.2, "driver_bearing_radius": 1e-3}, ""),
])  # fmt: skip
def test_settings_that_do_nothing_alone_are_told(given, told, tmp_path, capsys):
    timer = esc.Escapement(
        esc.Geneva(4, crank_radius=0.01),
        esc.Inertia(3e-7, 5e-6),
        torque=0.01,
        friction=0.2,
        **given,
    )
    for found in (esc.simulate(timer, 1), esc.terminal(timer)):
        assert found.message == "done" if told == "" else told in found.message
    study = tmp_path / "s.toml"
    lines = ["torque = 0.01", *(f"{name} = {json.dumps(value)}" for name, value in given.items())]
    tables = (
        "[mechanism]\nslots = 4\ncrank_radius = 0.01\n[inertia]\ndriver = 3e-7\nfollower = 5e-6\n"
    )
    study.write_text("\n".join([*lines, tables, "[sweep]\nfriction = [0.2, 0.3]\n"]))
    assert main(["sweep", str(study), "-o", str(tmp_path / "s.h5"), "--quiet"]) == 0
    printed = capsys.readouterr().err
    assert told in printed
    assert bool(told) == ("no effect" in printed)
