"""Meyer's listing: its mistakes, and how the printed tables were read from it."""

import numpy as np
import pytest

from escapement.base.errors import InvalidValue
from escapement.mechanisms import Geneva
from escapement.mechanisms.slotted import transmission
from escapement.sources.meyer import INERTIAS, printed_rows
from escapement.sources.meyer.program import program_1973, read_printout

HIGH_RATE = (4, 0.35, 0.20, *INERTIAS[4])  # the run of recommendation 2


@pytest.fixture(scope="module")
def high_rate():
    return program_1973(*HIGH_RATE)


def test_six_pin_table_needs_the_inertias_of_figure_11():
    for row in printed_rows()[:16]:
        run = (3, row.friction, row.torque_inlbf, *INERTIAS[3][::-1])
        assert read_printout(program_1973(*run)).period < row.period - 5e-3, row


def test_the_peak_wanders_at_a_high_spring_rate_by_sampling_not_by_dynamics(high_rate):
    peaks = read_printout(high_rate).peaks
    assert peaks.min() == pytest.approx(161.6, abs=0.5)
    assert peaks.max() == pytest.approx(166.5, abs=0.5)
    assert np.ptp(peaks) > 4.0
    whole = read_printout(program_1973(*HIGH_RATE, interval=1e-5)).peaks
    assert np.ptp(whole) < 0.3


def test_table_has_a_row_per_half_millisecond_and_begins_at_rest(high_rate):
    np.testing.assert_allclose(high_rate.time, 0.0005 * np.arange(401))
    assert {column.shape for column in high_rate} == {(401,)}
    # at entry g vanishes but for pi = 3.1416, so only the driver is accelerated
    assert high_rate.theta_ddot[0] == pytest.approx(0.20 / 3e-6, rel=1e-4)
    assert high_rate.theta[0] == high_rate.theta_dot[0] == high_rate.phi_dot[0] == 0.0
    short = program_1973(*HIGH_RATE, duration=0.1)
    np.testing.assert_array_equal(short, np.array(high_rate)[:, :201])


@pytest.mark.parametrize("slots", [3, 4, 6])
def test_follower_speed_is_the_wrapped_transmission(slots):
    printout = program_1973(slots, 0.25, 0.1, *INERTIAS[slots])
    mechanism = Geneva(slots)
    x = np.fmod(printout.theta, 1.5708) - np.pi / mechanism.pins
    expected = transmission(mechanism.path, x).g * printout.theta_dot
    # 3.1416 is 7e-6 too large; g' <= 31.4 turns that into 1e-4 of the driver's speed
    np.testing.assert_allclose(printout.phi_dot, expected, atol=3e-4 * printout.theta_dot.max())
    assert (printout.phi_dot.min() < -1.0) == (slots == 3)  # past the true exit


def test_without_friction_energy_is_the_work_done():
    driver, follower = INERTIAS[4]
    printout = program_1973(4, 0.0, 0.1, driver, follower, duration=0.1)
    energy = 0.5 * (driver * printout.theta_dot**2 + follower * printout.phi_dot**2)
    # 5e-6 a step for some 2000 steps would be 1e-2; the method's order leaves far less
    np.testing.assert_allclose(energy[1:], 0.1 * printout.theta[1:], rtol=2e-4)


def test_friction_sign_sees_the_acceleration_of_50_microseconds_ago():
    printout = program_1973(*HIGH_RATE, interval=1e-6, duration=0.0305)
    late = slice(25000, None)  # dead centre is passed at 23 ms
    time, acceleration = printout.time[late], printout.theta_ddot
    found = Geneva(4).transmission(np.fmod(printout.theta, 1.5708) - np.pi / 4)

    def switch(delay_us: int) -> float:
        old = np.roll(acceleration, delay_us)
        force = found.dg * printout.theta_dot**2 + found.g * old
        return time[np.flatnonzero(force[late] < 0)[0]]

    jumps = np.flatnonzero(np.abs(np.diff(acceleration[late])) > 2000.0)
    assert time[jumps[0]] == pytest.approx(switch(50), abs=3e-6)
    assert switch(40) > switch(50) + 2e-5
    # an old, lower acceleration turns the sign before the pin reverses; the jump
    # it causes turns it back 50 us later, and so on until the reversal is there
    assert switch(50) < switch(0) - 2e-4
    assert time[jumps[1]] - time[jumps[0]] == pytest.approx(50e-6, abs=3e-6)


BAD = {"slots": 5, "friction": 0.5, "torque": 0.0, "follower_inertia": float("nan")}
BAD |= {"duration": 1e-4, "interval": 1e-9}


@pytest.mark.parametrize(("name", "value"), BAD.items())
def test_arguments_are_checked(name, value):
    rule = "below the Painleve limit" if name == "friction" else ""
    names = ("slots", "friction", "torque", "driver_inertia", "follower_inertia")
    with pytest.raises(InvalidValue, match=f"{name} must be {rule}"):
        program_1973(**(dict(zip(names, HIGH_RATE, strict=True)) | {name: value}))
