"""Figures of a measurement: what is drawn is what was found."""

import numpy as np
import pytest

import escapement as esc
from escapement import measurement, plots
from measurement_tools import DEG, PRIKHODKO, read


@pytest.fixture(scope="module")
def result():
    encoder = esc.Encoder(4096, 0.003)
    planted = {"noise": 0.5 * DEG, "output_eccentricity": 0.5 * DEG, "sense": -1}
    readings = read(seed=7, samples=300, turns=4.5, encoder=encoder, **planted)
    return esc.measure(readings, PRIKHODKO, encoder=encoder)


PANELS = ("positions", "errors", "error_histogram", "frequencies", "periodogram")


@pytest.mark.parametrize("plot", [getattr(plots, f"plot_{name}") for name in PANELS])
def test_panels_are_labelled_and_say_what_is_synthetic(result, plot):
    measured = esc.measure(esc.Readings(result.readings.input, result.readings.output), PRIKHODKO)
    for given, said in ((result, "synthetic data"), (measured, "")):
        ax = plot(given)
        assert all([ax.get_xlabel(), ax.get_ylabel()])
        assert ax.get_legend().get_title().get_text() == said


def test_positions_lie_on_the_curve_but_for_their_errors(result):
    curve, dots = plots.plot_positions(result).lines
    x, y = dots.get_data()
    theory = np.degrees(measurement.position(PRIKHODKO, np.radians(x)))
    np.testing.assert_allclose(y - theory, -np.degrees(result.errors), atol=1e-9)
    x, y = curve.get_data()
    np.testing.assert_allclose(y, np.degrees(measurement.position(PRIKHODKO, np.radians(x))))


def test_errors_and_their_interval(result):
    _, dots, low, high = plots.plot_errors(result).lines
    np.testing.assert_allclose(dots.get_ydata(), np.degrees(result.errors))
    assert dots.get_xdata()[0] == 0.0
    assert np.radians([low.get_ydata()[0], high.get_ydata()[0]]) == pytest.approx(result.interval)


def test_histogram_and_bell_hold_all_errors(result):
    ax = plots.plot_error_histogram(result)
    (steps,) = ax.patches
    values, edges, _ = steps.get_data()
    assert (values * np.diff(edges)).sum() == pytest.approx(1.0)
    x, y = ax.lines[0].get_data()
    assert np.trapezoid(y, x) == pytest.approx(1.0, abs=1e-3)


def test_frequencies_are_those_of_the_classes(result):
    bars = [bar.get_height() for bar in plots.plot_frequencies(result).patches]
    classes = result.histogram
    np.testing.assert_allclose(bars, [*classes.observed, *classes.expected])


def test_periodogram_and_its_level(result):
    ax = plots.plot_periodogram(result)
    x, y = ax.lines[0].get_data()
    np.testing.assert_allclose(y, 100.0 * result.periodogram.power)
    assert ax.lines[1].get_ydata()[0] == pytest.approx(100.0 * result.periodogram.level(0.01))
    marks = {line.get_label(): line.get_xdata()[0] for line in ax.lines[2:]}
    assert marks == pytest.approx({"input turn": 1.0, "output turn": 7 / 9, "cell": 16 / 9})
    assert x[np.nanargmax(y)] == pytest.approx(7 / 9, abs=0.1)


def test_sheet(result, tmp_path):
    figure = plots.plot_measurement(result)
    assert len({ax.get_ylabel() for ax in figure.axes}) == 4  # no two panels show the same
    assert figure.get_suptitle() == "Synthetic data"
    plots.save(figure, tmp_path / "sheet.svg")


def test_many_samples_are_thinned():
    many = esc.measure(read(samples=50_000, turns=900, noise=0.01), PRIKHODKO)
    assert plots.plot_errors(many).lines[1].get_xdata().size < 5000
