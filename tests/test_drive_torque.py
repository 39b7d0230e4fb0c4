"""Torque of a drive at constant speed against independent computations."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import quad

import escapement as esc
from any_path import Plain, each_wheel
from escapement.base.errors import InvalidValue
from escapement.mechanisms.slotted import radius
from tabulated_drive import DRIVE, measured


def driven(mechanism, speed, load, inertia, efficiency=1.0, friction=0.0):
    numbers = {"follower_inertia": inertia, "efficiency": efficiency, "friction": friction}
    return esc.index(mechanism, speed, load, **numbers)


@each_wheel
def test_torque_is_power_over_speed_without_friction(wheel):
    """M_2 omega_2 = M_0 omega_0, the follower's speed and acceleration by differences."""
    speed, load, inertia, eta = 12.0, 0.7, 2e-3, 0.8
    result = driven(wheel, speed, load, inertia, efficiency=eta)
    theta = np.linspace(0.98 * wheel.breaks[0], 0.98 * wheel.breaks[-1], 41)
    step = 1e-4
    phi = [wheel.follower_angle(theta + k * step) for k in (-1, 0, 1)]
    follower_speed = speed * (phi[2] - phi[0]) / (2 * step)
    moment = load + inertia * speed**2 * (phi[2] - 2 * phi[1] + phi[0]) / step**2
    power = follower_speed * moment
    state = result.at(theta)
    scale = np.abs(state.contact_moment).max()
    np.testing.assert_allclose(state.contact_moment, moment, atol=3e-5 * scale)
    arrives = np.where(power > 0.0, power / eta, power * eta)
    np.testing.assert_allclose(state.torque * speed, arrives, atol=1e-4 * speed * scale)


@pytest.mark.parametrize("internal", [False, True])
@pytest.mark.parametrize("ratio", [1e-4, 0.02, 0.5, 1.7, 30.0, 1e4])
def test_figures_of_one_drive_agree_with_the_study(ratio, internal):
    for slots in (3, 4, 6, 9, 25):
        drive = esc.Geneva(slots, pins=1, internal=internal)
        one = driven(drive, 2.0, 3.0, 3.0 * ratio / 4.0)
        many = esc.reversal_study(slots, ratio, internal)
        assert one.inertia_ratio == pytest.approx(ratio, rel=1e-15)
        assert one.zone == int(many.zone)
        assert one.torque_max == pytest.approx(3.0 * float(many.torque_max), rel=1e-14)
        # slopes are differences over 1e-5 rad, whose rounding is 1e-11 of the torque
        assert one.torque_max_angle == pytest.approx(float(many.torque_max_angle), abs=1e-8)
        assert one.torque_mean == pytest.approx(3.0 * float(many.torque_mean), rel=1e-13)
        assert one.torque_max_over_mean == pytest.approx(float(many.peak_to_mean), rel=1e-13)
        assert one.power_max == 2.0 * one.torque_max
        found = many.reversals[~np.isnan(many.reversals)]
        assert one.reversals.size == int(many.reversal_count)
        np.testing.assert_allclose(one.reversals, found, rtol=1e-10)
        assert (np.abs(1.0 + ratio * drive.transmission(one.reversals).dg) < 1e-13).all()


def test_friction_is_the_work_of_the_pin_in_its_slot():
    """What the drive gives more than without friction is mu N times the way slid."""
    wheel, speed, mu = esc.Geneva(6, pins=1), 9.0, 0.25
    with_mu, without = (driven(wheel, speed, 0.8, 0.02, friction=m) for m in (mu, 0.0))
    theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 101)
    state, free = with_mu.at(theta), without.at(theta)
    np.testing.assert_array_equal(state.contact_moment, free.contact_moment)
    arm = radius(wheel.path, theta)
    slid = np.abs(wheel.transmission(theta).u) * arm  # |dR/d theta|, in crank radii
    lost = mu * np.abs(state.contact_moment) / arm * slid
    np.testing.assert_allclose(state.torque - free.torque, lost, atol=1e-13)
    np.testing.assert_array_equal(with_mu.reversals, without.reversals)


@pytest.mark.parametrize(("friction", "efficiency"), [(0.0, 0.7), (0.3, 1.0), (0.3, 0.7)])
def test_extremes_and_mean_are_those_of_the_torque(friction, efficiency):
    for slots, inertia in ((3, 0.01), (5, 0.09), (8, 0.019), (8, 0.2)):
        wheel = esc.Geneva(slots, pins=1)
        result = driven(wheel, 10.0, 1.0, inertia, efficiency, friction)
        theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 20001)
        torque = result.at(theta).torque
        assert torque.max() <= result.torque_max * (1.0 + 1e-14)
        assert torque.max() == pytest.approx(result.torque_max, rel=1e-6)
        assert torque.min() == pytest.approx(result.torque_min, rel=1e-5, abs=1e-9)
        mean = quad(lambda x, r=result: float(r.at(x).torque), theta[0], 0.0, epsabs=1e-13)[0]
        assert result.torque_mean == pytest.approx(mean / -theta[0], rel=1e-12)


def test_power_that_flows_back_is_multiplied_by_the_efficiency():
    """Also with friction, which can take more than the follower gives."""
    wheel = esc.Geneva(4, pins=1)
    results = [driven(wheel, 10.0, 0.1, 0.01, e, 0.1) for e in (1.0, 0.8)]
    ideal, real = (r.at(np.linspace(*wheel.breaks[::2], 501)).torque for r in results)
    held = (results[0].at(np.linspace(*wheel.breaks[::2], 501)).contact_moment < 0) & (ideal > 0)
    assert held.any()
    np.testing.assert_allclose(real, np.where(ideal > 0, ideal / 0.8, ideal * 0.8), rtol=1e-14)


def test_dwell_needs_no_torque():
    result = driven(esc.Geneva(6, pins=1), 10.0, 1.0, 0.01)
    assert result.at(2.0).torque == 0.0
    assert float(result.at(2.0).phi) == pytest.approx(math.pi / 6)
    with pytest.raises(InvalidValue, match="theta must be between pin entry"):
        result.at(math.pi * 2)


@pytest.mark.parametrize("internal", [False, True])
def test_an_exit_angle_that_rounding_puts_into_the_dwell_is_the_exit(internal):
    for slots in (3, 7, 100):
        wheel = esc.Geneva(slots, pins=1, internal=internal)
        result = driven(wheel, 10.0, 1.0, 0.05)
        last = wheel.breaks[-1]
        half_step = -180.0 / slots if internal else 180.0 / slots
        exits = [last, np.nextafter(last, 9.0), np.radians(90.0 - half_step)]
        moment = result.at(exits).contact_moment
        assert moment[0] != 0.0
        np.testing.assert_allclose(moment, moment[0], rtol=1e-9)
        assert result.at(last + 1e-9).contact_moment == 0.0


def test_a_mechanism_that_counts_from_its_entry():
    """Half the engagement is the middle."""

    @dataclass(frozen=True)
    class Shifted(Plain):
        @property
        def breaks(self):
            return 0.1, self.half

    drive = Shifted(esc.Geneva(6).path, 0.9)
    result = driven(drive, 1.0, 1.0, 0.1)
    mean = quad(lambda x: float(result.at(x).torque), 0.1, 0.5)[0] / 0.4
    assert result.torque_mean == pytest.approx(mean, rel=1e-12)


@pytest.mark.parametrize("start_deg", [-101.25, -200.0, -1.0, 0.0, 30.0])
def test_the_mean_does_not_depend_on_where_a_table_counts_from(start_deg):
    drive = esc.EllipticalPlanetary(0.016, 0.009)
    theta = np.linspace(*drive.breaks, 301)
    table = esc.Tabulated(theta - theta[0] + math.radians(start_deg), drive.follower_angle(theta))
    exact, found = (driven(m, 10.0, 0.1, 1e-4) for m in (drive, table))
    assert found.torque_mean == pytest.approx(exact.torque_mean, rel=1e-6)
    assert found.torque_max_over_mean == pytest.approx(exact.torque_max_over_mean, rel=1e-4)


def test_a_measured_table_tells_how_well_its_moment_is_known():
    angles = np.linspace(-1.5, 1.5, 101)  # every table has its own cell about zero
    true = driven(DRIVE, 10.0, 0.01, 2e-4)
    assert true.moment_deviation == 0.0
    shares = []
    for seed in range(5):
        table = measured(300, np.radians(1.0), seed, cells=0.5)
        found = driven(table, 10.0, 0.01, 2e-4)
        off = found.at(angles).contact_moment - true.at(angles).contact_moment
        shares.append(np.abs(off).max() / found.moment_deviation)
    assert 0.5 < np.median(shares) < 2.0
    assert max(shares) < 4.0


@pytest.mark.parametrize("rows", [30, 100])
@pytest.mark.parametrize("load", [0.0, 1.0])
def test_an_even_ratio_never_reverses(rows, load):
    """Its g' is a rounding error, whose sign means nothing."""
    theta = np.linspace(-3.0, 3.0, rows)
    even = esc.Tabulated(theta, 2.0 * theta)
    result = driven(even, 1e3, load, 1.0)
    assert (result.zone, result.reversals.size) == (1, 0)
    assert result.reversal_limits == (math.inf, math.inf)
    assert (result.greatest_speed, result.greatest_follower_inertia) == (math.inf, math.inf)
    assert result.least_load_torque == 0.0


@pytest.mark.parametrize(("load", "inertia"), [(0.7, 2e-3), (0.1, 2e-2)])
def test_the_contact_force_is_the_moment_over_the_distance_of_the_pin(load, inertia):
    for wheel in (
        esc.Geneva(6, crank_radius=0.02),
        esc.Geneva(5, internal=True, crank_radius=0.03),
    ):
        result = driven(wheel, 12.0, load, inertia)
        theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 20001)
        force = np.abs(result.at(theta).contact_moment) / (wheel.crank_radius * wheel.radius(theta))
        assert result.contact_force_max == pytest.approx(force.max(), rel=1e-6)
        assert result.contact_force_max >= force.max() * (1.0 - 1e-12)
    # a load alone presses most at dead centre, where the pin is closest to the wheel's axis
    alone = driven(esc.Geneva(6, crank_radius=0.02), 1e-6, 0.7, 1e-9)
    found = alone.contact_force_max, alone.contact_force_max_angle
    assert found == pytest.approx((0.7 / 0.02, 0.0), abs=1e-6)
    assert math.isnan(driven(esc.Geneva(6), 1.0, 0.7, 1e-9).contact_force_max)
