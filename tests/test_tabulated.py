"""Mechanisms from tables: accuracy of the spline, of what it says of itself, and motions."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import escapement as esc
from escapement.errors import InvalidValue
from escapement.mechanisms._periodic_spline import interpolating, smoothing
from escapement.model import Mechanism
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


@settings(deadline=None, max_examples=20)
@given(st.integers(12, 60), st.integers(0, 1000))
def test_it_goes_through_its_points_and_repeats_itself(rows, seed):
    random = np.random.default_rng(seed)
    x = np.cumsum(random.uniform(0.5, 1.5, rows + 1))
    y = random.standard_normal(rows + 1)
    y[-1] = y[0]
    spline = interpolating(x, y)
    np.testing.assert_allclose(spline(x), y, rtol=0.0, atol=1e-7)
    for order in range(5):
        ends = spline(x[[0, -1]], order)
        size = np.abs(spline(np.linspace(x[0], x[-1], 201), order)).max()
        assert ends[0] == pytest.approx(ends[1], abs=1e-9 * size)
        np.testing.assert_allclose(
            spline(x[:-1] + 0.1 + 3 * spline.period, order), spline(x[:-1] + 0.1, order),
            rtol=0.0, atol=1e-6 * size,
        )  # fmt: skip


def test_a_sine_comes_through_noise():
    """Ten samples: errors are what the deviations say, and few parameters are spent."""
    angles = np.linspace(0.0, 2.0 * math.pi, 301)
    noises, errors, doubts = [], [], []
    for seed in range(10):
        random = np.random.default_rng(seed)
        x = np.sort(random.uniform(0.0, 2.0 * math.pi, 500))
        spline = smoothing(x, np.sin(x) + 0.1 * random.standard_normal(x.size), 2.0 * math.pi)
        noises.append(spline.noise)
        errors.append(np.mean((spline(angles) - np.sin(angles)) ** 2))
        doubts.append(np.mean(spline.deviation(angles) ** 2))
    assert np.mean(noises) == pytest.approx(0.1, abs=4.0 * 0.1 / math.sqrt(2 * 10 * 480))
    assert np.mean(errors) == pytest.approx(np.mean(doubts), rel=0.5)
    assert np.mean(errors) < 0.1**2 * 12 / 500


@pytest.mark.parametrize(("rows", "noise_deg"), [(148, 1.298), (2000, 0.1)])
def test_noise_is_found_and_its_effect_is_not_understated(rows, noise_deg):
    """Twelve samples: the deviations it gives cover the errors it makes."""
    noise = math.radians(noise_deg)
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


def test_smooth_tables_follow_the_drive():
    table = measured(1000, math.radians(0.05))
    found = table.transmission(ANGLES)
    assert np.abs(found.g - DRIVE.transmission(ANGLES).g).max() < 0.01
    assert np.abs(table.follower_angle(ANGLES) - table.follower_angle(0.0)
                  - DRIVE.follower_angle(ANGLES)).max() < math.radians(0.05)  # fmt: skip
    # rows of any cells: the cell about zero that begins where the follower is slowest
    assert table.breaks[0] <= 0.0 < table.breaks[1]
    assert table.breaks[0] == pytest.approx(DRIVE.breaks[0], abs=0.1)
    assert float(table.transmission(table.breaks[0]).g) < 0.01
    assert exact(60).breaks == DRIVE.breaks
    np.testing.assert_array_equal(exact(60).deviation([0.0, 1.0]).g, 0.0)
    assert exact(60).noise == 0.0


def test_rows_of_several_cells_in_any_order():
    """An exact table folded into one cell is the table of that cell."""
    theta = np.linspace(*DRIVE.breaks, 61)[:-1]
    turns = np.array([5, -2, 0, 3] * 15)
    away = theta + DRIVE.cell_angle * turns
    phi = -DRIVE.follower_angle(away)
    order = np.random.default_rng(3).permutation(theta.size)
    table = esc.Tabulated(
        away[order], phi[order], cell_angle=DRIVE.cell_angle, follower_step=DRIVE.follower_step
    )
    found = table.transmission(ANGLES)
    np.testing.assert_allclose(found.g, exact(60).transmission(ANGLES).g, rtol=0.0, atol=1e-10)


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
    errors = []
    for rows in (60, 240):
        timer = esc.Escapement(exact(rows), INERTIA, 0.01, efficiency=0.9)
        found = esc.terminal(timer)
        errors.append(abs(found.velocity_max / truth.velocity_max - 1.0))
    assert errors[0] < 1e-6
    assert errors[1] < 1e-8


def test_engines_agree_on_a_measured_mechanism():
    table = measured(1000, math.radians(0.05))
    timer = esc.Escapement(table, INERTIA, 0.01, efficiency=0.9, load_torque=0.002)
    fast = esc.simulate(timer, 6)
    slow = esc.simulate(timer, 6, engine="ivp", rtol=1e-10)
    # steps in the third derivative of g cost both a few digits
    np.testing.assert_allclose(fast.handoff_times, slow.handoff_times, rtol=1e-7)
    np.testing.assert_allclose(fast.handoff_velocities, slow.handoff_velocities, rtol=1e-7)


def test_everything_else_takes_a_table(tmp_path):
    table = exact(60)
    drive = esc.drive_torque(table, 10.0, 0.01, 2e-5, efficiency=0.9)
    same = esc.drive_torque(DRIVE, 10.0, 0.01, 2e-5, efficiency=0.9)
    assert drive.torque_max == pytest.approx(same.torque_max, rel=1e-5)
    extrema = esc.transmission_extrema(table)
    assert extrema.ratio_max.value == pytest.approx(DRIVE.ratio_max, rel=1e-6)
    timer = esc.Escapement(table, INERTIA, 0.01, efficiency=0.9)
    study = esc.sweep(timer, efficiency=[0.7, 0.9], path=tmp_path / "study.h5")
    assert np.isfinite(study.results["period"]).all()
    timer = esc.Escapement(measured(200, 0.005), INERTIA, 0.01, efficiency=0.9)
    study = esc.sweep(timer, efficiency=[0.7, 0.9])
    assert study.results["period"][1] == pytest.approx(esc.terminal(timer).period, rel=1e-9)


@pytest.mark.parametrize("table", [exact(24), measured(40, 0.005)], ids=["exact", "measured"])
def test_a_motion_of_a_table_is_written_and_read(table, tmp_path):
    from escapement.motion_file import read_motion, write_motion

    motion = esc.simulate(esc.Escapement(table, INERTIA, 0.01, efficiency=0.9), 3)
    write_motion(motion, tmp_path / "motion.h5")
    again = read_motion(tmp_path / "motion.h5")
    assert again.escapement.mechanism == motion.escapement.mechanism
    times = np.linspace(0.0, motion.end_time, 50)
    np.testing.assert_allclose(again.at(times).theta_dot, motion.at(times).theta_dot, rtol=1e-9)


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
    with pytest.warns(UserWarning, match="none for 240 of 360 degrees after 60: the curve across"):
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


def test_its_repr_is_short_and_tells_tables_apart():
    table, other = exact(200), exact(201)
    text = repr(esc.Escapement(table, esc.Inertia(1e-6, 1e-5), 0.01, efficiency=0.9))
    assert repr(table) in text
    assert len(text) < 350
    assert repr(table).startswith("Tabulated(<201 rows, checksum ")
    moved = esc.Tabulated(table.theta, 1.0 + np.array(table.phi))
    assert len({repr(table), repr(other), repr(moved)}) == 3
    assert repr(esc.Tabulated(table.theta, table.phi)) == repr(table)


def test_a_measured_table_is_drawn_with_its_doubt():
    from matplotlib.figure import Figure

    from escapement.plots.tabulated import plot_table

    table = measured(300, math.radians(0.3))
    ax = plot_table(table, Figure().add_subplot())
    (band,) = ax.collections
    heights = band.get_paths()[0].vertices[:, 1]
    assert np.ptp(heights) > DRIVE.ratio_max
    assert len(ax.lines[-1].get_xdata()) == 300
    assert not plot_table(exact(24)).collections
