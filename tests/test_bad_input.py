"""Whatever is wrong is said in one line: the argument, its rule, the value, a remedy."""

import numpy as np
import pytest

from bad_calls import MODEL, TABLE, built, look, wheel
from escapement.errors import InvalidValue


def outcome(call):
    """What InvalidValue says; any other outcome is the exception itself, or None."""
    try:
        call()
    except Exception as error:
        return error
    return None


@pytest.mark.usefixtures("patience")
@pytest.mark.parametrize("bad", TABLE, ids=lambda bad: f"{bad.name}-{bad.value}")
def test_a_refusal_names_argument_rule_value_and_remedy(bad):
    error = outcome(bad.call)
    assert isinstance(error, InvalidValue)
    message = str(error)
    assert message.isprintable()
    said, _, remedy = message.partition("; ")
    for part in (bad.name, bad.rule, bad.value):
        assert part in said
    assert len(remedy) > 5
    assert len(message) < 300


def test_there_are_enough_of_them():
    assert len(TABLE) >= 300


def test_different_rules_have_different_messages():
    rule_of = {}
    for bad in TABLE:
        rule = (bad.name, bad.rule)
        assert rule_of.setdefault(str(outcome(bad.call)), rule) == rule


def test_a_number_in_an_array_without_dimensions_is_a_number():
    assert built(torque=np.array(0.0113), friction=np.float32(0.25)) == built(friction=0.25)
    assert wheel(slots=np.array(5)) == wheel(slots=np.int8(5)) == wheel(slots=5)


def test_a_masked_number_is_none():
    hidden = np.ma.array(0.25, mask=True)
    for call in (lambda x: built(friction=x), lambda x: wheel(slots=x), look):
        with pytest.raises(InvalidValue):
            call(hidden)
    with pytest.raises(InvalidValue, match="t must be free of masked values"):
        look(np.ma.array([0.0, 0.1], mask=[0, 1]))
    assert built(friction=np.ma.array(0.25)) == built(friction=0.25)


COMMANDS = {
    "time without end": (
        ["run", *MODEL, "--duration", "1e300"],
        "duration",
        "10000000 engagements",
    ),
    "engagements without end": (
        ["run", *MODEL, "--engagements", "1" + 400 * "0"],
        "engagements",
        "at most 10000000",
    ),
    "too long for the slow engine": (
        ["run", *MODEL, "--engine", "ivp", "--duration", "1e9"],
        "duration",
        "10000 engagements",
    ),
    "speed beyond doubles": (
        ["run", *MODEL, "--initial-speed", "1e300"],
        "--initial-speed",
        "at most",
    ),
    "tolerance below rounding": (["run", *MODEL, "--rtol", "1e-14"], "rtol", "at least 1e-13"),
    "method of another engine": (["run", *MODEL, "--method", "RK45"], "method", "left out"),
    "boolean for a number": (["run", "--torque", "true"], "--torque", "finite number"),
    "number with a unit": (["run", "--torque", "0.1Nm"], "--torque", "'0.1Nm'"),
    "hyphen for a minus": (["run", "--friction", "\u22120.3"], "--friction", "finite number"),
    "infinite friction": (["run", "--friction", "inf"], "--friction", "got 'inf'"),
    "slots not whole": (["mechanism", "--slots", "1e1"], "--slots", "whole number"),
    "two slots": (["mechanism", "geneva", "--slots", "2"], "--slots", "at least 3"),
    "pins that do not fit": (["mechanism", "--slots", "7", "--pins", "3"], "pins", "at most 2"),
    "negative pins": (["mechanism", "--pins", "-1"], "--pins", "at least 1"),
    "no inertia to speak of": (
        ["mechanism", "--driver-inertia", "0", "--follower-inertia", "1"],
        "--driver-inertia",
        "greater than 0",
    ),
    "unit of nothing": (["mechanism", "--units", "mm"], "--units", "SI, in-lbf-s"),
    "workers in words": (["sweep", "x.toml", "--workers", "all"], "--workers", "whole number"),
    "json as a value": (["mechanism", "--json", "yes"], "yes", "one of"),
}


@pytest.mark.usefixtures("patience")
@pytest.mark.parametrize(("argv", "name", "rule"), COMMANDS.values(), ids=COMMANDS)
def test_commands_refuse_alike(refusal, argv, name, rule):
    said = refusal(2, *argv)
    assert name in said
    assert rule in said
