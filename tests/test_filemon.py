"""Filemon (1960): Table I, equations and the command line."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import escapement as esc
from escapement.constant_speed import geneva
from escapement.sources import filemon
from escapement.sources.filemon.nomograms import NOMOGRAMS, plot_nomogram
from escapement.sources.report import digits, read_slips
from figure_tools import by_id

# every cell that is wrong, recomputed by hand in another program, and the rule behind it
ERRATA = {
    (3, "ratio_max"): ("6.464", "four-place tables"),
    (3, "beta_max"): ("4°45'", "four-place tables"),
    (3, "acceleration_max"): ("31.39", "four-place arithmetic"),
    (3, "F12"): ("0.0319", "reciprocal"),
    (4, "ratio_max"): ("2.414", "four-place tables"),
    (4, "beta_max"): ("11°28'", "digit slip"),
    (4, "acceleration_max"): ("5.407", "four-place tables"),
    (4, "F12"): ("0.1849", "reciprocal"),
    (5, "F12"): ("0.4350", "reciprocal"),
    (5, "F23"): ("1.3764", "cut off"),
    (6, "F12"): ("0.7409", "digits transposed"),
    (8, "beta_max"): ("31°39'", "cut off"),
    (8, "F12"): ("1.429", "reciprocal"),
    (8, "F23"): ("2.4142", "digit slip"),
    (9, "F12"): ("1.789", "reciprocal"),
    (9, "F23"): ("2.7475", "digit slip"),
    (10, "beta_max"): ("38°29'", "four-place tables"),
    (10, "F23"): ("3.0777", "digit slip"),
}
DOCS = Path(__file__).resolve().parents[1] / "docs"
LIMIT_ANGLES = [3.620, 8.484, 12.649, 16.065, 18.874, 21.209, 23.174, 24.848]
KEYS = {
    *("inertia_ratio", "reversal_limits", "reversals_deg", "zone", "torque_max", "torque_max_deg"),
    *("torque_mean", "torque_max_over_mean", "power_mean_to_dead_centre", "power_max"),
    *("greatest_speed", "inputs", "index_time", "dwell_time"),
    *("greatest_follower_inertia", "least_load_torque"),
}


# --- Table I ------------------------------------------------------------------------------


def test_every_cell_agrees_to_the_last_digit_or_is_an_erratum():
    cells = filemon.table_1()
    assert len(cells) == 48
    wrong = {(cell.place, cell.column): cell for cell in cells if not cell.agrees}
    assert set(wrong) == set(ERRATA)
    for key, (right, rule) in ERRATA.items():
        assert wrong[key].true == right
        assert wrong[key].reason.startswith(rule)
    for cell in cells:
        off = abs(cell.number - cell.value) / digits(cell.printed)[1]
        assert (off <= 0.5 * (1 + 1e-9)) is cell.agrees


def test_the_page_says_how_many_cells_are_right_and_which_error_matters():
    text = (DOCS / "indexing-drive.md").read_text(encoding="utf-8")
    wrong = {(cell.place, cell.column): cell for cell in filemon.table_1() if not cell.agrees}
    assert f"Of 48 cells {48 - len(wrong)} are right" in text
    six = wrong[6, "F12"]
    said = f"printed {six.printed} for {six.true}, making the greatest speed without reversals"
    assert f"{said} a fifth too low" in " ".join(text.split())
    limits = {key: cell for key, cell in wrong.items() if key[1][0] == "F"}
    speeds = {key: math.sqrt(cell.number / cell.value) for key, cell in limits.items()}
    assert speeds.pop((6, "F12")) == pytest.approx(0.8, abs=0.01)
    assert all(abs(speed - 1.0) < 0.002 for speed in speeds.values())


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0, 100.0])
def test_mean_torque_agrees_with_quadrature(ratio):
    nodes, weights = np.polynomial.legendre.leggauss(400)
    for n in (3, 4, 5, 8, 20, 100):
        wheel = esc.Geneva(n, pins=1)
        table = wheel.transmission(0.5 * wheel.breaks[0] * (1.0 - nodes))
        mean = 0.5 * float(weights @ (table.g * (1.0 + ratio * table.dg)))
        d, a = geneva.mean_factors(n)
        assert float(d * (1.0 + ratio * a)) == pytest.approx(mean, rel=1e-12)


def test_mean_power_to_dead_centre_is_work_over_time():
    """The load moves by half a step, and the follower gets its greatest speed."""
    speed, load, inertia = 2.0, 3.0, 0.75
    for n in range(3, 11):
        wheel = esc.Geneva(n, pins=1)
        work = load * 0.5 * wheel.follower_step
        work += 0.5 * inertia * (speed * float(geneva.ratio_max(n))) ** 2
        found = esc.index(wheel, speed, load, follower_inertia=inertia).power_mean_to_dead_centre
        assert found == pytest.approx(work * speed / -wheel.breaks[0], rel=1e-12)


def test_limit_angles():
    found = -np.degrees(geneva.limit_angle(np.arange(3, 11)))
    np.testing.assert_allclose(found, LIMIT_ANGLES, atol=5e-4)
    by_root = esc.reversal_study(np.arange(3, 101), 1e15).torque_max_angle
    np.testing.assert_allclose(geneva.limit_angle(np.arange(3, 101)), by_root, rtol=1e-11)


# --- figures ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NOMOGRAMS)
def test_nomograms_can_be_read_by_hand(name):
    """A ruler on the printed sheet gives the torque; rulings are at least 0.4 mm apart."""
    sheet = NOMOGRAMS[name]
    figure = plot_nomogram(sheet)
    figure.draw_without_rendering()
    left, right = figure.axes
    for ax, axis in ((left, "x"), (left, "y"), (right, "x")):
        rulings = by_id(ax, f"rulings-{axis}")
        starts = rulings.get_transform().transform([ends[0] for ends in rulings.get_segments()])
        pixels = np.sort(starts[:, "xy".index(axis)])
        assert np.diff(pixels).min() / figure.dpi * 25.4 > 0.4
    for n, line in zip(sheet.slots, left.lines, strict=False):
        ratio = 0.37 * sheet.ratios[1]
        factor = np.exp(np.interp(np.log(ratio), *np.log(line.get_data())))
        drive = esc.index(esc.Geneva(n, pins=1), 1.0, 2.5, follower_inertia=2.5 * ratio)
        assert 2.5 * factor == pytest.approx(getattr(drive, sheet.column), rel=1e-3)
        assert left.get_ylim()[0] <= factor <= left.get_ylim()[1]
        assert right.get_xlim()[0] <= 2.5 * factor <= right.get_xlim()[1]


# --- command line -------------------------------------------------------------------------


def test_drive_torque_json(report):
    options = ["--slots", 8, "--speed", 10, "--load-torque", 1, "--follower-inertia", 0.019]
    record = report("drive-torque", *options, "--efficiency", 0.9)
    assert set(record) >= KEYS
    result = esc.index(esc.Geneva(8), 10.0, 1.0, follower_inertia=0.019, efficiency=0.9)
    assert record["inertia_ratio"] == pytest.approx(1.9)
    assert record["reversal_limits"] == pytest.approx([1.429067551568061, 2.414213562373095])
    assert record["reversals_deg"] == pytest.approx(np.degrees(result.reversals))
    assert record["zone"] == 2
    expected = {
        "torque_max": result.torque_max,
        "power_max": 10.0 * result.torque_max,
        "torque_max_over_mean": result.torque_max_over_mean,
        "greatest_speed": math.sqrt(record["reversal_limits"][0] / 0.019),
        "greatest_follower_inertia": record["reversal_limits"][0] / 100.0,
        "least_load_torque": 1.9 / record["reversal_limits"][0],
    }
    assert {name: record[name] for name in expected} == pytest.approx(expected, rel=1e-12)


def test_drive_torque_table_and_picture(command, tmp_path):
    options = ["--internal", "--speed", 10, "--load-torque", 1, "--follower-inertia", 0.001]
    code, out, err = command("drive-torque", *options, "--plot", "torque.png")
    assert code == 0
    assert err.splitlines()[-1] == "escapement: drive-torque is the old name of index"
    rows = dict(line.split("  ", 1) for line in out.partition("\n\n")[2].splitlines())
    assert rows["reversals"].strip() == "none"
    assert rows["greatest speed without reversal"].split()[1] == "rad/s"
    assert (tmp_path / "torque.png").read_bytes().startswith(b"\x89PNG")


def test_what_does_not_exist_is_null_with_a_message(command):
    options = ["--speed", 10, "--load-torque", 0, "--follower-inertia", 0.001, "--json"]
    code, out, err = command("drive-torque", *options)
    record = json.loads(out)
    assert set(record) >= KEYS | {"message"}
    assert (code, record["inertia_ratio"], record["reversals_deg"]) == (0, None, [0.0])
    assert all("F is not defined without a load" in text for text in (record["message"], err))


def test_reproduce_prints_every_cell_and_erratum(command):
    code, out, err = command("reproduce", "filemon")
    assert (code, err) == (0, "")
    assert "30 of 48 cells are right to their last digit" in out
    assert out.count(" must be ") == len(ERRATA) + len(read_slips("filemon"))
    for row in filemon.printed_rows().values():
        assert all(row[column] in out for column in filemon.COLUMNS)


# --- what the page says of the paper ------------------------------------------------------


def test_overloads_of_a_motor_that_is_chosen_by_the_mean():
    ratio = np.append(np.geomspace(0.1, 1e4, 400), 1e12)
    found = esc.reversal_study(np.arange(3, 11)[:, None], ratio).peak_to_mean
    low, high = found.min(axis=1), found.max(axis=1)
    told = [f"{low[k]:.1f} to {high[k]:.1f} with {k + 3}" for k in range(4)]
    told.append(f"{low[4:].min():.1f} to {high[4:].max():.1f} with 7 to 10")
    page = (DOCS / "indexing-drive.md").read_text("utf-8")
    assert all(words in page.replace("with 3 slots", "with 3") for words in told), told
