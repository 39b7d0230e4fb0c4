"""The three verdicts on readings: what contradicts a drive, what cannot say, and what is good.

The readings are those of a Geneva wheel in closed form, and not of the package.
"""

import csv
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import escapement as esc
from escapement.measurement import error_columns
from escapement.measurement.normal_equations import _chance_of_greatest, far_out
from measurement_tools import DEG

WHEEL = esc.Geneva(4, pins=1)
NOISE = 0.05 * DEG


def follower(theta, slots=4):
    """Follower angle of a wheel with one pin, zero at dead centre."""
    reach = math.pi / 2.0 - math.pi / slots
    cell = np.floor((theta + reach) / (2.0 * math.pi))
    local = np.minimum(theta - 2.0 * math.pi * cell, reach)
    along = 1.0 / math.sin(math.pi / slots) - np.cos(local)
    return np.arctan2(np.sin(local), along) + cell * 2.0 * math.pi / slots


def read(turns=8.0, rows=1200, seed=0, driver=None, added=0.0, way=1.0, start=0.4, **kept):
    """Readings of the wheel; `driver` changes its angle, `added` the output."""
    random = np.random.default_rng(seed)
    theta = start + way * 2.0 * math.pi * turns * np.arange(rows) / rows
    at = theta if driver is None else driver(theta)
    output = follower(at) + added + NOISE * random.standard_normal(rows)
    return esc.Readings(theta - theta[0], output + 0.7, **kept)


def verdict(readings, wheel=WHEEL, **options):
    return esc.measure(readings, wheel, **options).verdict


def test_lost_steps_are_named_with_their_line_and_size():
    """Four full steps of 1.8 degrees are lost behind the 601st sample."""
    slip = 7.2 * DEG * (np.arange(1200) > 600)
    result = esc.measure(read(driver=lambda theta: theta - slip, line=np.arange(2, 1202)), WHEEL)
    assert result.verdict.good is False
    said = "the errors change for good behind line 602, as if the input had slipped by 7.2 degrees"
    assert said in result.verdict.text
    (change,) = result.changes
    assert abs(abs(change.size) - 7.2 * DEG) < 3.0 * change.standard_error < 0.1 * DEG


@pytest.mark.parametrize(("way", "size"), [(1.0, 0.1), (-1.0, 1.8), (1.0, 20.0)])
def test_sizes_of_slips(way, size):
    within = []
    for seed in range(8):
        slip = size * DEG * (np.arange(1200) > 500)
        readings = read(seed=seed, way=way, driver=lambda theta, slip=slip: theta - slip)
        result = esc.measure(readings, WHEEL)
        assert result.verdict.good is False
        (change,) = (one for one in result.changes if one.p_value < 1e-3)
        assert change.shaft == "input"
        within.append(abs(abs(change.size) - size * DEG) < 1.96 * change.standard_error)
    assert np.mean(within) >= 0.75


def test_a_slot_and_a_pin_are_named():
    theta = 0.4 + 16.0 * math.pi * np.arange(1200) / 1200
    cell = np.floor((theta + math.pi / 4.0) / (2.0 * math.pi))
    result = esc.measure(read(added=0.2 * DEG * (cell % 4 == 2)), WHEEL)
    assert "slot 3 of 4, counted from the one at the first sample, is ahead" in result.verdict.text
    (slot,) = (one for one in result.slot_errors if one.shaft == "output")
    assert abs(slot.size - 0.2 * DEG) < 3.0 * slot.standard_error < 0.05 * DEG
    # the second of four pins is ahead of the others
    wheel = esc.Geneva(4)
    ahead = 0.3 * DEG * (np.floor((theta + math.pi / 4.0) / (math.pi / 2.0)) % 4 == 1)
    output = esc.measurement.position(wheel, theta + ahead)
    output += NOISE * np.random.default_rng(1).standard_normal(1200)
    result = esc.measure(esc.Readings(theta, output), wheel)
    assert result.verdict.good is False
    assert "pin 2 of 4" in result.verdict.text


def test_one_reading_far_out_is_named_and_hides_nothing():
    far = np.zeros(1200)
    far[[76, 400]] = 0.6 * DEG, 300.0 * DEG
    result = esc.measure(read(added=far), WHEEL)
    assert "the reading in lines 77, 401 is off by up to 300 degrees" in result.verdict.text
    assert result.scatter == pytest.approx(NOISE, rel=0.1)
    theta = 16.0 * math.pi * np.arange(1200) / 1200
    waved = esc.measure(read(added=far + 0.1 * DEG * np.sin(follower(theta))), WHEEL)
    assert "repeats once a turn of the output" in waved.verdict.text


WRONG = {
    "gear of 2 : 1": (lambda theta: theta / 2.0, 1.2, WHEEL),
    "gear of the right mean ratio": (lambda theta: theta / 4.0, 6.0, WHEEL),
    "five slots": (lambda theta: follower(theta, 5), 6.0, WHEEL),
    "internal": (follower, 6.0, esc.Geneva(4, internal=True)),
    "output at rest": (lambda theta: 0.0 * theta, 6.0, WHEEL),
}


@pytest.mark.parametrize(("motion", "turns", "wheel"), WRONG.values(), ids=WRONG)
def test_another_mechanism_is_not_called_good(motion, turns, wheel):
    theta = 2.0 * math.pi * turns * np.arange(500) / 500
    output = motion(theta) + NOISE * np.random.default_rng(2).standard_normal(500)
    found = verdict(esc.Readings(theta, output), wheel)
    assert found.good is False
    assert found.text.startswith("Not this mechanism:")


def test_less_than_one_cell_of_a_gear_is_enough_to_refuse_it():
    theta = np.radians(np.linspace(0.0, 300.0, 300))
    output = theta / 2.0 + NOISE * np.random.default_rng(2).standard_normal(300)
    assert verdict(esc.Readings(theta, output)).text.startswith("Not this mechanism: errors of")


def test_exchanged_columns_are_told():
    readings = read(turns=20.0)
    found = verdict(esc.Readings(readings.output, readings.input))
    assert found.good is not True
    assert "With input and output exchanged, the angles fit this mechanism" in found.text


@pytest.mark.parametrize(("unit", "size"), [("turn", 2.0 * math.pi), ("rad", 1.0)])
def test_too_little_travel_cannot_say_and_the_unit_is_doubted(unit, size, tmp_path):
    readings = read(turns=6.0, rows=600)
    table = np.column_stack([readings.input, readings.output]) / size
    np.savetxt(tmp_path / "raw.csv", table, "%.7f", ";", header="A;B", comments="")
    names = {"input": "A", "output": "B"}
    found = verdict(esc.read_readings(tmp_path / "raw.csv", **names))
    assert found.good is None
    assert "the input moved by" in found.text
    assert f"give --angle-unit {unit}" in found.text
    # the remedy works
    assert verdict(esc.read_readings(tmp_path / "raw.csv", **names, angle_unit=unit)).good


def test_shafts_at_rest_cannot_say():
    random = np.random.default_rng(3)
    noise = NOISE * random.standard_normal((2, 100))
    result = esc.measure(esc.Readings(1.7 + noise[0], 0.8 + noise[1]), WHEEL)
    assert result.verdict.good is None
    assert result.verdict.text.startswith("Cannot say: the input moved by 0.")
    assert all(math.isnan(error.amplitude) for error in result.shaft_errors)
    assert result.slot_errors == result.changes == ()


@pytest.mark.parametrize("turns", [1.9, 2.1])
def test_two_cells_are_needed(turns):
    assert verdict(read(turns=turns)).good is (True if turns > 2.0 else None)


def test_noise_beyond_what_a_pin_allows_cannot_say():
    random = np.random.default_rng(4)
    readings = read(added=8.0 * DEG * random.standard_normal(1200))
    found = verdict(readings)
    assert found.good is None
    assert "which is much for steps of 90 degrees" in found.text


def test_what_hangs_together_without_a_cause_cannot_say():
    random = np.random.default_rng(5)
    slow = np.convolve(random.standard_normal(1211), np.ones(12), "valid") * 0.05 * DEG
    found = verdict(read(added=slow))
    assert found.good is not True
    assert "neighbour" in found.text


def test_given_zeros_that_are_wrong_are_not_good():
    readings = read()
    assert verdict(readings, zeros=(0.4, 0.7)).good
    found = verdict(readings, zeros=(0.4, 0.71))
    assert found.good is False
    assert "the mean error is 0.5" in found.text


@pytest.mark.parametrize(("slots", "way"), [(3, 1.0), (6, -1.0)])
def test_good_drives_are_good(slots, way):
    """One in a hundred may be doubted."""
    wheel, good = esc.Geneva(slots, pins=1), []
    for seed in range(15):
        random = np.random.default_rng(seed)
        theta = way * 2.0 * math.pi * 7.3 * np.sort(random.random(500))
        angle = theta + 0.02 * DEG * random.standard_normal(500)
        output = follower(theta, slots) + NOISE * random.standard_normal(500)
        result = esc.measure(esc.Readings(angle, output), wheel)
        good.append(result.verdict.good)
    assert good.count(True) >= 13
    assert "without a change for good" in result.verdict.text


@pytest.mark.parametrize("size", [100, 600])
def test_the_greatest_change_has_the_p_value_of_noise(size):
    """The bound on its probability holds, and is not far above it."""
    random = np.random.default_rng(7)
    draws = random.standard_normal((4000, size))
    draws -= draws.mean(axis=1, keepdims=True)
    k = np.arange(5, size - 5)
    behind = np.cumsum(draws[:, ::-1], axis=1)[:, ::-1][:, k]
    greatest = np.abs(behind / np.sqrt((size - k) * k / size)).max(axis=1)
    share = (size - k) / size
    alike = np.sqrt(share[1:] * (1.0 - share[:-1]) / (share[:-1] * (1.0 - share[1:])))
    for level in (3.2, 3.6):
        rate = (greatest > level).mean()
        bound = _chance_of_greatest(level, 10**6, alike)
        assert rate < bound + 3.0 * math.sqrt(bound / 4000)
        assert bound < 3.0 * rate


def test_readings_far_out_are_found_as_often_as_said():
    random = np.random.default_rng(8)
    rate = np.mean([far_out(random.standard_normal(200), 0.05)[0].size > 0 for _ in range(2000)])
    assert rate == pytest.approx(0.05, abs=3.0 * math.sqrt(0.05 * 0.95 / 2000))
    errors = random.standard_normal(200)
    errors[[3, 50, 70]] = 9.0, -300.0, 40.0
    assert sorted(far_out(errors, 1e-3)[0]) == [3, 50, 70]


def test_the_report_has_all_that_was_found(command, tmp_path):
    slip = 7.2 * DEG * (np.arange(1200) > 600)
    far = np.zeros(1200)
    far[99] = 5.0 * DEG
    readings = read(driver=lambda theta: theta - slip, added=far)
    esc.write_readings(readings, tmp_path / "lost.csv")
    words = ("measure", str(tmp_path / "lost.csv"), "--slots", "4", "--pins", "1")
    found = json.loads(command(*words, "--json")[1])
    assert found["good"] is False
    assert found["changes"][0]["line"] == 602
    assert found["changes"][0]["size_deg"] == pytest.approx(-7.2, abs=0.05)
    assert [one["line"] for one in found["glitches"]] == [101]
    assert {"slot_errors", "scatter_deg"} <= set(found)
    table = command(*words)[1]
    assert re.search(r"changes\n.*\n.*\ninput +602 +-7.2", table)
    assert re.search(r"glitches\n.*\n.*\n +101 ", table)
    short = esc.Readings(readings.input[:100], readings.output[:100])
    esc.write_readings(short, tmp_path / "short.csv")
    code, out, _ = command("measure", str(tmp_path / "short.csv"), *words[2:], "--json")
    assert code == 0
    assert json.loads(out)["good"] is None


def test_sums_by_segments_are_those_of_single_samples(monkeypatch):
    """Long files are summed in segments; the change that is found is the same."""
    slip = 7.2 * DEG * (np.arange(5000) > 2654)  # while the follower moves
    readings = read(turns=30.0, rows=5000, driver=lambda theta: theta - slip)
    (single,) = esc.measure(readings, WHEEL).changes
    monkeypatch.setattr(error_columns, "_EDGES", 70)
    (coarse,) = esc.measure(readings, WHEEL).changes
    assert coarse.line == single.line
    assert coarse.size == pytest.approx(single.size, rel=1e-9)


def test_committed_counts_of_verdicts_are_those_of_the_page():
    root = Path(__file__).parents[1]
    table = (root / "benchmarks/results/planted_errors.csv").read_text(encoding="utf-8")
    rows = {(row["error"], row["times"]): row for row in csv.DictReader(table.splitlines())}
    none, planted = rows["none", ""], rows["all", "5 to 50"]
    assert int(none["good"]) >= 0.95 * int(none["sets"])
    assert int(planted["good"]) <= 0.01 * int(planted["sets"])
    page = " ".join((root / "docs/measuring.md").read_text(encoding="utf-8").split())
    assert f"{none['good']} were called good" in page
    assert f"{planted['good']} were" in page
