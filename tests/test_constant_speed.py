"""Constant driver speed: extrema, torque and reversals against independent computations."""

import math
import time
from dataclasses import dataclass

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

import escapement as esc
from escapement.constant_speed import contact_moment, geneva, inertia_ratio, jerk_function
from escapement.errors import InvalidValue
from escapement.mechanisms._slotted import radius, transmission, two_vector_path
from escapement.model import Mechanism

WHEELS = [esc.Geneva(n, pins=1, internal=k) for n in (3, 4, 5, 8, 40) for k in (False, True)]
EPS = np.finfo(float).eps


@dataclass(frozen=True)
class Plain:
    """Any path at all: nothing tells the package that it is a Geneva wheel."""

    path: np.ndarray
    half: float

    cell_angle = 2.0 * math.pi
    follower_step = 1.0

    @property
    def breaks(self):
        return -self.half, 0.0, self.half

    def follower_angle(self, theta):
        rates = [quad(lambda x: transmission(self.path, x).g, 0.0, t)[0] for t in np.ravel(theta)]
        return np.reshape(rates, np.shape(theta))


def plain(wheel):
    return Plain(wheel.path, wheel.breaks[-1])


def name_of(wheel):
    return f"{wheel.slots}{'-internal' if wheel.internal else ''}"


@pytest.fixture(params=WHEELS, ids=name_of)
def wheel(request):
    return request.param


# --- transmission, acceleration, jerk -----------------------------------------------------


def test_extrema_are_found_by_search_too(wheel):
    found = esc.transmission_extrema(wheel)
    theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 4001)
    table = wheel.transmission(theta)
    for values, top, bottom in (
        (table.g, found.ratio_max, None),
        (table.dg, found.acceleration_max, found.acceleration_min),
        (jerk_function(wheel, theta), found.jerk_max, found.jerk_min),
    ):
        size = np.abs(values).max()
        assert values.max() <= top.value + 1e-13 * size
        assert top.value == pytest.approx(values.max(), abs=1e-4 * size)
        if bottom is not None:
            assert values.min() >= bottom.value - 1e-13 * size
            assert bottom.value == pytest.approx(values.min(), abs=1e-4 * size)
    for extremum, read in (
        (found.ratio_max, lambda x: wheel.transmission(x).g),
        (found.acceleration_max, lambda x: wheel.transmission(x).dg),
        (found.jerk_min, lambda x: jerk_function(wheel, x)),
    ):
        assert float(read(extremum.angle)) == pytest.approx(extremum.value, rel=1e-13)


def test_a_mechanism_of_unknown_kind_has_the_same_extrema(wheel):
    closed, found = (esc.transmission_extrema(m) for m in (wheel, plain(wheel)))
    assert isinstance(plain(wheel), Mechanism)
    for name in ("ratio_max", "acceleration_max", "acceleration_min", "jerk_max", "jerk_min"):
        assert getattr(found, name).value == pytest.approx(getattr(closed, name).value, rel=1e-9)
    assert abs(found.acceleration_max.angle) == pytest.approx(
        abs(closed.acceleration_max.angle), abs=1e-9
    )
    np.testing.assert_allclose(found.reversal_limits, closed.reversal_limits, rtol=1e-12)


def test_jerk_is_the_slope_of_the_acceleration(wheel):
    theta = np.linspace(0.95 * wheel.breaks[0], 0.95 * wheel.breaks[-1], 24)
    step = 1e-4
    rates = [wheel.transmission(theta + k * step).dg for k in (-2, -1, 1, 2)]
    slope = (rates[0] - 8 * rates[1] + 8 * rates[2] - rates[3]) / (12 * step)
    np.testing.assert_allclose(jerk_function(wheel, theta), slope, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(
        jerk_function(plain(wheel), theta), jerk_function(wheel, theta), rtol=1e-8, atol=1e-8
    )


@pytest.mark.parametrize("slots", [3, 7, 100])
def test_closed_forms_in_fifty_digits(slots):
    with mpmath.workdps(50):
        c = mpmath.sin(mpmath.pi / slots)

        def rate(b):
            return -c * (1 - c**2) * mpmath.sin(b) / (1 + c**2 - 2 * c * mpmath.cos(b)) ** 2

        k = (1 + c**2) / (4 * c)
        beta = mpmath.acos(-k + mpmath.sqrt(k**2 + 2))
        assert float(geneva.acceleration_max_angle(slots)) == pytest.approx(float(beta), rel=1e-14)
        assert float(geneva.acceleration_max(slots)) == pytest.approx(float(rate(-beta)), rel=1e-13)
        assert float(geneva.reversal_limits(slots)[0]) == pytest.approx(
            float(-1 / rate(beta)), rel=1e-13
        )


def test_internal_wheels_know_no_second_zone():
    n = np.arange(3, 200)
    lower, upper = geneva.reversal_limits(n, internal=True)
    np.testing.assert_array_equal(lower, upper)
    zone = esc.reversal_study(n[:, None], np.geomspace(0.01, 100, 50), internal=True).zone
    assert set(np.unique(zone)) == {1, 3}


# --- torque -------------------------------------------------------------------------------


def test_torque_is_power_over_speed_without_friction(wheel):
    """M_2 omega_2 = M_0 omega_0, the follower's speed and acceleration by differences."""
    speed, load, inertia, eta = 12.0, 0.7, 2e-3, 0.8
    result = esc.drive_torque(wheel, speed, load, inertia, efficiency=eta)
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
@pytest.mark.parametrize("ratio", [0.02, 0.5, 1.7, 30.0])
def test_figures_of_one_drive_agree_with_the_study(ratio, internal):
    for slots in (3, 4, 6, 9, 25):
        drive = esc.Geneva(slots, pins=1, internal=internal)
        one = esc.drive_torque(drive, 2.0, 3.0, 3.0 * ratio / 4.0)
        many = esc.reversal_study(slots, ratio, internal)
        assert one.inertia_ratio == pytest.approx(ratio, rel=1e-15)
        assert one.zone == int(many.zone)
        assert one.torque_max == pytest.approx(3.0 * float(many.torque_max), rel=1e-14)
        assert one.torque_max_angle == pytest.approx(float(many.torque_max_angle), abs=1e-11)
        assert one.torque_mean == pytest.approx(3.0 * float(many.torque_mean), rel=1e-13)
        assert one.peak_to_mean == pytest.approx(float(many.peak_to_mean), rel=1e-13)
        assert one.power_max == 2.0 * one.torque_max
        found = many.reversals[~np.isnan(many.reversals)]
        assert one.reversals.size == int(many.reversal_count)
        np.testing.assert_allclose(one.reversals, found, rtol=1e-10)


def test_friction_is_the_work_of_the_pin_in_its_slot():
    """What the drive gives more than without friction is mu N times the way slid."""
    wheel, speed, mu = esc.Geneva(6, pins=1), 9.0, 0.25
    with_mu, without = (esc.drive_torque(wheel, speed, 0.8, 0.02, friction=m) for m in (mu, 0.0))
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
        result = esc.drive_torque(wheel, 10.0, 1.0, inertia, efficiency, friction)
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
    results = [esc.drive_torque(wheel, 10.0, 0.1, 0.01, e, 0.1) for e in (1.0, 0.8)]
    ideal, real = (r.at(np.linspace(*wheel.breaks[::2], 501)).torque for r in results)
    held = (results[0].at(np.linspace(*wheel.breaks[::2], 501)).contact_moment < 0) & (ideal > 0)
    assert held.any()
    np.testing.assert_allclose(real, np.where(ideal > 0, ideal / 0.8, ideal * 0.8), rtol=1e-14)


def test_dwell_needs_no_torque():
    result = esc.drive_torque(esc.Geneva(6, pins=1), 10.0, 1.0, 0.01)
    assert result.at(2.0).torque == 0.0
    assert float(result.at(2.0).phi) == pytest.approx(math.pi / 6)
    with pytest.raises(InvalidValue, match="theta must be between pin entry"):
        result.at(math.pi * 2)


def test_load_that_varies_with_the_follower_angle():
    """A pendulum load: the mean is its work; reversals are roots of load + I omega^2 g'."""
    wheel, speed, inertia = esc.Geneva(8, pins=1), 10.0, 0.025

    def load(phi):
        return 1.0 + 0.6 * np.sin(3.0 * phi)

    result = esc.drive_torque(wheel, speed, load, inertia)
    start = float(wheel.follower_angle(wheel.breaks[0]))
    work = quad(load, start, 0.0)[0]
    kinetic = 0.5 * inertia * speed**2 * float(geneva.ratio_max(8)) ** 2
    assert result.torque_mean * -wheel.breaks[0] == pytest.approx(work + kinetic, rel=1e-13)

    def moment(theta):
        rate = float(wheel.transmission(theta).dg)
        return load(float(wheel.follower_angle(theta))) + inertia * speed**2 * rate

    assert result.zone == 2
    for angle, low, high in zip(result.reversals, (0.0, 0.55), (0.55, 1.17), strict=True):
        assert angle == pytest.approx(brentq(moment, low, high, xtol=1e-15), rel=1e-12)
    constant = esc.drive_torque(wheel, speed, lambda phi: 0.0 * phi + 1.0, inertia)
    number = esc.drive_torque(wheel, speed, 1.0, inertia)
    assert constant.torque_max == number.torque_max
    np.testing.assert_array_equal(constant.reversals, number.reversals)


def test_load_that_jumps():
    result = esc.drive_torque(
        esc.Geneva(5, pins=1), 10.0, lambda phi: np.where(phi < 0.1, 0.2, 1.0), 0.01
    )
    wheel = result.mechanism
    jump = brentq(lambda x: float(wheel.follower_angle(x)) - 0.1, 0.0, 0.5)
    assert result.reversals[1] == pytest.approx(jump, abs=1e-7)
    assert (np.diff(result.reversals) > 0).all()
    assert result.zone == 2


# --- reversals ----------------------------------------------------------------------------


def test_reversals_satisfy_filemons_condition():
    """1 + F i_eps = 0 to 1e-13, over a million wheels and inertia ratios."""
    rng = np.random.default_rng(1960)
    slots, ratio = rng.integers(3, 101, 1_000_000), 10.0 ** rng.uniform(-3, 6, 1_000_000)
    esc.reversal_study(3, 1.0)  # compiled
    start = time.process_time()
    study = esc.reversal_study(slots, ratio)
    assert time.process_time() - start < 5.0
    residual = 1.0 + ratio[:, None] * geneva.acceleration(slots[:, None], study.reversals)
    assert np.nanmax(np.abs(residual)) < 1e-13
    lower, upper = geneva.reversal_limits(slots)
    np.testing.assert_array_equal(study.zone, 1 + (ratio > lower) + (ratio >= upper))
    np.testing.assert_array_equal((~np.isnan(study.reversals)).sum(axis=1), study.reversal_count)
    assert np.nanmin(study.reversals) > 0.0
    assert (study.reversals[:, 1] > study.reversals[:, 0])[study.zone == 2].all()


@given(st.integers(3, 60), st.floats(-4, 4), st.booleans())
@settings(max_examples=60, deadline=None)
def test_reversals_of_a_single_drive(slots, power, internal):
    ratio = 10.0**power
    wheel = esc.Geneva(slots, pins=1, internal=internal)
    result = esc.drive_torque(wheel, 1.0, 1.0, ratio)
    residual = 1.0 + ratio * wheel.transmission(result.reversals).dg
    assert (np.abs(residual) < 1e-13).all()


@pytest.mark.parametrize("slots", [3, 4, 6, 30])
def test_greatest_torque_has_no_slope_and_no_rival(slots):
    wheel = esc.Geneva(slots, pins=1)
    for ratio in (1e-3, 0.1, 1.0, 8.0, 1e3):
        study = esc.reversal_study(slots, ratio)

        def torque(x, f=ratio):
            table = wheel.transmission(x)
            return float(table.g * (1.0 + f * table.dg))

        found = minimize_scalar(
            lambda x: -torque(x), bounds=(wheel.breaks[0], 0.0), options={"xatol": 1e-12}
        )
        assert float(study.torque_max) == pytest.approx(-found.fun, rel=1e-14)
        assert float(study.torque_max_angle) == pytest.approx(found.x, abs=1e-6)
        grid = wheel.transmission(np.linspace(wheel.breaks[0], wheel.breaks[-1], 5001))
        assert (grid.g * (1 + ratio * grid.dg)).max() <= float(study.torque_max) * (1 + 1e-14)


def test_limits_belong_to_the_zone_without_trouble():
    for slots in range(3, 60):
        lower, upper = (float(limit) for limit in geneva.reversal_limits(slots))
        wheel = esc.Geneva(slots, pins=1)
        for ratio, zone in (
            (lower, 1), (lower * (1 + 1e-9), 2), (upper * (1 - 1e-9), 2), (upper, 3),
        ):  # fmt: skip
            assert int(esc.reversal_study(slots, ratio).zone) == zone
            assert esc.drive_torque(wheel, 1.0, 1.0, ratio).zone == zone


def test_without_a_load_the_pin_reverses_at_dead_centre():
    result = esc.drive_torque(esc.Geneva(6), 10.0, 0.0, 0.01)
    assert result.reversals.tolist() == [0.0]
    assert result.zone == 3
    assert result.torque_max == pytest.approx(-result.torque_min, rel=1e-14)
    with pytest.raises(InvalidValue, match=r"load_torque must be greater than 0, got 0\.0"):
        assert result.inertia_ratio


# --- the same in forward dynamics ---------------------------------------------------------

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
        moment = contact_moment(
            mechanism, local[inside], state.theta_dot[inside], rate[inside], load, inertia
        )
        for i in np.flatnonzero(moment[:-1] * moment[1:] < 0.0):
            a, b = local[inside[i]], local[inside[i + 1]]
            predicted.append(a - moment[i] * (b - a) / (moment[i + 1] - moment[i]) + k * cell)
    expected = {"two reversals": 4, "no reversal": 0}.get(case, 2)
    assert len(predicted) == expected
    np.testing.assert_allclose(motion.reversals.theta, predicted, atol=1e-6)
    at = motion.at(motion.reversals.time)
    local = at.theta - motion.reversals.engagement * cell
    table = mechanism.transmission(local)
    terms = inertia * (np.abs(table.g * at.theta_ddot) + np.abs(table.dg) * at.theta_dot**2) + load
    moment = contact_moment(mechanism, local, at.theta_dot, at.theta_ddot, load, inertia)
    assert (np.abs(moment) < 1e-12 * terms).all()


def test_a_heavy_driver_runs_like_one_of_constant_speed():
    """As rho grows the reversal angles tend to drive_torque's, with an error of order 1/rho."""
    wheel, inertia, load, speed = esc.Geneva(6, pins=1), 1e-3, 0.05, 7.9
    steady = esc.drive_torque(wheel, speed, load, inertia).reversals
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


# --- the other way round ------------------------------------------------------------------


@given(st.integers(3, 40), st.floats(0.01, 100), st.floats(0.01, 100), st.booleans())
@settings(max_examples=30, deadline=None)
def test_greatest_and_least_values_are_the_edge_of_reversal(slots, load, inertia, internal):
    wheel = esc.Geneva(slots, pins=1, internal=internal)
    speed = esc.greatest_speed(wheel, load, inertia)
    assert esc.greatest_follower_inertia(wheel, speed, load) == pytest.approx(inertia, rel=1e-14)
    assert esc.least_load_torque(wheel, speed, inertia) == pytest.approx(load, rel=1e-14)
    assert esc.drive_torque(wheel, speed, load, inertia).reversals.size == 0
    assert esc.drive_torque(wheel, speed * (1 + 1e-9), load, inertia).reversals.size > 0


@pytest.mark.parametrize("internal", [False, True])
def test_fewest_slots(internal):
    limits = geneva.reversal_limits(np.arange(3, 400), internal)[0]
    assert (np.diff(limits) > 0).all()
    for k in (0, 1, 5, 100):
        assert esc.fewest_slots(float(limits[k]), internal) == k + 3
        assert esc.fewest_slots(float(limits[k]) * (1 + 1e-12), internal) == k + 4
    assert esc.fewest_slots(0.0, internal) == 3
    with pytest.raises(InvalidValue, match="inertia_ratio must be below the limit of any wheel"):
        esc.fewest_slots(1e20, internal)


def test_design_of_a_mechanism_of_another_kind():
    path = two_vector_path(1.0, 1.0, -0.3, -2.0, forward=1.0)  # a gear-driven pin
    rates = transmission(path, np.linspace(-0.5, 0.5, 2001)).dg
    drive = Plain(path, 0.5)
    assert esc.greatest_speed(drive, 2.0, 0.1) == pytest.approx(
        math.sqrt(2.0 / (0.1 * -rates.min())), rel=1e-6
    )


# --- refusals -----------------------------------------------------------------------------

GOOD = {"mechanism": esc.Geneva(6), "speed": 1.0, "load_torque": 1.0, "follower_inertia": 1.0}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed": 0.0}, r"speed must be greater than 0, got 0\.0; give the driver speed"),
        ({"speed": math.nan}, "speed must be a finite number, got nan"),
        ({"load_torque": -1.0}, r"load_torque must be at least 0, got -1\.0"),
        ({"load_torque": lambda phi: phi * np.nan}, "load_torque must give a finite torque"),
        ({"follower_inertia": 0.0}, "follower_inertia must be greater than 0"),
        ({"efficiency": 0.0}, "efficiency must be greater than 0 and at most 1, got 0"),
        ({"efficiency": 1.01}, "efficiency must be greater than 0 and at most 1, got 1"),
        ({"speed": 1e200}, "speed and follower_inertia must give a torque a double can hold"),
        ({"friction": -0.1}, "friction must be at least 0"),
        ({"mechanism": 6}, "mechanism must be a mechanism, got 6; give for example Geneva"),
    ],
)
def test_drive_torque_refuses(change, message):
    with pytest.raises(InvalidValue, match=message):
        esc.drive_torque(**(GOOD | change))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: esc.reversal_study(4, -0.5), r"inertia_ratio must be finite numbers of at least"),
        (lambda: esc.reversal_study(4, [1.0, math.inf]), "inertia_ratio must be .* got inf"),
        (lambda: esc.reversal_study([3, 2], 1.0), "slots must be whole .* at least 3, got 2;"),
        (lambda: esc.reversal_study(4.5, 1.0), "slots must be whole numbers"),
        (lambda: esc.reversal_study([3, 4], [1.0] * 3), "must have shapes that fit"),
        (lambda: esc.Geneva(2), "slots must be a whole number of at least 3, got 2"),
        (lambda: esc.fewest_slots(-1.0), r"inertia_ratio must be at least 0, got -1\.0"),
        (lambda: inertia_ratio(1.0, 1.0, 0.0), "without a load there is no inertia ratio F"),
        (lambda: inertia_ratio(1.0, 1.0, 1e-310), "load_torque must be great enough"),
        (lambda: inertia_ratio(1.0, 1.0, np.sin), "load_torque must be constant"),
        (lambda: esc.greatest_speed(4, 1.0, 1.0), "mechanism must be a mechanism"),
        (lambda: esc.greatest_speed(esc.Geneva(4), -1.0, 1.0), "load_torque must be at least 0"),
        (lambda: esc.least_load_torque(esc.Geneva(4), 0.0, 1.0), "speed must be greater than 0"),
    ],
)
def test_others_refuse(call, message):
    with pytest.raises(InvalidValue, match=message):
        call()


def test_a_mechanism_that_counts_from_its_entry():
    """Half the engagement is the middle; a load that helps leaves no mean to compare with."""

    @dataclass(frozen=True)
    class Shifted(Plain):
        @property
        def breaks(self):
            return 0.1, self.half

    drive = Shifted(esc.Geneva(6).path, 0.9)
    result = esc.drive_torque(drive, 1.0, 1.0, 0.1)
    mean = quad(lambda x: float(result.at(x).torque), 0.1, 0.5)[0] / 0.4
    assert result.torque_mean == pytest.approx(mean, rel=1e-12)
    helped = esc.drive_torque(esc.Geneva(6), 1.0, lambda phi: phi - 10.0, 0.1)
    assert helped.torque_mean < 0.0
    assert math.isnan(helped.peak_to_mean)


def test_empty_study():
    study = esc.reversal_study(np.array([], dtype=int), np.array([]))
    assert study.zone.shape == (0,)
    assert study.reversals.shape == (0, 2)
