"""Mechanisms from tables: accuracy of the spline and of its own error estimate; motions."""

import math

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.mechanisms.protocol import Mechanism
from tabulated_drive import ANGLES, DRIVE, INERTIA, exact, measured

# --- the spline ---------------------------------------------------------------------------


def test_exact_tables_converge_with_the_sixth_power():
    """Position, g and g' of ever finer tables against the closed form."""
    rows = np.array([40, 80, 160, 320])
    truth = DRIVE.transmission(ANGLES)
    errors = []
    for count in rows:
        table = exact(count)
        found = table.transmission(ANGLES)
        moved = table.follower_angle(ANGLES) - table.follower_angle(0.0)
        errors.append(
            [
                np.abs(moved - DRIVE.follower_angle(ANGLES)).max(),
                np.abs(found.g - truth.g).max(),
                np.abs(found.dg - truth.dg).max(),
            ]
        )
    orders = np.polynomial.polynomial.polyfit(np.log(rows), np.log(np.array(errors)), 1)[1]
    np.testing.assert_allclose(-orders, [6.0, 6.0, 4.0], atol=1.0)


def test_noise_is_found_and_its_effect_is_not_understated():
    """Twelve samples: the deviations it gives cover the errors it makes."""
    rows, noise = 148, math.radians(1.298)
    truth = DRIVE.transmission(ANGLES[::8])
    shares, errors = [], []
    for seed in range(12):
        table = measured(rows, noise, seed)
        shares.append(table.noise / noise)
        found, doubt = table.transmission(ANGLES[::8]), table.deviation(ANGLES[::8])
        errors.append(
            [
                np.mean((found.g - truth.g) ** 2) / np.mean(doubt.g**2),
                np.mean((found.dg - truth.dg) ** 2) / np.mean(doubt.dg**2),
            ]
        )
    # the deviation of a standard deviation of so many rows, less what the curve takes
    assert np.mean(shares) == pytest.approx(1.0, abs=4.0 / math.sqrt(2 * 12 * (rows - 30)))
    mean = np.mean(errors, axis=0)
    assert (mean < 1.2).all()
    assert (mean > 0.01).all()


@pytest.mark.parametrize("sense", [-1.0, 1.0])
def test_the_follower_angle_grows(sense):
    table = exact(60, sense)
    assert table.sense == sense
    assert isinstance(table, Mechanism)
    assert table.follower_step == pytest.approx(DRIVE.follower_step, rel=1e-14)
    assert table.motion_ratio == 1.0
    turned = np.diff(table.follower_angle(np.array([0.3, 0.3 + table.cell_angle])))
    assert turned[0] == pytest.approx(table.follower_step, rel=1e-12)
    assert (np.diff(table.follower_angle(ANGLES)) > -1e-9).all()


# --- motions ------------------------------------------------------------------------------


def test_a_table_of_a_drive_moves_like_the_drive():
    truth = esc.terminal(esc.Escapement(DRIVE, INERTIA, 0.01, efficiency=0.9))
    for rows, off in ((60, 1e-6), (240, 1e-8)):
        found = esc.terminal(esc.Escapement(exact(rows), INERTIA, 0.01, efficiency=0.9))
        assert found.velocity_max == pytest.approx(truth.velocity_max, rel=off)


def test_everything_else_takes_a_table(tmp_path):
    table = exact(60)
    drive, same = (
        esc.index(one, 10.0, 0.01, follower_inertia=2e-5, efficiency=0.9) for one in (table, DRIVE)
    )
    assert drive.torque_max == pytest.approx(same.torque_max, rel=1e-5)
    assert drive.follower_velocity_max == pytest.approx(10.0 * DRIVE.ratio_max, rel=1e-6)
    timer = esc.Escapement(table, INERTIA, 0.01, efficiency=0.9)
    study = esc.sweep(timer, efficiency=[0.7, 0.9], path=tmp_path / "study.h5")
    assert np.isfinite(study.results["period"]).all()
    timer = esc.Escapement(measured(200, 0.005), INERTIA, 0.01, efficiency=0.9)
    study = esc.sweep(timer, efficiency=[0.7, 0.9])
    assert study.results["period"][1] == pytest.approx(esc.terminal(timer).period, rel=1e-9)


def test_a_follower_that_turns_back_has_kinematics_and_no_motion():
    theta = np.linspace(0.0, 2.0 * math.pi, 61)
    table = esc.Tabulated(theta, theta + 2.0 * np.sin(theta))
    assert float(table.transmission(math.pi).g) == pytest.approx(-1.0, abs=1e-4)
    with pytest.raises(InvalidValue, match=r"phi must rise .* theta = 3\.14"):
        esc.Escapement(table, INERTIA, 1.0)
    # within the noise of a measured table a stop may look like that
    noisy = measured(148, math.radians(1.298), seed=1)
    assert noisy.transmission(ANGLES).g.min() < 0.0
    assert esc.terminal(esc.Escapement(noisy, INERTIA, 0.01, efficiency=0.9)).velocity_max > 0.0


def test_a_part_of_the_cell_without_rows_is_warned_about():
    wheel = esc.Geneva(6, pins=1)
    cell = {"cell_angle": wheel.cell_angle, "follower_step": wheel.follower_step}
    theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 60)
    with pytest.warns(UserWarning, match="none for 240 of 360 degrees after 60: the curve there"):
        table = esc.Tabulated(theta, wheel.follower_angle(theta), **cell)
    dwell = np.linspace(90.0, 240.0, 6) * np.pi / 180.0
    assert np.abs(table.follower_angle(dwell) - wheel.follower_angle(theta[-1])).max() > 0.05
    # with rows at even distances throughout it is not
    whole = np.append(theta, wheel.breaks[-1] + np.radians(np.arange(2.0, 240.0, 2.0)))
    rows = np.append(wheel.follower_angle(theta), np.full(119, wheel.follower_angle(theta[-1])))
    table = esc.Tabulated(whole, rows, **cell)
    assert np.abs(table.follower_angle(dwell) - rows[-1]).max() < 1e-6


def test_rows_at_random_are_not_warned_of_gaps():
    for seed in range(200):  # a warning would be an error
        theta = np.random.default_rng(seed).uniform(0.0, 1.0, 12 + seed)
        esc.Tabulated(theta, theta, measured=True, cell_angle=1.0, follower_step=1.0)


def test_a_measured_table_is_drawn_with_its_doubt():
    from matplotlib.figure import Figure

    from escapement.plots import plot_table

    table = measured(300, math.radians(0.3))
    ax = plot_table(table, Figure().add_subplot())
    (band,) = ax.collections
    heights = band.get_paths()[0].vertices[:, 1]
    assert np.ptp(heights) > DRIVE.ratio_max
    assert len(ax.lines[-1].get_xdata()) == 300
    assert not plot_table(exact(24)).collections
