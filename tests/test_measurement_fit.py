"""Measured positions against theory: the fit finds the known zeros of the encoders."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import escapement as esc
from escapement import measurement
from escapement.base.errors import InvalidValue
from measurement_tools import DEG, DRIVES, PRIKHODKO, read


def noise_of(size, seed=0):
    return np.random.default_rng(seed).standard_normal(size)


@pytest.mark.parametrize("drive", DRIVES.values(), ids=DRIVES)
def test_each_cell_adds_a_step_and_the_follower_never_jumps(drive):
    theta = np.linspace(-9.0, 9.0, 5000)
    phi = measurement.position(drive, theta)
    turned = measurement.position(drive, theta + drive.cell_angle)
    np.testing.assert_allclose(turned - phi, drive.follower_step, atol=1e-13)
    g = measurement.slope(drive, theta)
    assert np.diff(phi).max() <= 1.01 * np.diff(theta)[0] * g.max()
    assert np.diff(phi).min() > -1e-12
    # the slope is the transmission, and zero in the dwell
    entry, exit_ = drive.breaks[0], drive.breaks[-1]
    theta = np.linspace(entry + 1e-4, exit_ - 1e-4, 501)
    g = measurement.slope(drive, theta + 7 * drive.cell_angle)
    np.testing.assert_allclose(g, drive.transmission(theta).g, atol=5e-8)
    if exit_ < entry + drive.cell_angle - 0.1:
        assert (measurement.slope(drive, np.linspace(exit_ + 0.01, exit_ + 0.09, 9)) == 0.0).all()


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("drive", DRIVES.values(), ids=DRIVES)
def test_zeros_come_back_exactly_without_errors_but_one_count(drive, sense):
    fine = esc.Encoder(1 << 24)
    readings = read(drive, phase=17 * DEG, offset=-33 * DEG, sense=sense, encoder=fine)
    result = esc.measure(readings, drive)
    assert result.fit.sense == sense
    assert result.fit.phase == pytest.approx(17 * DEG, abs=fine.quantum)
    assert result.fit.offset == pytest.approx(-33 * DEG, abs=fine.quantum * 5)
    assert np.abs(result.errors).max() < 10 * fine.quantum
    assert result.mean == pytest.approx(0.0, abs=1e-12)


@pytest.mark.slow
def test_standard_errors_of_the_zeros_are_what_repetition_shows():
    truth = np.array([9.0, 40.0]) * DEG
    planted = {"samples": 120, "noise": 0.5 * DEG, "phase": truth[0], "offset": truth[1]}
    fits = [esc.measure(read(seed=seed, **planted), PRIKHODKO).fit for seed in range(200)]
    for name, value in zip(("phase", "offset"), truth, strict=True):
        found = np.array([getattr(fit, name) for fit in fits])
        told = np.mean([getattr(fit, f"{name}_error") for fit in fits])
        assert abs(found.mean() - value) < 4 * told / math.sqrt(len(fits))
        # the standard error of a standard deviation of 200 is 5 %
        assert found.std() == pytest.approx(told, rel=0.2)


@pytest.mark.parametrize("drive", [esc.Geneva(7, pins=1), PRIKHODKO], ids=["seven", "planetary"])
@pytest.mark.parametrize("start", [-0.2, 10.0, 185.0, 230.0, 359.0])
def test_with_known_zeros_the_first_turn_of_the_input_is_the_right_one(drive, start):
    angle = np.radians(np.linspace(start, start + 155.0, 200))
    noise = 0.05 * DEG * noise_of(angle.size)
    readings = esc.Readings(np.mod(angle, 2 * np.pi), measurement.position(drive, angle) + noise)
    result = esc.measure(readings, drive, zeros=(0.0, 0.0))
    assert result.fit.sense == 1
    assert result.standard_deviation == pytest.approx(0.05 * DEG, rel=0.2)
    np.testing.assert_allclose(result.errors, noise, atol=1e-9)


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


def test_missing_samples_do_not_lose_a_turn():
    theta = np.linspace(0.0, 40.0, 900)  # 2.5 degrees a sample
    noise = 1e-4 * noise_of(900)
    angle = np.mod(theta, 2 * np.pi)
    output = np.mod(measurement.position(PRIKHODKO, theta) + noise, 2 * np.pi)
    angle[200:420] = np.nan  # one turn and a half
    output[600:610] = np.nan
    result = esc.measure(esc.Readings(angle, output), PRIKHODKO)
    assert result.readings.missing == 230
    np.testing.assert_allclose(result.input, theta[result.readings.complete], atol=1e-12)
    assert result.standard_deviation < 1.1e-4


@pytest.mark.parametrize("junk", [0.0, np.inf, 1e20])
@pytest.mark.parametrize("column", ["input", "output"])
def test_a_masked_reading_is_missing_whatever_lies_below_the_mask(column, junk):
    theta = np.linspace(0.0, 40.0, 900)
    noise = 1e-4 * noise_of(900)
    columns = {"input": theta, "output": measurement.position(PRIKHODKO, theta) + noise}
    lost = np.arange(900) % 37 == 5
    gaps, hidden = dict(columns), dict(columns)
    gaps[column] = np.where(lost, np.nan, columns[column])
    hidden[column] = np.ma.array(np.where(lost, junk, columns[column]), mask=lost)
    one, other = (esc.measure(esc.Readings(**given), PRIKHODKO) for given in (gaps, hidden))
    assert other.readings.missing == lost.sum()
    np.testing.assert_array_equal(other.errors, one.errors)


SWING = 4 * np.pi * np.sin(2 * np.pi * np.arange(300) / 200)
FASTER = np.radians(np.cumsum(np.linspace(8.0, 60.0, 300)))


@pytest.mark.parametrize("theta", [SWING, FASTER], ids=["swinging", "ever faster"])
@pytest.mark.parametrize("first", range(30, 280, 25))
def test_the_input_is_known_where_the_output_alone_is_missing(theta, first):
    noise = 0.5 * DEG * noise_of(300, first)
    output = np.mod(measurement.position(PRIKHODKO, theta) + noise, 2 * np.pi)
    output[first : first + 11] = np.nan
    result = esc.measure(esc.Readings(np.mod(theta, 2 * np.pi), output), PRIKHODKO)
    travel = theta[result.readings.complete]
    np.testing.assert_allclose(np.diff(result.input), np.diff(travel), atol=1e-11)
    assert result.standard_deviation < 0.6 * DEG
    assert "miscounted" not in result.message


def test_a_gap_of_the_input_is_still_remarked_upon():
    theta = np.arange(300) * 30.0 * DEG
    angle, output = np.mod(theta, 2 * np.pi), measurement.position(PRIKHODKO, theta)
    angle[100:110] = np.nan
    noise = 0.1 * DEG * noise_of(300)
    result = esc.measure(esc.Readings(angle, output + noise), PRIKHODKO)
    assert "the input moves by 330 degrees up to line 111" in result.message


@pytest.mark.parametrize("column", ["input", "output"])
def test_angles_a_double_cannot_tell_are_refused(column):
    theta = np.linspace(0.0, 40.0, 60)
    columns = {"input": theta, "output": theta.copy()}
    columns[column][7] = 1e300
    rule = rf"{column} must be within 1e10 turns of zero.*got 1e\+300 rad in sample 8"
    with pytest.raises(InvalidValue, match=rule):
        esc.Readings(**columns)
    columns[column][7] = 6e10
    assert np.isfinite(esc.measure(esc.Readings(**columns), PRIKHODKO).standard_deviation)


@pytest.mark.parametrize("samples", [300, 5000])
def test_even_output_tells_no_phase(samples):
    drive = esc.Geneva(4, pins=1)  # in its dwell throughout
    theta = np.linspace(1.0, 5.0, samples)
    noise = 1e-3 * noise_of(samples)
    result = esc.measure(esc.Readings(theta, 0.5 + noise), drive)
    if result.fit.phase_error == result.fit.phase_error:
        # another phase may fit noise a little better, but then its error is large
        assert result.standard_deviation < 1.1e-3
    else:
        assert "do not show the phase" in result.message


@settings(deadline=None, max_examples=60)
@given(
    drive=st.sampled_from([*DRIVES.values()]),
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
    tests = (result.published_test, result.anderson_darling_test)
    assert all(0.0 <= test.p_value <= 1.0 for test in tests)
    assert all(not error.p_value < 0.0 for error in result.shaft_errors)
    assert np.isfinite(result.periodogram.power[result.periodogram.peak])
    assert 0.0 < result.periodogram.level(0.01) <= 1.0
    assert "\n" not in result.message


def test_a_mechanism_without_dynamics_is_measured():
    """Its pin passes through the wheel's centre: the wheel turns evenly, and has no path."""
    wheel = esc.GearDriven(12, 4, "hypocycloid")
    assert wheel.through_centre
    theta = np.linspace(0.0, 12.0, 400)
    output = measurement.position(wheel, theta) + 1e-3 * noise_of(400, 3)
    found = esc.measure(esc.Readings(theta, output), wheel)
    assert found.standard_deviation == pytest.approx(1e-3, rel=0.15)
