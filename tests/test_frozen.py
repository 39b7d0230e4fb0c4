"""Results stay what they were while the structure of the code changes."""

import json

import pytest

import frozen

ROWS = json.loads(frozen.FILE.read_text())
# another processor may round sums in another order
_ROUNDING = 1e-12


def takes_long(given):
    return given["arguments"].get("engine") == "ivp"


@pytest.mark.parametrize("row", [
    pytest.param(row, id=row["input"]["name"], marks=[pytest.mark.slow] * takes_long(row["input"]))
    for row in ROWS
])  # fmt: skip
def test_outcome_is_what_it_was(row):
    """`python tests/frozen.py compare` asks for 1e-14, of two trees on one machine."""
    apart, name = frozen.difference(frozen.outcome(row["input"]), row["outcome"])
    assert apart <= frozen.allowed(row["input"], energy=_ROUNDING), name


def test_difference_notices_a_moved_number():
    found = {"status": "ok", "period": [1.0, 2.0]}
    assert frozen.difference(found, found) == (0.0, "")
    apart, name = frozen.difference({"status": "ok", "period": [1.0, 2.0 + 1e-9]}, found)
    assert name == "period"
    assert apart == pytest.approx(5e-10)
    assert frozen.difference({"status": "stall", "period": [1.0, 2.0]}, found)[0] > 1.0
