"""Extremes of transmission, acceleration and jerk by search and in fifty digits."""

import mpmath
import numpy as np
import pytest

import escapement as esc
from any_path import each_wheel, plain
from escapement.constant_speed import geneva, jerk_function
from escapement.mechanisms.protocol import Mechanism


@each_wheel
def test_extrema_are_found_by_search_too(wheel):
    found = esc.transmission_extrema(wheel)
    theta = np.linspace(wheel.breaks[0], wheel.breaks[-1], 4001)
    for read, top, bottom in (
        (lambda x: wheel.transmission(x).g, found.ratio_max, None),
        (lambda x: wheel.transmission(x).dg, found.acceleration_max, found.acceleration_min),
        (lambda x: jerk_function(wheel, x), found.jerk_max, found.jerk_min),
    ):
        values = read(theta)
        size = np.abs(values).max()
        assert float(read(top.angle)) == pytest.approx(top.value, rel=1e-13)
        assert values.max() <= top.value + 1e-13 * size
        assert top.value == pytest.approx(values.max(), abs=1e-4 * size)
        if bottom is not None:
            assert float(read(bottom.angle)) == pytest.approx(bottom.value, rel=1e-13)
            assert values.min() >= bottom.value - 1e-13 * size
            assert bottom.value == pytest.approx(values.min(), abs=1e-4 * size)


@each_wheel
def test_a_mechanism_of_unknown_kind_has_the_same_extrema_and_jerk(wheel):
    closed, found = (esc.transmission_extrema(m) for m in (wheel, plain(wheel)))
    assert isinstance(plain(wheel), Mechanism)
    for name in ("ratio_max", "acceleration_max", "acceleration_min", "jerk_max", "jerk_min"):
        assert getattr(found, name).value == pytest.approx(getattr(closed, name).value, rel=1e-9)
    angles = [abs(one.acceleration_max.angle) for one in (found, closed)]
    assert angles[0] == pytest.approx(angles[1], abs=1e-9)
    theta, step = np.linspace(0.95 * wheel.breaks[0], 0.95 * wheel.breaks[-1], 24), 1e-4
    rates = wheel.transmission(theta[:, None] + step * np.array([-2.0, -1.0, 1.0, 2.0])).dg
    slope, jerk = rates @ [1.0, -8.0, 8.0, -1.0] / (12.0 * step), jerk_function(wheel, theta)
    np.testing.assert_allclose(jerk, slope, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(jerk_function(plain(wheel), theta), jerk, rtol=1e-8, atol=1e-8)


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
