"""Errors that repeat every turn: found on their shaft, and nowhere else."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

import escapement as esc
from escapement import measurement
from measurement_tools import DEG, PRIKHODKO, read, shown


@pytest.mark.parametrize("shaft", ["input", "output"])
@pytest.mark.parametrize("drive", [PRIKHODKO, esc.Geneva(3), esc.Geneva(4)])
def test_planted_eccentricity_is_found_on_its_shaft(drive, shaft):
    planted = {f"{shaft}_eccentricity": 0.4 * DEG}
    result = esc.measure(read(drive, noise=0.4 * DEG, **planted), drive)
    found = shown(result, shaft)
    assert found.p_value < 1e-6
    assert abs(found.amplitude - 0.4 * DEG) < 4 * found.standard_error
    assert f"repeats once a turn of the {shaft}" in result.verdict.text
    other = shown(result, "output" if shaft == "input" else "input")
    assert other.amplitude < 4 * other.standard_error


@pytest.mark.slow
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
    found = measurement.periodic.periodogram(angle, errors)
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
    for seed in range(12):
        readings = read(seed=seed, samples=samples, turns=turns, noise=0.1 * DEG)
        found = esc.measure(readings, PRIKHODKO).periodogram
        highest = found.power[found.peak]
        assert 0.0 < highest < 0.99
        assert highest == np.nanmax(found.power)
        alarms.append(found.false_alarm_probability(highest) < 0.05)
    assert np.mean(alarms) < 0.05 + 3 * math.sqrt(0.05 * 0.95 / 12)


def test_correlated_errors_are_remarked_upon():
    calm = esc.measure(read(noise=0.4 * DEG), PRIKHODKO)
    assert calm.message == "these are synthetic data, computed and not measured"
    result = esc.measure(read(noise=0.1 * DEG, output_eccentricity=DEG), PRIKHODKO)
    assert result.autocorrelation > 0.9
    assert abs(result.rest_autocorrelation) < 0.2  # the eccentricity is found
    assert "neighbouring errors are alike" in result.message
    assert "the tests of normality, the errors of phase and offset and" in result.message
    assert "repeats once a turn of the output" in result.verdict.text


@pytest.mark.parametrize(("correlation", "most"), [(0.0, 0.02), (0.3, 0.03), (0.6, 0.1)])
def test_noise_whose_neighbours_are_alike_is_not_stated_as_a_shaft_s_error(correlation, most):
    stated, judged = [], []
    theta = np.linspace(0.0, 6.0 * math.pi, 148, endpoint=False)
    for seed in range(40):
        white = np.random.default_rng(seed).standard_normal(348)
        noise = lfilter([math.sqrt(1.0 - correlation**2)], [1.0, -correlation], white)[200:]
        output = measurement.position(PRIKHODKO, theta) + 0.9 * DEG * noise
        result = esc.measure(esc.Readings(theta, output), PRIKHODKO)
        stated.append(result.verdict.good is False and "repeats" in result.verdict.text)
        judged.append("all tests, false alarms, standard errors" in result.message)
    assert np.mean(stated) <= most
    assert np.mean(judged) == pytest.approx({0.0: 0.0, 0.3: 0.5, 0.6: 1.0}[correlation], abs=0.2)


def test_an_amplitude_that_phase_and_offset_hide_is_not_stated():
    """Of six slots they take all but 0.4 % of a cosine once a cell, and nothing of a sine."""
    drive, within, hidden = esc.Geneva(6), [], []
    for seed in range(40):
        random = np.random.default_rng(seed)
        theta = np.linspace(0.0, 6.0 * math.pi, 500, endpoint=False)
        errors = 0.02 * np.sin(3.0 * theta) + 0.05 * random.standard_normal(500)
        output = measurement.position(drive, theta) + errors * DEG
        result = esc.measure(esc.Readings(theta, output), drive)
        found = shown(result, "cell")
        hidden.append("an error repeats once a cell, but phase, offset" in result.verdict.text)
        assert hidden[-1] or found.amplitude < 0.03 * DEG
        within.append(abs(found.amplitude - 0.02 * DEG) < 3.0 * found.standard_error)
    assert np.mean(within) > 0.95
    assert np.mean(hidden) > 0.8


def test_an_even_turn_is_measured_all_round():
    readings = read(samples=360, turns=1.0, noise=0.1 * DEG)
    theta = np.radians(np.arange(360.0))
    result = esc.measure(esc.Readings(theta, readings.output), PRIKHODKO)
    assert "input" not in result.message.partition("not judged")[0]
    assert shown(result, "input").p_value > 0.0
    short = esc.measure(esc.Readings(theta[:-1], readings.output[:-1]), PRIKHODKO)
    assert math.isnan(shown(short, "input").p_value)


def test_many_turns_are_cut_for_the_periodogram_alone():
    result = esc.measure(read(samples=24_000, turns=1500.0, noise=0.1 * DEG), PRIKHODKO)
    assert "the periodogram covers the first 1000 turns" in result.message
    assert result.periodogram.samples == pytest.approx(16_000, abs=2)
    assert shown(result, "input").turns == pytest.approx(1500.0, abs=0.1)
