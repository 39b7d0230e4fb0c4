"""Measured positions against theory: what was planted is found, and nothing else."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

import escapement as esc
from escapement import measurement
from escapement.errors import InvalidValue
from escapement.measurement.encoder import sensor_share, sensor_uncertainty
from escapement.measurement.readings import unwrapped

DEG = math.pi / 180.0
PRIKHODKO = esc.EllipticalPlanetary(0.016, 0.009)
DRIVES = [
    PRIKHODKO,
    esc.Geneva(3),
    esc.Geneva(4),
    esc.Geneva(4, pins=1),
    esc.Geneva(5),
    esc.Geneva(6, internal=True),
    esc.GearDriven(4, 2, curve="epicycloid"),
    esc.Tabulated(
        np.linspace(0.0, 2.0, 41),
        np.linspace(0.0, 1.0, 41) + 0.1 * np.sin(np.pi * np.arange(41) / 20),
    ),
]
NAMES = ["planetary", "3", "4", "4 with dwell", "5", "internal", "gear-driven", "table"]


def read(mechanism=PRIKHODKO, **planted):
    """Readings that hold nothing but what is planted."""
    return esc.synthetic_readings(mechanism, **({"seed": 1, "samples": 600, "turns": 5} | planted))


# --- position function --------------------------------------------------------------------


def test_prikhodko_s_position_over_many_cells():
    sun, planet = 16.0, 9.0
    a, c = 0.5 * (sun + planet), 0.5 * (sun - planet)
    theta = np.linspace(-20.0, 30.0, 4001)
    p, e = sun * theta / planet, c / a
    phi = theta - p - 2.0 * np.arctan2(e * np.sin(p), 1.0 - e * np.cos(p))
    np.testing.assert_allclose(measurement.position(PRIKHODKO, theta), -phi, atol=2e-14 * 100)


@pytest.mark.parametrize("drive", DRIVES, ids=NAMES)
def test_each_cell_adds_a_step_and_the_follower_never_jumps(drive):
    theta = np.linspace(-9.0, 9.0, 5000)
    phi = measurement.position(drive, theta)
    turned = measurement.position(drive, theta + drive.cell_angle)
    np.testing.assert_allclose(turned - phi, drive.follower_step, atol=1e-13)
    g = measurement.slope(drive, theta)
    assert np.diff(phi).max() <= 1.01 * np.diff(theta)[0] * g.max()
    assert np.diff(phi).min() > -1e-12


@pytest.mark.parametrize("drive", DRIVES, ids=NAMES)
def test_slope_is_the_transmission_and_zero_in_the_dwell(drive):
    entry, exit_ = drive.breaks[0], drive.breaks[-1]
    theta = np.linspace(entry + 1e-4, exit_ - 1e-4, 501)
    for cell in (0, 7):
        g = measurement.slope(drive, theta + cell * drive.cell_angle)
        np.testing.assert_allclose(g, drive.transmission(theta).g, atol=5e-8)
    if exit_ < entry + drive.cell_angle - 0.1:
        assert (measurement.slope(drive, np.linspace(exit_ + 0.01, exit_ + 0.09, 9)) == 0.0).all()


# --- fit ----------------------------------------------------------------------------------


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("drive", DRIVES, ids=NAMES)
def test_zeros_come_back_exactly_without_errors_but_one_count(drive, sense):
    fine = esc.Encoder(1 << 24)
    result = esc.measure(
        read(drive, phase=17 * DEG, offset=-33 * DEG, sense=sense, encoder=fine), drive
    )
    assert result.fit.sense == sense
    assert result.fit.phase == pytest.approx(17 * DEG, abs=fine.quantum)
    assert result.fit.offset == pytest.approx(-33 * DEG, abs=fine.quantum * 5)
    assert np.abs(result.errors).max() < 10 * fine.quantum
    assert result.mean == pytest.approx(0.0, abs=1e-12)


def test_standard_errors_of_the_zeros_are_what_repetition_shows():
    truth = np.array([9.0, 40.0]) * DEG
    fits = [
        esc.measure(
            read(seed=seed, samples=120, noise=0.5 * DEG, phase=truth[0], offset=truth[1]),
            PRIKHODKO,
        ).fit
        for seed in range(200)
    ]
    for name, value in zip(("phase", "offset"), truth, strict=True):
        found = np.array([getattr(fit, name) for fit in fits])
        told = np.mean([getattr(fit, f"{name}_error") for fit in fits])
        assert abs(found.mean() - value) < 4 * told / math.sqrt(len(fits))
        # the standard error of a standard deviation of 200 is 5 %
        assert found.std() == pytest.approx(told, rel=0.2)


def test_known_zeros_are_kept_and_the_mean_error_remains():
    readings = read(noise=0.2 * DEG, offset=0.3 * DEG)
    result = esc.measure(readings, PRIKHODKO, zeros=(0.0, 0.0))
    assert (result.fit.phase, result.fit.offset, result.fit.phase_error) == (0.0, 0.0, 0.0)
    assert result.mean == pytest.approx(0.3 * DEG, abs=4 * 0.2 * DEG / math.sqrt(600))


def test_wrapped_or_counting_on_is_the_same():
    plain = read(noise=0.3 * DEG)
    turned = esc.Readings(np.mod(plain.input, 2 * np.pi), np.mod(plain.output, 2 * np.pi))
    a, b = (esc.measure(readings, PRIKHODKO) for readings in (plain, turned))
    np.testing.assert_allclose(a.errors, b.errors, atol=1e-11)
    assert a.fit.phase == pytest.approx(b.fit.phase, abs=1e-11)


def test_samples_in_step_with_the_cells_tell_the_phase():
    drive = esc.Geneva(4, pins=1)
    # two hundred a turn: every two hundredth meets the same place of the cell
    readings = read(drive, samples=200_000, turns=1000.0, noise=0.1 * DEG, phase=0.3)
    result = esc.measure(readings, drive)
    assert result.fit.phase == pytest.approx(0.3, abs=4 * result.fit.phase_error)
    assert result.standard_deviation == pytest.approx(0.1 * DEG, rel=0.01)


def test_turning_back_and_forth_is_no_obstacle():
    theta = 4.0 * np.sin(np.linspace(0.0, 20.0, 900))
    readings = esc.Readings(np.mod(theta, 2 * np.pi), measurement.position(PRIKHODKO, theta + 0.2))
    result = esc.measure(
        esc.Readings(readings.input, readings.output + 1e-6 * np.sin(np.arange(900.0) ** 2)),
        PRIKHODKO,
    )
    assert result.fit.phase == pytest.approx(0.2, abs=1e-6)


def test_missing_samples_do_not_lose_a_turn():
    theta = np.linspace(0.0, 40.0, 900)  # 2.5 degrees a sample
    noise = 1e-4 * np.random.default_rng(0).standard_normal(900)
    angle = np.mod(theta, 2 * np.pi)
    output = np.mod(measurement.position(PRIKHODKO, theta) + noise, 2 * np.pi)
    angle[200:420] = np.nan  # one turn and a half
    output[600:610] = np.nan
    result = esc.measure(esc.Readings(angle, output), PRIKHODKO)
    assert result.readings.missing == 230
    np.testing.assert_allclose(result.input, theta[result.readings.complete], atol=1e-12)
    assert result.standard_deviation < 1.1e-4


def test_unwrapping_adds_whole_turns_only():
    angle = np.mod(np.cumsum(np.random.default_rng(3).uniform(-2.0, 3.0, 500)), 2 * np.pi)
    steps = np.diff(unwrapped(angle, np.arange(500)))
    assert np.abs(steps).max() <= np.pi + 1e-12
    np.testing.assert_allclose(np.exp(1j * steps), np.exp(1j * np.diff(angle)), atol=1e-12)


@pytest.mark.parametrize("samples", [300, 5000])
def test_even_output_tells_no_phase(samples):
    drive = esc.Geneva(4, pins=1)  # in its dwell throughout
    theta = np.linspace(1.0, 5.0, samples)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(samples)
    result = esc.measure(esc.Readings(theta, 0.5 + noise), drive)
    if result.fit.phase_error == result.fit.phase_error:
        # another phase may fit noise a little better, but then its error is large
        assert result.standard_deviation < 1.1e-3
    else:
        assert "the phase cannot be told" in result.message


@settings(deadline=None, max_examples=60)
@given(
    drive=st.sampled_from(DRIVES),
    seed=st.integers(0, 2**32 - 1),
    samples=st.integers(20, 80),
    spread=st.sampled_from([1e-9, 1e-3, 1.0, 30.0, 1e6]),
    counts=st.booleans(),
)
def test_whatever_is_measured_the_figures_are_finite(drive, seed, samples, spread, counts):
    random = np.random.default_rng(seed)
    columns = spread * random.standard_normal((2, samples)).round(2)
    if counts:
        columns = np.cumsum(np.abs(columns), axis=1)
    try:
        result = esc.measure(esc.Readings(*columns), drive)
    except InvalidValue:
        return
    assert np.isfinite(result.errors).all()
    assert math.isfinite(result.fit.phase + result.fit.offset)
    tests = (result.chi_squared_test, result.published_test, result.anderson_darling_test)
    assert all(0.0 <= test.p_value <= 1.0 for test in tests)
    assert all(not error.p_value < 0.0 for error in result.shaft_errors)
    assert np.isfinite(result.periodogram.power).all()
    assert 0.0 < result.periodogram.level(0.01) <= 1.0
    assert "\n" not in result.message


# --- statistics ---------------------------------------------------------------------------


def test_the_paper_s_numbers():
    expected = np.full(9, 148 / 9)
    observed = expected + np.sqrt(7.595 / 9 * expected)
    classes = measurement.Histogram(np.arange(10.0), observed, expected, None, None)
    test = measurement.published_chi_squared(classes)
    assert test.statistic == pytest.approx(7.595)
    assert 100.0 * test.p_value == pytest.approx(26.93, abs=0.005)
    half_width = 2.57 * 1.298
    assert half_width == pytest.approx(3.336, abs=5e-4)  # printed 3.33: cut off
    assert measurement.sturges(148) == pytest.approx(8.2, abs=0.05)
    assert measurement.class_count(np.random.default_rng(0).standard_normal(148)) == 9


def test_published_test_is_that_of_the_paper():
    """Eqs. 11 to 16 once more, from a table of frequencies, by hand."""
    errors = np.random.default_rng(8).normal(0.1, 1.3, 148)
    result = measurement.published_chi_squared(measurement.histogram(errors, 9))
    observed, edges = np.histogram(errors, 9)
    p = observed / 148
    x = (edges[1:] + edges[:-1]) / 2
    mean = sum(x * p)
    deviation = math.sqrt(sum((x - mean) ** 2 * p))
    expected = 148 * np.diff(stats.norm.cdf(edges, mean, deviation))
    statistic = sum((observed - expected) ** 2 / expected)
    assert result.statistic == pytest.approx(statistic, rel=1e-12)
    assert result.degrees_of_freedom == 9 - 1 - 2
    assert result.p_value == pytest.approx(stats.chi2.sf(statistic, 6), rel=1e-12)


def test_anderson_darling_is_that_of_scipy():
    errors = np.random.default_rng(2).normal(3.0, 0.2, 90) ** 3
    found = measurement.anderson_darling(errors)
    fitted = stats.norm(*(errors.mean(), errors.std(ddof=1)))
    u = np.sort(fitted.cdf(errors))
    i = np.arange(1, 91)
    by_hand = -90 - np.sum((2 * i - 1) / 90 * (np.log(u) + np.log(1 - u[::-1])))
    assert found.statistic == pytest.approx(by_hand, rel=1e-10)
    # 5 % point of the modified statistic, Stephens' table
    critical = 0.752 / (1 + 0.75 / 90 + 2.25 / 8100)
    z = np.random.default_rng(0).standard_normal((1, 90))
    assert measurement.anderson_darling(z).p_value.shape == (1,)
    near = measurement.normality._anderson_darling_p(critical, 90)
    assert near == pytest.approx(0.05, abs=5e-4)


REPETITIONS = 20_000


@pytest.fixture(scope="module")
def normal_errors():
    """Sets of 148 normal errors, less what a fit of phase and offset takes up."""
    draws = np.random.default_rng(2020).standard_normal((REPETITIONS, 148))
    theta = np.linspace(0.0, 3 * 2 * np.pi, 148, endpoint=False)
    columns = np.column_stack([np.ones(148), measurement.slope(PRIKHODKO, theta)])
    basis, _ = np.linalg.qr(columns)
    return draws - (draws @ basis) @ basis.T


@pytest.mark.parametrize("level", [0.05, 0.01])
@pytest.mark.parametrize("bins", [7, 9, 14])
def test_chi_squared_test_keeps_its_level(normal_errors, bins, level):
    rate = (measurement.chi_squared(normal_errors, bins).p_value < level).mean()
    assert rate == pytest.approx(level, abs=3 * math.sqrt(level * (1 - level) / REPETITIONS))


@pytest.mark.parametrize("level", [0.05, 0.01])
def test_anderson_darling_test_keeps_its_level(normal_errors, level):
    rate = (measurement.anderson_darling(normal_errors).p_value < level).mean()
    assert rate == pytest.approx(level, abs=3 * math.sqrt(level * (1 - level) / REPETITIONS))


def test_committed_rates_hold_what_the_page_says():
    root = Path(__file__).parents[1]
    table = (root / "benchmarks/results/normality_level.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(table.splitlines()))
    page = (root / "docs/measurement.md").read_text(encoding="utf-8")
    names = {
        "chi-squared as published": "as published",
        "equal probabilities, fitted to counts": "fitted to counts",
        "chi-squared": "**chi-squared**",
        "Anderson-Darling": "**Anderson-Darling**",
    }
    for test, name in names.items():
        normal = [row for row in rows if row["test"] == test and row["law"] == "normal"]
        rates = [f"{100 * float(row['rate']):.1f}" for row in normal if row["level"] == "0.05"]
        assert f"| {name} |" in page
        assert f"| {' | '.join(rates)} |" in page
        if name.startswith("**"):
            for row in normal:
                level = float(row["level"])
                near = 3 * math.sqrt(level * (1 - level) / REPETITIONS)
                assert float(row["rate"]) == pytest.approx(level, abs=near)


def test_published_test_rejects_normal_errors_twice_too_often(normal_errors):
    classes = measurement.histogram(normal_errors, 9)
    assert 0.10 < (measurement.published_chi_squared(classes).p_value < 0.05).mean() < 0.13


def test_an_outlier_where_none_is_expected():
    errors = np.random.default_rng(0).standard_normal(5000)
    for far in (60.0, -60.0):
        errors[7] = far
        result = measurement.published_chi_squared(measurement.histogram(errors, 40))
        assert result.statistic > 1e6
        assert result.p_value == 0.0


def test_classes_of_both_tails_expect_alike():
    errors = np.array([-9.0, 9.0, *np.random.default_rng(0).standard_normal(400)])
    errors = np.concatenate([errors, -errors])
    expected = measurement.histogram(errors, 20).expected
    np.testing.assert_allclose(expected, expected[::-1], rtol=1e-9)
    assert expected[0] > 0.0


def test_tests_tell_other_laws_from_the_normal():
    random = np.random.default_rng(4)
    for draws in (random.laplace(size=(400, 300)), random.uniform(size=(400, 300))):
        assert (measurement.chi_squared(draws, 10).p_value < 0.05).mean() > 0.95
        assert (measurement.anderson_darling(draws).p_value < 0.05).mean() > 0.95


def test_intervals_hold_what_they_promise():
    random = np.random.default_rng(6)
    held, covered = [], []
    for seed in range(300):
        readings = read(seed=seed, samples=100, noise=0.5 * DEG)
        result = esc.measure(readings, PRIKHODKO, zeros=(0.0, 0.0), confidence=0.9)
        low, high = result.interval
        new = 0.5 * DEG * random.standard_normal(100)
        held.append(((new > low) & (new < high)).mean())
        low, high = result.mean_interval
        covered.append(low < 0.0 < high)
    assert np.mean(held) == pytest.approx(0.9, abs=0.015)
    assert np.mean(covered) == pytest.approx(0.9, abs=3 * math.sqrt(0.09 / 300))


def test_interval_is_the_paper_s():
    result = esc.measure(read(noise=DEG), PRIKHODKO, zeros=(0.0, 0.0))
    half = stats.norm.ppf(0.995) * result.standard_deviation
    assert result.interval == pytest.approx((result.mean - half, result.mean + half))


@pytest.mark.parametrize(
    ("rule", "count"),
    [("sturges", 11), ("square-root", 32), ("scott", None), ("freedman-diaconis", None), (17, 17)],
)
def test_numbers_of_classes(rule, count):
    errors = np.random.default_rng(0).standard_normal(1000)
    found = measurement.class_count(errors, rule)
    if count is None:
        named = {"scott": "scott", "freedman-diaconis": "fd"}[rule]
        count = len(np.histogram_bin_edges(errors, named)) - 1
    assert abs(found - count) <= (0 if rule in ("sturges", "square-root", 17) else 1)
    result = measurement.histogram(errors, found)
    assert result.observed.sum() == 1000
    assert result.edges[[0, -1]] == pytest.approx([errors.min(), errors.max()])


# --- errors that come back ----------------------------------------------------------------


def shown(result, shaft, order=1):
    (found,) = [e for e in result.shaft_errors if (e.shaft, e.order) == (shaft, order)]
    return found


@pytest.mark.parametrize("shaft", ["input", "output"])
@pytest.mark.parametrize("drive", [PRIKHODKO, esc.Geneva(3), esc.Geneva(4)])
def test_planted_eccentricity_is_found_on_its_shaft(drive, shaft):
    planted = {f"{shaft}_eccentricity": 0.4 * DEG}
    result = esc.measure(read(drive, noise=0.4 * DEG, **planted), drive)
    found = shown(result, shaft)
    assert found.p_value < 1e-6
    assert abs(found.amplitude - 0.4 * DEG) < 4 * found.standard_error
    assert f"comes back once a turn of the {shaft}" in result.message
    other = shown(result, "output" if shaft == "input" else "input")
    assert other.amplitude < 4 * other.standard_error


def test_eccentricity_of_the_output_is_the_peak_of_the_periodogram():
    result = esc.measure(read(noise=0.4 * DEG, output_eccentricity=0.4 * DEG), PRIKHODKO)
    found = result.periodogram
    power = found.power[found.peak]
    turns = PRIKHODKO.follower_step / PRIKHODKO.cell_angle
    assert found.frequency[found.peak] == pytest.approx(turns, abs=0.1)  # 5 turns: 0.2 apart
    assert found.false_alarm_probability(power) < 1e-10
    assert power > found.level(0.01)


def test_without_eccentricity_nothing_is_found_more_often_than_by_chance():
    sets = 200
    least, peaks = [], []
    for seed in range(sets):
        result = esc.measure(read(seed=seed, samples=150, noise=0.3 * DEG), PRIKHODKO)
        least.append([error.p_value for error in result.shaft_errors])
        found = result.periodogram
        peaks.append(found.false_alarm_probability(found.power[found.peak]) < 0.05)
    rate = (np.array(least) < 0.05).mean()
    assert rate == pytest.approx(0.05, abs=3 * math.sqrt(0.05 * 0.95 / (6 * sets)))
    # an upper bound: no more alarms than promised, and not far fewer
    assert 0.01 < np.mean(peaks) < 0.05 + 3 * math.sqrt(0.05 * 0.95 / sets)


def test_periodogram_is_a_least_squares_fit_of_a_sinusoid():
    random = np.random.default_rng(11)
    angle = np.sort(random.uniform(0.0, 40.0, 200))
    errors = random.standard_normal(200) + np.cos(3.0 * angle)
    found = measurement.spectrum.periodogram(angle, errors)
    for i in (3, found.peak, len(found.frequency) // 2, -1):
        phase = angle * found.frequency[i]
        table = np.column_stack([np.ones(200), np.cos(phase), np.sin(phase)])
        solution, rest, *_ = np.linalg.lstsq(table, errors, rcond=None)
        explained = 1.0 - rest[0] / (errors.var() * 200)
        assert found.power[i] == pytest.approx(explained, rel=5e-3, abs=1e-4)
        amplitude = np.hypot(*solution[1:])
        assert found.amplitude[i] == pytest.approx(amplitude, rel=5e-3, abs=1e-3)


@pytest.mark.parametrize(("samples", "turns"), [(60, 10.0), (40, 20.0), (24, 0.5), (20, 30.0)])
def test_periodogram_of_few_samples_a_turn(samples, turns):
    alarms = []
    for seed in range(40):
        readings = read(seed=seed, samples=samples, turns=turns, noise=0.1 * DEG)
        found = esc.measure(readings, PRIKHODKO).periodogram
        assert np.isfinite(found.power).all()
        assert found.power.max() < 0.99
        alarms.append(found.false_alarm_probability(found.power.max()) < 0.05)
    assert np.mean(alarms) < 0.05 + 3 * math.sqrt(0.05 * 0.95 / 40)


def test_a_shaft_that_did_not_turn_round_is_not_judged():
    drive = esc.Geneva(8)
    result = esc.measure(read(drive, turns=3.0, noise=0.1 * DEG), drive)
    found = shown(result, "output")
    assert found.turns == pytest.approx(3 / 8, abs=0.2)
    assert math.isnan(found.p_value)


def test_correlated_errors_are_remarked_upon():
    calm = esc.measure(read(noise=0.4 * DEG), PRIKHODKO)
    assert calm.message == "synthetic data, computed and not measured"
    result = esc.measure(read(noise=0.1 * DEG, output_eccentricity=DEG), PRIKHODKO)
    assert result.autocorrelation > 0.9
    assert "neighbouring errors are alike" in result.message


def test_many_turns_are_cut_for_the_periodogram_alone():
    result = esc.measure(read(samples=60_000, turns=1500.0, noise=0.1 * DEG), PRIKHODKO)
    assert "the periodogram covers the first 1000 turns" in result.message
    assert result.periodogram.samples == pytest.approx(40_000, abs=2)
    assert shown(result, "input").turns == pytest.approx(1500.0, abs=0.1)


def test_a_wrong_mechanism_is_remarked_upon():
    result = esc.measure(read(noise=0.1 * DEG), esc.Geneva(5))
    assert "large against a step of" in result.message


# --- encoders -----------------------------------------------------------------------------


def test_resolution_gives_the_spread_of_rounding():
    encoder = esc.Encoder(251)  # prime: the stops do not fall on whole counts
    result = esc.measure(read(samples=5000, turns=50.123, encoder=encoder), PRIKHODKO)
    share = sensor_share(encoder, result.fit.slope)
    assert result.standard_deviation == pytest.approx(share.standard, rel=0.03)
    assert np.abs(result.errors).max() < 1.02 * share.bound


def test_linearity_stays_within_its_bound():
    encoder = esc.Encoder(1 << 20, 0.003)
    readings = read(samples=2000, turns=9.0, encoder=encoder)
    result = esc.measure(readings, PRIKHODKO, encoder=encoder, zeros=(0.0, 0.0))
    share = result.sensor_share
    assert np.abs(result.errors).max() < 1.01 * share.bound
    assert 0.3 * share.standard < result.standard_deviation < 2.0 * share.standard


def test_shares_of_the_paper_s_encoders():
    theta = np.linspace(0.0, PRIKHODKO.cell_angle, 10_000, endpoint=False)
    g = measurement.slope(PRIKHODKO, theta)
    encoder = esc.Encoder(4096, 0.003)
    share = sensor_share(encoder, g)
    assert math.degrees(encoder.quantum) == pytest.approx(0.088, abs=5e-4)
    assert math.degrees(share.output_resolution) == pytest.approx(360 / 4096 / math.sqrt(12))
    assert math.degrees(share.output_linearity) == pytest.approx(1.08 / math.sqrt(3))
    # greatest transmission 256/81 - 1 of the paper's eq. 9 at p = 0
    assert np.abs(g).max() == pytest.approx(256 / 81 - 1, rel=1e-6)
    limit = 1.08 + 180 / 4096
    assert math.degrees(share.bound) == pytest.approx(limit * 256 / 81, rel=1e-6)
    assert share.standard == pytest.approx(math.hypot(*share[:4]))
    local = sensor_uncertainty(encoder, g)
    assert math.sqrt(np.mean(local**2)) == pytest.approx(share.standard)


# --- synthetic readings -------------------------------------------------------------------


def test_the_same_seed_gives_the_same_readings():
    planted = {"noise": 0.01, "encoder": esc.Encoder(4096, 0.003), "missing": 0.1}
    a, b, c = (read(seed=seed, **planted) for seed in (5, 5, 6))
    assert a.synthetic
    np.testing.assert_array_equal(a.output, b.output)
    assert not np.array_equal(a.output, c.output)
    assert 20 < a.missing < 110


def test_backlash_shows_where_the_input_turns_back():
    drive = esc.Geneva(3)
    forward = read(drive, turns=2.0, backlash=2 * DEG)
    lag = measurement.position(drive, forward.input) - forward.output
    assert lag[0] == 0.0
    assert lag[50:] == pytest.approx(1 * DEG)
    back = read(drive, turns=-2.0, backlash=2 * DEG)
    lag = measurement.position(drive, back.input) - back.output
    assert lag[50:] == pytest.approx(-1 * DEG)


def test_encoders_give_whole_counts_within_a_turn():
    readings = read(encoder=esc.Encoder(100), noise=0.1)
    for angle in (readings.input, readings.output):
        counts = angle / (2 * np.pi) * 100
        np.testing.assert_allclose(counts, np.round(counts), atol=1e-10)
        assert angle.min() >= 0.0
        assert angle.max() < 2 * np.pi


# --- what is refused ----------------------------------------------------------------------

ROW = np.linspace(0.0, 9.0, 60)
WRONG = {
    "few samples": (lambda: esc.Readings(ROW[:19], ROW[:19]), "at least 20", "got 19 of 19"),
    "few complete": (lambda: esc.Readings(ROW * np.nan, ROW), "at least 20", "got 0 of 60"),
    "lengths": (lambda: esc.Readings(ROW, ROW[1:]), "one length", "60, 59"),
    "lines": (lambda: esc.Readings(ROW, ROW, line=[1]), "one length", "60, 60 and 1"),
    "infinite": (lambda: esc.Readings(np.where(ROW > 5.0, np.inf, ROW), ROW), "finite"),
    "words": (lambda: esc.Readings(["a"] * 60, ROW), "input must be a row of real numbers"),
    "a table": (lambda: esc.Readings(ROW.reshape(6, 10), ROW), "row of real numbers"),
    "standstill": (lambda: esc.Readings(ROW * 0.0, ROW), "input must turn"),
    "no mechanism": (lambda: esc.measure(read(), "geneva"), "mechanism", "'geneva'"),
    "no readings": (lambda: esc.measure([1.0, 2.0], PRIKHODKO), "Readings or a path", "[1.0, 2.0]"),
    "no encoder": (lambda: esc.measure(read(), PRIKHODKO, encoder=4096), "encoder", "4096"),
    "confidence": (lambda: esc.measure(read(), PRIKHODKO, confidence=99), "between 0 and 1"),
    "zeros": (lambda: esc.measure(read(), PRIKHODKO, zeros=1.0), "phase and an offset"),
    "a zero": (lambda: esc.measure(read(), PRIKHODKO, zeros=(0.0, "x")), "offset", "'x'"),
    "rule": (lambda: esc.measure(read(noise=0.1), PRIKHODKO, bins="sturgis"), "'sturges'?"),
    "three bins": (lambda: esc.measure(read(noise=0.1), PRIKHODKO, bins=3), "at least 4", "got 3"),
    "many bins": (lambda: esc.measure(read(noise=0.1), PRIKHODKO, bins=1001), "at most 1000"),
    "theory": (lambda: esc.measure(read(), PRIKHODKO), "differ from theory"),
    "one count": (lambda: esc.Encoder(1), "resolution", "at least 2"),
    "per cent": (lambda: esc.Encoder(4096, 0.5), "linearity", "below 0.5", "0.003"),
    "seed": (lambda: read(seed=-1), "seed", "at least 0"),
    "noise": (lambda: read(noise=-1.0), "noise", "at least 0"),
    "sense": (lambda: read(sense=0), "sense", "1 or -1"),
    "missing": (lambda: read(missing=1.0), "missing", "below 1"),
    "level": (lambda: esc.measure(read(noise=0.1), PRIKHODKO).periodogram.level(2), "probability"),
}


@pytest.mark.parametrize(("call", "said"), [(c, s) for c, *s in WRONG.values()], ids=WRONG)
def test_what_is_refused(call, said):
    with pytest.raises(InvalidValue) as caught:
        call()
    for text in said:
        assert text in str(caught.value)
    assert "\n" not in str(caught.value)
