"""Peaks and zeros of functions that are known at points, against closed forms."""

import numpy as np
import pytest

from escapement.numerics import roots as kernels
from escapement.numerics.jit import as_python
from escapement.numerics.search import peaks, roots, zeros

GRID = np.linspace(0.0, 1.0, 40)


def test_a_peak_is_found_to_rounding_in_every_row():
    tops = np.random.default_rng(1).uniform(0.02, 0.98, 50)[:, None]

    def bump(x):
        return 3.0 * np.exp(-4.0 * (x - tops) ** 2)

    points = np.broadcast_to(GRID, (50, GRID.size))
    value, point = peaks(bump, points, bump(points))
    np.testing.assert_allclose(value, 3.0, rtol=1e-15)
    assert np.abs(point - tops[:, 0]).max() < 0.5 * GRID[1] / 4096.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_peak_at_an_end_is_the_value_there(sign):
    points = GRID[None]
    value, point = peaks(lambda x: np.exp(sign * x), points, np.exp(sign * points))
    assert (value[0], point[0]) == (max(1.0, np.exp(sign)), 1.0 if sign > 0.0 else 0.0)


@pytest.mark.parametrize("power", [1, 3, 9])
def test_zeros_are_found_to_rounding(power):
    expected = np.random.default_rng(power).uniform(1.0, 3.0, 60)
    found = zeros(lambda x: (x - expected) ** power, np.full(60, 0.5), np.full(60, 4.0))
    np.testing.assert_allclose(found, expected, rtol=1e-15)


@pytest.mark.parametrize("apart", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("middle", [0.3, 0.512, 0.97])
def test_two_zeros_between_two_points_are_found(middle, apart):
    pair = np.array([middle - apart, middle + apart])

    def parabola(x):
        return (x - pair[0]) * (x - pair[1])

    found = roots(lambda _low, _high: parabola, GRID, parabola(GRID), 0.0)
    # the values have the rounding of the squares of distances
    np.testing.assert_allclose(found, pair, atol=1e-15 / apart)


def test_no_zeros_are_found_where_a_function_stays_clear_of_zero():
    def clear(x):
        return (x - 0.3) ** 2 + 1e-9

    assert roots(lambda _low, _high: clear, GRID, clear(GRID), 0.0) == []
    assert roots(lambda _low, _high: clear, GRID[:1], GRID[:1], 0.0) == []


@pytest.mark.parametrize("top", [0.0, 0.02, 0.4, 0.9999, 1.0])
def test_golden_section_finds_the_maximum(top):
    def hill(x):
        return 5.0 - (x - top) ** 2

    golden_step, golden_trial = as_python(kernels.golden_step), as_python(kernels.golden_trial)
    count = 0
    low, high, best = 0.0, 1.0, as_python(kernels.golden_point)(0.0, 1.0)
    greatest = hill(best)
    while high - low > 1e-12:
        trial, count = golden_trial(low, high, best), count + 1
        low, high, best, greatest = golden_step(low, high, best, greatest, trial, hill(trial))
    # each step leaves 0.618 of the bracket, and near its top the hill is flat
    assert count == 58
    assert abs(best - top) < 1e-7
    assert greatest == pytest.approx(5.0, abs=1e-12)
