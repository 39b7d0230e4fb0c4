"""Statistics of measured errors: tests reject, and intervals contain, as often as they should."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import escapement as esc
from escapement import measurement
from measurement_tools import DEG, PRIKHODKO, read


def test_the_paper_s_numbers():
    expected = np.full(9, 148 / 9)
    observed = expected + np.sqrt(7.595 / 9 * expected)
    classes = measurement.Histogram(np.arange(10.0), observed, expected)
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


@pytest.mark.slow
def test_the_test_of_normality_keeps_its_level(normal_errors):
    p_values = np.array([measurement.anderson_darling(one).p_value for one in normal_errors])
    for level in (0.05, 0.01):
        near = 3 * math.sqrt(level * (1 - level) / REPETITIONS)
        assert (p_values < level).mean() == pytest.approx(level, abs=near)


def test_committed_rates_hold_what_the_page_says():
    root = Path(__file__).parents[1]
    table = (root / "benchmarks/results/normality_level.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(table.splitlines()))
    page = (root / "docs/measuring.md").read_text(encoding="utf-8")
    names = {
        "chi-squared as published": "as published",
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


def test_intervals_hold_what_they_promise():
    random = np.random.default_rng(6)
    held, covered = [], []
    for seed in range(80):
        readings = read(seed=seed, samples=100, noise=0.5 * DEG)
        result = esc.measure(readings, PRIKHODKO, zeros=(0.0, 0.0), confidence=0.9)
        low, high = result.interval
        new = 0.5 * DEG * random.standard_normal(100)
        held.append(((new > low) & (new < high)).mean())
        low, high = result.mean_interval
        covered.append(low < 0.0 < high)
    assert np.mean(held) == pytest.approx(0.9, abs=0.02)
    assert np.mean(covered) == pytest.approx(0.9, abs=3 * math.sqrt(0.09 / 80))


COUNTS = {"sturges": 11, "square-root": 32, "scott": "scott", "freedman-diaconis": "fd", 17: 17}


@pytest.mark.parametrize(("rule", "count"), COUNTS.items())
def test_numbers_of_classes(rule, count):
    errors = np.random.default_rng(0).standard_normal(1000)
    found = measurement.class_count(errors, rule)
    if isinstance(count, str):  # NumPy's own rule
        assert found == pytest.approx(len(np.histogram_bin_edges(errors, count)) - 1, abs=1)
    else:
        assert found == count
    result = measurement.histogram(errors, found)
    assert result.observed.sum() == 1000
    assert result.edges[[0, -1]] == pytest.approx([errors.min(), errors.max()])
