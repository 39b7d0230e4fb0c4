"""Meyer's listing against the tables it printed, and against its own mistakes."""

import numpy as np
import pytest

from escapement.errors import InvalidValue
from escapement.mechanisms import Geneva
from escapement.sources.meyer import INERTIAS, PrintedRun, listing, printed_rows
from escapement.sources.meyer.program import program_1973, read_printout
from escapement.units import INCH_POUND

HIGH_RATE = (4, 0.35, 0.20, *INERTIAS[4])  # the run of recommendation 2


@pytest.fixture(scope="module")
def readings():
    return [(row, read_printout(program_1973(*_arguments(row)))) for row in printed_rows()]


@pytest.fixture(scope="module")
def high_rate():
    return program_1973(*HIGH_RATE)


def _arguments(row: PrintedRun):
    return row.slots, row.friction, row.torque_inlbf, *INERTIAS[row.slots]


def _where(row: PrintedRun) -> str:
    return f"{row.slots} slots, friction {row.friction}, torque {row.torque_inlbf}"


def test_periods_and_minima_of_all_49_rows(readings):
    for row, reading in readings:
        # rounded to 1 ms (0.5 ms) from a spacing of rows 0.5 ms apart (another 0.5 ms)
        assert reading.period == pytest.approx(row.period, abs=1e-3), _where(row)
        # half a printed digit, and 0.1 where a slow run is not yet terminal at 67 ms
        assert reading.velocity_min == pytest.approx(row.velocity_min, abs=0.6), _where(row)


def test_maxima_of_all_49_rows(readings):
    # a 0.5 ms row falls anywhere on a peak: two rows are off by more than a digit
    off = [abs(reading.velocity_max - row.velocity_max) for row, reading in readings]
    assert sum(deviation <= 1.0 for deviation in off) >= 47
    assert sum(deviation <= 0.5 for deviation in off) >= 36
    for (row, _), deviation in zip(readings, off, strict=True):
        assert deviation <= 0.021 * row.velocity_max, _where(row)


def test_rise_times_read_by_eye(readings):
    near = [abs(reading.rise_time - row.rise_time) <= row.period / 2 for row, reading in readings]
    assert len(near) == 49
    assert sum(near) >= 44


def test_six_pin_table_needs_the_inertias_of_figure_11(readings):
    for row, _ in readings:
        if row.slots == 3:
            swapped = program_1973(3, row.friction, row.torque_inlbf, *INERTIAS[3][::-1])
            assert read_printout(swapped).period < row.period - 5e-3, _where(row)


def test_the_peak_wanders_at_a_high_spring_rate_by_sampling_not_by_dynamics(high_rate):
    peaks = read_printout(high_rate).peaks
    assert peaks.min() == pytest.approx(161.6, abs=0.5)
    assert peaks.max() == pytest.approx(166.5, abs=0.5)
    assert np.ptp(peaks) > 4.0
    whole = read_printout(program_1973(*HIGH_RATE, interval=1e-5)).peaks
    assert np.ptp(whole) < 0.3


def test_table_has_a_row_per_half_millisecond_and_begins_at_rest(high_rate):
    np.testing.assert_allclose(high_rate.time, 0.0005 * np.arange(401))
    assert {getattr(high_rate, name).shape for name in high_rate.__dataclass_fields__} == {(401,)}
    # at entry g vanishes but for pi = 3.1416, so only the driver is accelerated
    assert high_rate.theta_ddot[0] == pytest.approx(0.20 / 3e-6, rel=1e-4)
    assert high_rate.theta[0] == high_rate.theta_dot[0] == high_rate.phi_dot[0] == 0.0


@pytest.mark.parametrize("slots", [3, 4, 6])
def test_follower_speed_is_the_wrapped_transmission(slots):
    printout = program_1973(slots, 0.25, 0.1, *INERTIAS[slots])
    mechanism = Geneva(slots)
    x = np.fmod(printout.theta, 1.5708) - np.pi / mechanism.pins
    expected = mechanism.transmission(x).g * printout.theta_dot
    # 3.1416 is 7e-6 too large; g' <= 31.4 turns that into 1e-4 of the driver's speed
    np.testing.assert_allclose(printout.phi_dot, expected, atol=3e-4 * printout.theta_dot.max())
    assert (printout.phi_dot.min() < -1.0) == (slots == 3)  # past the true exit


def test_without_friction_energy_is_the_work_done():
    driver, follower = INERTIAS[4]
    printout = program_1973(4, 0.0, 0.1, driver, follower, duration=0.1)
    energy = 0.5 * (driver * printout.theta_dot**2 + follower * printout.phi_dot**2)
    # 5e-6 a step for some 2000 steps would be 1e-2; the method's order leaves far less
    np.testing.assert_allclose(energy[1:], 0.1 * printout.theta[1:], rtol=2e-4)


def test_shorter_run_is_the_beginning_of_a_longer_one(high_rate):
    short = program_1973(*HIGH_RATE, duration=0.1)
    for name in short.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(short, name), getattr(high_rate, name)[:201])


def test_only_ratios_count(high_rate):
    slots, friction, *rest = HIGH_RATE
    si = program_1973(slots, friction, *(value * INCH_POUND for value in rest))
    np.testing.assert_allclose(si.theta_dot, high_rate.theta_dot, rtol=1e-5)


def test_print_rows_do_not_steer_the_integration(high_rate):
    dense = program_1973(*HIGH_RATE, interval=0.0001)
    # 0.1 % of the speed lost at a jump, where a row cuts a step, is 0.1 rad/s
    np.testing.assert_allclose(high_rate.theta_dot, dense.theta_dot[::5], atol=0.2)


def test_friction_sign_sees_the_acceleration_of_50_microseconds_ago():
    printout = program_1973(*HIGH_RATE, interval=1e-6, duration=0.0305)
    late = slice(25000, None)  # dead centre is passed at 23 ms
    time, acceleration = printout.time[late], printout.theta_ddot
    transmission = Geneva(4).transmission(np.fmod(printout.theta, 1.5708) - np.pi / 4)

    def switch(delay_us: int) -> float:
        old = np.roll(acceleration, delay_us)
        force = transmission.dg * printout.theta_dot**2 + transmission.g * old
        return time[np.flatnonzero(force[late] < 0)[0]]

    jumps = np.flatnonzero(np.abs(np.diff(acceleration[late])) > 2000.0)
    assert time[jumps[0]] == pytest.approx(switch(50), abs=3e-6)
    assert switch(40) > switch(50) + 2e-5
    # an old, lower acceleration turns the sign before the pin reverses; the jump
    # it causes turns it back 50 us later, and so on until the reversal is there
    assert switch(50) < switch(0) - 2e-4
    assert time[jumps[1]] - time[jumps[0]] == pytest.approx(50e-6, abs=3e-6)


def test_delayed_value_interpolates_and_starts_at_the_first_one():
    times, values = np.zeros(listing._LINE), np.zeros(listing._LINE)
    times[:3], values[:3] = [0.0, 1.0, 3.0], [5.0, 7.0, 1.0]
    seen = [listing._delayed(times, values, 2, t) for t in (-4.0, 0.0, 0.5, 1.0, 2.0, 3.0)]
    assert seen == [5.0, 5.0, 6.0, 7.0, 4.0, 1.0]


@pytest.mark.parametrize(
    ("name", "value", "rule"),
    [
        ("slots", 5, ""),
        ("friction", 0.5, "below the Painleve limit"),
        ("torque", 0.0, ""),
        ("follower_inertia", float("nan"), ""),
        ("duration", 1e-4, ""),
        ("interval", 1e-9, ""),
    ],
)
def test_arguments_are_checked(name, value, rule):
    names = ("slots", "friction", "torque", "driver_inertia", "follower_inertia")
    with pytest.raises(InvalidValue, match=f"{name} must be {rule}"):
        program_1973(**(dict(zip(names, HIGH_RATE, strict=True)) | {name: value}))


def test_reading_a_run_without_handoffs_gives_no_period():
    reading = read_printout(program_1973(4, 0.2, 0.01, *INERTIAS[4], duration=0.01))
    assert np.isnan(reading.period)
    assert reading.peaks.size == 0
