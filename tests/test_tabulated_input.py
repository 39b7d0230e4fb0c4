"""Tables that are read, refused, or named on the command line."""

import math

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InputFileError, InvalidValue
from tabulated_drive import DRIVE, INERTIA


@pytest.mark.parametrize(
    ("heading", "turned", "units"),
    [
        ("theta,phi", False, (1.0, 1.0)),
        ("first,second", False, (1.0, 1.0)),
        ("rad,rad", False, (180.0 / math.pi, 180.0 / math.pi)),
        ("driver (deg),follower (rad)", False, (1.0, 180.0 / math.pi)),
        ("phi_deg,theta_deg", True, (1.0, 1.0)),
        ("Follower [rad],angle [deg]", True, (180.0 / math.pi, 1.0)),
        ("angle,input", True, (1.0, 1.0)),
        ("theta (rad) phi (rad)", False, (180.0 / math.pi, 180.0 / math.pi)),
    ],
)
def test_headings_tell_order_and_unit(tmp_path, heading, turned, units):
    theta = np.linspace(-40.0, 50.0, 31)
    phi = theta - 20.0 * np.sin(np.radians(4.0 * theta)) / 4.0
    columns = np.column_stack([phi, theta] if turned else [theta, phi]) / units
    between = "," if "," in heading else " "
    np.savetxt(tmp_path / "table.csv", columns, "%.17g", between, header=heading, comments="")
    table = esc.Tabulated.from_csv(tmp_path / "table.csv")
    np.testing.assert_allclose(table.theta, np.radians(theta), rtol=1e-14)
    np.testing.assert_allclose(table.phi, np.radians(phi), rtol=1e-14)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1 2\n3 4 5\n", ["2 fields separated by blanks", "line 2", "'3 4 5'"]),
        ("1,2\n3,nan\n", ["two finite numbers", "line 2"]),
        ("O.0,0.0\n1,2\n", ["numbers in fields", "line 1", "'O.0,0.0'"]),
        ("0,0,\n1,2\n", ["name its 3 columns", "line 1", "'0,0,'"]),
        ("theta rad phi rad\n1 2\n", ["4 fields separated by blanks", "line 2", "'1 2'"]),
        ("theta_rad,phi\n1,2\n", ["units of both columns", "theta_deg,phi_deg"]),
    ],
)
def test_tables_that_cannot_be_read(tmp_path, text, words):
    place = tmp_path / "table.csv"
    place.write_text(text)
    with pytest.raises(InputFileError) as caught:
        esc.Tabulated.from_csv(place)
    assert "\n" not in str(caught.value)
    assert all(word in str(caught.value) for word in words)


# --- printed to a few decimals ------------------------------------------------------------

CELL, STEP = 0.5 * np.pi, np.pi / 3.0


def printed(rows, cells, decimals, unit):
    """A made-up drive that stops at the ends of its cell, rounded."""
    theta = np.linspace(0.0, cells * CELL, rows)
    phi = STEP * theta / CELL - 0.6 * STEP / (2.0 * np.pi) * np.sin(4.0 * theta)
    return [np.round(angles / unit, decimals) * unit for angles in (theta, phi)]


@pytest.mark.parametrize("unit", [1.0, np.pi / 180.0], ids=["rad", "degrees"])
@pytest.mark.parametrize("decimals", [3, 5, 8])
def test_a_rounded_last_row_is_the_end_of_the_cell(decimals, unit):
    """With the cell given or not: the slope is wrong by what the rounding makes of it."""
    theta, phi = printed(61, 1, decimals, unit)
    if 10.0**-decimals * unit > 5e-6:
        # the follower's acceleration would be wrong by more than a fiftieth of its greatest
        with pytest.raises(InvalidValue, match=r"phi rounded to .* give measured=True"):
            assert esc.Tabulated(theta, phi).spline
        return
    given = esc.Tabulated(theta, phi, cell_angle=CELL, follower_step=STEP)
    angles = np.linspace(0.0, CELL, 201)
    true = STEP / CELL - 0.6 * STEP * 4.0 / (2.0 * np.pi) * np.cos(4.0 * angles)
    for table in (given, esc.Tabulated(theta, phi)):
        off = np.abs(table.transmission(angles).g - true).max()
        assert off <= 4.0 * 10.0**-decimals * unit / (CELL / 60.0)


@pytest.mark.parametrize("decimals", [4, 8])
def test_rows_that_rounding_brings_together_are_refused_with_the_reason(decimals):
    """The last of four cells is the first again, and would make a slope of its rounding."""
    theta, phi = printed(158, 4, decimals, 1.0)
    with pytest.raises(InvalidValue, match=r"theta must differ .* measured"):
        assert esc.Tabulated(theta, phi, cell_angle=CELL, follower_step=STEP).spline
    measured = esc.Tabulated(theta, phi, measured=True, cell_angle=CELL, follower_step=STEP)
    assert float(measured.transmission(0.5 * CELL).g) == pytest.approx(1.6 * STEP / CELL, rel=0.01)


@pytest.mark.parametrize("decimals", [2, 4, 6])
@pytest.mark.parametrize("rows", [42, 163, 406])
def test_a_rounded_table_is_refused_or_its_accelerations_are_right(rows, decimals):
    theta = np.linspace(*DRIVE.breaks, rows)
    phi = np.radians(np.round(np.degrees(DRIVE.follower_angle(theta)), decimals))
    angles = np.linspace(*DRIVE.breaks, 5001)
    true = DRIVE.transmission(angles).dg
    greatest = np.abs(true).max()
    try:
        found = esc.Tabulated(theta, phi).transmission(angles).dg
    except InvalidValue:
        # not for nothing: with half as many digits to spare again it would be taken
        assert 4.0 * math.radians(10.0**-decimals) > 0.01 * greatest * (theta[1] - theta[0]) ** 2
    else:
        assert np.abs(found - true).max() < 0.025 * greatest


@pytest.mark.parametrize("wrong", [1.4, 2.0])
def test_a_step_that_measured_rows_do_not_turn_by_is_refused(wrong):
    theta, phi = printed(61, 1, 4, np.pi / 180.0)
    phi += 0.003 * np.random.default_rng(4).standard_normal(61)
    options = {"measured": True, "cell_angle": CELL}
    assert esc.Tabulated(theta, phi, follower_step=STEP, **options).noise < 0.006
    with pytest.raises(InvalidValue, match="follower_step must be what phi turns"):
        esc.Tabulated(theta, phi, follower_step=wrong * STEP, **options)


# --- command line -------------------------------------------------------------------------


@pytest.fixture
def table_file(tmp_path):
    """The drive as 61 rows of a table."""
    theta = np.linspace(*DRIVE.breaks, 61)
    columns = np.degrees(np.column_stack([theta, -DRIVE.follower_angle(theta)]))
    np.savetxt(tmp_path / "table.csv", columns, delimiter=",", fmt="%.17g")


@pytest.mark.usefixtures("table_file")
def test_commands_take_a_table(report, tmp_path):
    record = report("mechanism", "tabulated", "--table", "table.csv", "--plot", "g.svg")
    assert record["cell_angle_deg"] == pytest.approx(202.5)
    assert record["transmission_max"] == pytest.approx(DRIVE.ratio_max, rel=1e-5)
    assert record["noise_deg"] == 0.0
    assert (tmp_path / "g.svg").stat().st_size > 1000
    options = ("--torque", 0.01, "--driver-inertia", 1e-5, "--follower-inertia", 2e-5)
    found = report("run", "tabulated", "--table", "table.csv", *options, "--efficiency", 0.9)
    truth = esc.terminal(esc.Escapement(DRIVE, INERTIA, 0.01, efficiency=0.9))
    assert found["velocity_max"] == pytest.approx(truth.velocity_max, rel=1e-6)
    constant = ("--speed", 10, "--load-torque", 0.01, "--follower-inertia", 2e-4)
    torque = report("index", "tabulated", "--table", "table.csv", *constant)
    assert "scatter" not in torque.get("message", "")
    rows = np.loadtxt("table.csv", delimiter=",", skiprows=1)
    rows[:, 1] += np.random.default_rng(3).standard_normal(len(rows))
    np.savetxt("scattered.csv", rows, delimiter=",")
    scattered = ("tabulated", "--table", "scattered.csv", "--measured")
    torque = report("index", *scattered, *constant)
    assert "the scatter of the table makes the contact moment uncertain by" in torque["message"]
