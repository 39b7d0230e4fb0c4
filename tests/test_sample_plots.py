"""Figures of samples show every case where it is, and quantiles where they lie."""

from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from escapement import plots
from escapement.base.errors import InvalidValue
from escapement.plots.sample import quantile, rank_correlation

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
        np.testing.assert_allclose(levels(ax), np.nanquantile(period, [0.05, 0.5, 0.95]))
    assert sum(bar.get_width() for bar in distribution.patches) == np.isfinite(period).sum()
    assert friction.get_ylabel() == "Period (ms)"
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert texts == ["case", "median", "5 % and 95 %", f"no result ({study.failed} of 200)"]
    assert study.failed > 10


def without_long_times(study, share):
    """The same study, its longest times beyond what an engine follows."""
    times = study.results["rise_time"]
    short = {"rise_time": np.where(times > np.nanquantile(times, share), np.nan, times)}
    return replace(study, results=study.results | short)


def levels(ax):
    """Heights of lines across a panel."""
    return sorted(line.get_ydata()[0] for line in ax.lines if line.get_linestyle() in ("-", "--"))


@pytest.mark.parametrize(("share", "drawn"), [(0.97, 3), (0.7, 2), (0.3, 1), (0.04, 0)])
def test_a_time_that_is_not_given_is_longer_than_any(study, share, drawn):
    cut = without_long_times(study, share)
    times, ran = cut.results["rise_time"], np.isfinite(cut.results["period"])
    lost = ran & np.isnan(times)
    figure = plots.plot_sample(cut, ["rise_time", "period"])
    rise, _, distribution, period, *_ = figure.axes
    # those of the whole sample, as far as they lie among what is given
    whole = 1e3 * np.nanquantile(study.results["rise_time"], [0.05, 0.5, 0.95])[:drawn]
    np.testing.assert_allclose(levels(rise), whole, rtol=1e-12)
    assert len(levels(period)) == 3
    crosses, triangles = rise.lines[1:3]
    np.testing.assert_array_equal(crosses.get_xdata(), cut.sampled["friction"][~ran])
    np.testing.assert_array_equal(triangles.get_xdata(), cut.sampled["friction"][lost])
    assert period.lines[2].get_xdata().size == 0
    said = f"no rise time in {lost.sum()} of {ran.sum()} cases: counted as longest"
    assert distribution.get_title(loc="right") == said
    assert figure.axes[5].get_title(loc="right") == ""
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts[-2:] == [f"no result ({cut.failed} of 200)", "no time"]
    figure.draw_without_rendering()
    place = figure.legends[0].get_window_extent()
    assert figure.bbox.x0 <= place.x0 <= place.x1 <= figure.bbox.x1


def test_a_quantile_on_the_last_number_before_infinity_is_that_number():
    values = np.array([3.0, np.inf, 1.0, np.nan, 2.0, np.inf])
    # of five that count: every quarter falls on one
    found = [float(quantile(values, share)) for share in (0.0, 0.25, 0.375, 0.5, 0.51, 0.75)]
    np.testing.assert_array_equal(found, [1.0, 2.0, 2.5, 3.0, np.nan, np.nan])
    assert np.isnan(quantile(np.full(4, np.nan), 0.5))
    rng = np.random.default_rng(3)
    many = rng.standard_normal((4, 3, 101))
    for share in (0.05, 0.5, 0.95):
        np.testing.assert_allclose(quantile(many, share), np.quantile(many, share, axis=-1))


def test_of_many_parameters_those_with_most_effect_are_drawn():
    spread = {"torque": 0.1, "friction": 0.2, "driver_inertia": 0.3, "follower_inertia": 1e-9}
    drawn = {name: {"relative_tolerance": width} for name, width in spread.items()}
    study = esc.sweep(TIMER, sample={"method": "sobol", "size": 2048} | drawn)
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
    assert [rank_correlation(x, y) for y in (np.exp(3.0 * x), -x)] == pytest.approx([1.0, -1.0])
    # ranks 1.5 1.5 3.5 3.5 against 1 2 3 4: covariance 1, variances 1 and 5/4
    tied, y = np.array([4.0, 4.0, 5.0, 5.0]), np.array([1.0, 2.0, 3.0, 4.0])
    assert rank_correlation(tied, y) == pytest.approx(2.0 / np.sqrt(5.0), rel=1e-12)
    assert rank_correlation(np.append(tied, 0.0), np.append(y, np.nan)) == rank_correlation(tied, y)
    # infinity is a rank above all others: 1 2 3.5 3.5 against 1 2 3 4
    longest = np.array([1.0, 2.0, np.inf, np.inf])
    assert rank_correlation(longest, y) == pytest.approx(4.5 / np.sqrt(5.0 * 4.5), rel=1e-12)
    assert rank_correlation(x, np.full(100, np.inf)) == 0.0
    assert rank_correlation(x, np.full(100, np.nan)) == rank_correlation(x, np.ones(100)) == 0.0


def test_a_band_holds_the_sample_at_each_point_of_a_grid(grid):
    figure = plots.plot_study(grid)
    first, mean, _rise = figure.axes
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
    title = first.get_legend().get_title().get_text()
    assert title.startswith("Median and 5 % to 95 % of 200 cases\n")
    assert f"{grid.failed} of 2000 cases in all have no result" in title


def test_what_cannot_be_drawn_is_refused(study, grid):
    nothing = {name: values * np.nan for name, values in study.results.items()}
    plain = esc.sweep(TIMER, friction=[0.2, 0.3])
    for said, draw, *given in (
        ("must be a grid to be drawn as lines or a map", plots.plot_lines, study, "period"),
        ("must be a grid to be drawn as lines or a map", plots.plot_map, study, "period"),
        ("must be a sample at one point of its grid", plots.plot_sample, grid),
        ("must be a sample for this figure, got a grid", plots.plot_spread, plain),
        (r"result must be one of velocity_max, .*'periods'", plots.plot_sample, study, ["periods"]),
        ("results must be a list of names, got 'period'", plots.plot_sample, study, "period"),
        ("number for period or velocity_max", plots.plot_study, replace(study, results=nothing)),
    ):
        with pytest.raises(InvalidValue, match=said):
            draw(*given)
