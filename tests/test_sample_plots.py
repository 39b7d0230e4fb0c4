"""Figures of samples show every case where it is, and quantiles where they lie."""

from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from escapement import plots
from escapement.errors import InvalidValue
from escapement.plots.sample import rank_correlation

TIMER = esc.Escapement(esc.Geneva(slots=4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113, 0.3)
DRAWN = {
    "method": "latin-hypercube",
    "size": 200,
    "friction": {"low": 0.2, "high": 0.5},
    "torque": {"relative_tolerance": 0.1},
}


@pytest.fixture(scope="module")
def study():
    return esc.sweep(TIMER, sample=DRAWN)


@pytest.fixture(scope="module")
def grid():
    """A sample at each of ten points, of which the first have no answer."""
    return esc.sweep(TIMER, sample=DRAWN, driver_inertia=np.linspace(1e-8, 9e-7, 5), slots=[4, 6])


def test_points_are_the_cases_and_lines_their_quantiles(study):
    figure = plots.plot_sample(study, ["period"])
    friction, torque, distribution = figure.axes
    period = 1e3 * study.results["period"]
    for ax, name in ((friction, "friction"), (torque, "torque")):
        points, lost = ax.lines[:2]
        np.testing.assert_array_equal(points.get_xdata(), study.sampled[name])
        np.testing.assert_array_equal(points.get_ydata(), period)
        np.testing.assert_array_equal(lost.get_xdata(), study.sampled[name][np.isnan(period)])
        levels = sorted(line.get_ydata()[0] for line in ax.lines[2:])
        np.testing.assert_allclose(levels, np.nanquantile(period, [0.05, 0.5, 0.95]))
    assert sum(bar.get_width() for bar in distribution.patches) == np.isfinite(period).sum()
    assert friction.get_ylabel() == "Period (ms)"
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert texts == ["case", "median", "5 % and 95 %", f"no result ({study.failed} of 200)"]
    assert study.failed > 10


def test_of_many_parameters_those_with_most_effect_are_drawn():
    drawn = {"method": "sobol", "size": 2048, "torque": {"relative_tolerance": 0.1}}
    drawn |= {"friction": {"tolerance": 0.05}}
    drawn |= {"driver_inertia": {"relative_tolerance": 0.3}}
    drawn |= {"follower_inertia": {"relative_tolerance": 1e-9}}
    study = esc.sweep(TIMER, sample=drawn)
    figure = plots.plot_study(study)
    labels = [ax.get_xlabel().replace("\n", " ") for ax in figure.axes[-4:]]
    assert labels[-1] == "Cases"
    assert not any(text.startswith("Follower") for text in labels)
    (legend,) = figure.legends
    assert legend.get_title().get_text() == "3 of 4 parameters, those with most effect on period"
    assert legend.get_texts()[0].get_text() == "case (1500 of 2048)"


def test_rank_correlation_counts_ties_and_gaps_as_they_are():
    rng = np.random.default_rng(1)
    x = rng.random(100)
    assert rank_correlation(x, np.exp(3.0 * x)) == pytest.approx(1.0)
    assert rank_correlation(x, -x) == pytest.approx(-1.0)
    # ranks 1.5 1.5 3.5 3.5 against 1 2 3 4: covariance 1, variances 1 and 5/4
    tied, y = np.array([4.0, 4.0, 5.0, 5.0]), np.array([1.0, 2.0, 3.0, 4.0])
    assert rank_correlation(tied, y) == pytest.approx(2.0 / np.sqrt(5.0), rel=1e-12)
    assert rank_correlation(np.append(tied, 0.0), np.append(y, np.nan)) == rank_correlation(tied, y)
    assert rank_correlation(x, np.full(100, np.nan)) == rank_correlation(x, np.ones(100)) == 0.0


def test_a_band_holds_the_sample_at_each_point_of_a_grid(grid):
    figure = plots.plot_study(grid)
    rise, mean = figure.axes
    assert "Mean driver" in mean.get_ylabel().replace("\n", " ")
    velocity = grid.results["velocity_mean"]
    for column, (line, band) in enumerate(zip(mean.lines, mean.collections, strict=True)):
        here = velocity[:, column]
        some = np.isfinite(here).any(axis=1)
        low, middle, high = np.nanquantile(here[some], [0.05, 0.5, 0.95], axis=1)
        np.testing.assert_allclose(line.get_ydata()[some], middle)
        edges = band.get_paths()[0].vertices[:, 1]
        assert edges.min() == pytest.approx(low.min())
        assert edges.max() == pytest.approx(high.max())
    title = rise.get_legend().get_title().get_text()
    assert title.startswith("Median and 5 % to 95 % of 200 cases\nbut for ")
    assert f"but for {grid.failed} of 2000 in all" in title


def test_one_axis_beside_a_sample_needs_no_legend():
    figure = plots.plot_study(esc.sweep(TIMER, sample=DRAWN | {"size": 20}, slots=[4, 6, 8]))
    assert figure.axes[0].get_title().startswith("Median and 5 % to 95 % of 20 cases")


def test_an_axis_of_one_value_is_none(study):
    alone = esc.sweep(TIMER, sample=DRAWN, load_torque=[0.0])
    ours, theirs = plots.plot_study(alone), plots.plot_study(study)
    for one, other in zip(ours.axes, theirs.axes, strict=True):
        for line, same in zip(one.lines, other.lines, strict=True):
            np.testing.assert_allclose(line.get_ydata(), same.get_ydata(), rtol=1e-12)


def test_a_sample_of_whole_numbers_and_of_a_single_case():
    lists = {"method": "list", "slots": [3, 4, 6, 8], "friction": [0.1, 0.1, 0.2, 0.2]}
    assert len(plots.plot_study(esc.sweep(TIMER, sample=lists)).axes) == 9
    single = esc.sweep(TIMER, sample={"method": "list", "friction": [0.2]})
    with pytest.raises(InvalidValue, match="must vary at least one parameter"):
        plots.plot_study(single)


def test_what_cannot_be_drawn_is_refused(study, grid):
    for draw in (plots.plot_lines, plots.plot_map):
        with pytest.raises(InvalidValue, match="must be a grid to be drawn as lines or a map"):
            draw(study, "period")
    with pytest.raises(InvalidValue, match="must be a sample at one point of its grid"):
        plots.plot_sample(grid)
    nothing = {name: values * np.nan for name, values in study.results.items()}
    with pytest.raises(InvalidValue, match="must hold a number for period or velocity_max"):
        plots.plot_study(replace(study, results=nothing))
