"""Where the pin changes sides: at constant speed, in forward dynamics, and by design."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import escapement as esc
from any_path import Plain
from escapement.base.errors import InvalidValue
from escapement.constant_speed import geneva
from escapement.mechanisms.slotted import transmission, two_vector_path


def test_reversals_satisfy_filemons_condition():
    """1 + F i_eps = 0 to 1e-13, over 100 000 wheels and inertia ratios."""
    rng = np.random.default_rng(1960)
    slots, ratio = rng.integers(3, 101, 100_000), 10.0 ** rng.uniform(-3, 6, 100_000)
    study = esc.reversal_study(slots, ratio)
    residual = 1.0 + ratio[:, None] * geneva.acceleration(slots[:, None], study.reversals)
    assert np.nanmax(np.abs(residual)) < 1e-13
    lower, upper = geneva.reversal_limits(slots)
    np.testing.assert_array_equal(study.zone, 1 + (ratio > lower) + (ratio >= upper))
    np.testing.assert_array_equal((~np.isnan(study.reversals)).sum(axis=1), study.reversal_count)
    assert np.nanmin(study.reversals) > 0.0
    assert (study.reversals[:, 1] > study.reversals[:, 0])[study.zone == 2].all()


def test_internal_wheels_know_no_second_zone():
    n = np.arange(3, 200)
    np.testing.assert_array_equal(*geneva.reversal_limits(n, internal=True))
    zone = esc.reversal_study(n[:, None], np.geomspace(0.01, 100, 50), internal=True).zone
    assert set(np.unique(zone)) == {1, 3}


def test_limits_belong_to_the_zone_without_trouble():
    for slots in (3, 4, 6, 10, 25, 59):
        lower, upper = (float(limit) for limit in geneva.reversal_limits(slots))
        wheel = esc.Geneva(slots, pins=1)
        for ratio, zone in (
            (lower, 1), (lower * (1 + 1e-9), 2), (upper * (1 - 1e-9), 2), (upper, 3),
        ):  # fmt: skip
            assert int(esc.reversal_study(slots, ratio).zone) == zone
            assert esc.index(wheel, 1.0, 1.0, follower_inertia=ratio).zone == zone


def test_without_a_load_the_pin_reverses_at_dead_centre():
    result = esc.index(esc.Geneva(6), 10.0, 0.0, follower_inertia=0.01)
    assert result.reversals.tolist() == [0.0]
    assert result.zone == 3
    assert result.torque_max == pytest.approx(-result.torque_min, rel=1e-14)
    assert math.isnan(result.inertia_ratio)


RUNS = {
    "external": (esc.Geneva(6, pins=1), 0.05, 3.0, 0.01, 6.0, 0.1),
    "two reversals": (esc.Geneva(8, pins=1), 0.02, 400.0, 0.03, 8.0, 0.1),
    "internal": (esc.Geneva(5, internal=True), 0.02, 1.0, 0.02, 15.0, 0.1),
    "no load": (esc.Geneva(4), 0.02, 1.0, 0.0, 5.0, 0.1),
    "no reversal": (esc.Geneva(10, pins=1), 0.02, 50.0, 0.4, 8.0, 0.1),
}


@pytest.mark.parametrize("engine", ["energy", "ivp"])
@pytest.mark.parametrize("case", RUNS)
def test_contact_changes_side_where_the_run_s_own_motion_asks_for_it(case, engine):
    """Speed from the run, acceleration by differences of it, contact by inverse dynamics."""
    mechanism, torque, rho, load, speed, friction = RUNS[case]
    inertia = 1e-3
    timer = esc.Escapement(
        mechanism, esc.Inertia(rho * inertia, inertia), torque, friction, load_torque=load
    )
    motion = esc.simulate(timer, 2, initial_speed=speed, engine=engine)
    entry, exit_, cell = mechanism.breaks[0], mechanism.breaks[-1], mechanism.cell_angle
    predicted = []
    ends = np.concatenate([[0.0], motion.handoff_times])
    for k in range(2):
        t = np.linspace(ends[k], ends[k + 1], 30001)[1:-1]
        state = motion.at(t)
        local = state.theta - k * cell
        rate = np.gradient(state.theta_dot, t, edge_order=2)
        inside = np.flatnonzero((local > entry) & (local < exit_))[3:-3]
        found = mechanism.transmission(local[inside])
        bent = found.g * rate[inside] + found.dg * state.theta_dot[inside] ** 2
        moment = load + inertia * bent
        for i in np.flatnonzero(moment[:-1] * moment[1:] < 0.0):
            a, b = local[inside[i]], local[inside[i + 1]]
            predicted.append(a - moment[i] * (b - a) / (moment[i + 1] - moment[i]) + k * cell)
    expected = {"two reversals": 4, "no reversal": 0}.get(case, 2)
    assert len(predicted) == expected
    np.testing.assert_allclose(motion.reversals.theta, predicted, atol=1e-6)


def test_a_heavy_driver_runs_like_one_of_constant_speed():
    """As rho grows the reversals tend to those at constant speed, with an error of order 1/rho."""
    wheel, inertia, load, speed = esc.Geneva(6, pins=1), 1e-3, 0.05, 7.9
    steady = esc.index(wheel, speed, load, follower_inertia=inertia).reversals
    errors = []
    for rho in (1e3, 1e4, 1e5):
        timer = esc.Escapement(
            wheel, esc.Inertia(rho * inertia, inertia), 1e-3, 0.1, load_torque=load
        )
        found = esc.simulate(timer, 1, initial_speed=speed).reversals.theta
        errors.append(np.abs(found - steady).max())
    order = np.polyfit(np.log([1e3, 1e4, 1e5]), np.log(errors), 1)[0]
    assert order == pytest.approx(-1.0, abs=0.02)
    assert errors[-1] < 2e-5


@given(st.integers(3, 40), st.floats(0.01, 100), st.floats(0.01, 100), st.booleans())
@settings(max_examples=30, deadline=None)
def test_greatest_and_least_values_are_the_edge_of_reversal(slots, load, inertia, internal):
    wheel = esc.Geneva(slots, pins=1, internal=internal)
    speed = esc.index(wheel, 1.0, load, follower_inertia=inertia).greatest_speed
    drive = esc.index(wheel, speed, load, follower_inertia=inertia)
    assert drive.greatest_follower_inertia == pytest.approx(inertia, rel=1e-13)
    assert drive.least_load_torque == pytest.approx(load, rel=1e-13)
    slower, faster = (
        esc.index(wheel, speed * (1.0 + off), load, follower_inertia=inertia)
        for off in (-1e-9, 1e-9)
    )
    assert slower.reversals.size == 0 < faster.reversals.size


@pytest.mark.parametrize("internal", [False, True])
def test_fewest_slots(internal):
    limits = geneva.reversal_limits(np.arange(3, 400), internal)[0]
    assert (np.diff(limits) > 0).all()
    for k in (0, 1, 5, 100):
        assert esc.fewest_slots(float(limits[k]), internal) == k + 3
        assert esc.fewest_slots(float(limits[k]) * (1 + 1e-12), internal) == k + 4
    assert esc.fewest_slots(0.0, internal) == 3
    most = float(geneva.reversal_limits(1_000_000, internal)[0])
    assert esc.Geneva(esc.fewest_slots(most, internal), internal=internal).slots == 1_000_000
    for ratio in (most * (1 + 1e-9), 1e8, 1e20):
        with pytest.raises(InvalidValue, match=r"inertia_ratio must be below .* 1,000,000 slots"):
            esc.fewest_slots(ratio, internal)


def test_design_of_a_mechanism_of_another_kind():
    path = two_vector_path(1.0, 1.0, -0.3, -2.0, forward=1.0)  # a gear-driven pin
    rates = transmission(path, np.linspace(-0.5, 0.5, 2001)).dg
    drive = Plain(path, 0.5)
    found = esc.index(drive, 1.0, 2.0, follower_inertia=0.1).greatest_speed
    assert found == pytest.approx(math.sqrt(2.0 / (0.1 * -rates.min())), rel=1e-6)
