"""Filemon's closed forms, and those of the jerk, in fifty digits and by differences."""

import mpmath
import numpy as np
import pytest

import escapement as esc
from any_path import each_wheel
from escapement.constant_speed import geneva


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


@each_wheel
def test_jerk_is_the_slope_of_the_acceleration_function(wheel):
    theta, step = np.linspace(0.95 * wheel.breaks[0], 0.95 * wheel.breaks[-1], 24), 1e-4
    rates = wheel.transmission(theta[:, None] + step * np.array([-2.0, -1.0, 1.0, 2.0])).dg
    slope = rates @ [1.0, -8.0, 8.0, -1.0] / (12.0 * step)
    np.testing.assert_allclose(wheel.jerk(theta), slope, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("ratio", [16 / 9, 10.0, 1000.0])
def test_jerk_of_a_planetary_drive_in_fifty_digits(ratio):
    drive = esc.EllipticalPlanetary(ratio, 1.0)
    theta = np.linspace(-0.45, 0.45, 7) * drive.cell_angle
    with mpmath.workdps(50):
        k = mpmath.mpf(drive.ratio)

        def g(x):
            wide, high = mpmath.cos(k * x / 2) ** 2, mpmath.sin(k * x / 2) ** 2
            return (k * k - 1) * wide / (wide + k * k * high)

        exact = [float(mpmath.diff(g, mpmath.mpf(x), 2)) for x in theta]
    np.testing.assert_allclose(drive.jerk(theta), exact, rtol=1e-11)


def test_jerk_of_a_pin_that_all_but_meets_the_axis_in_fifty_digits():
    wheel = esc.GearDriven(12, "3999/1000")
    first, one, second, other = wheel.arms
    with mpmath.workdps(50):

        def angle(x):
            pin = first * mpmath.expj(one * x) + second * mpmath.expj(other * x)
            return -mpmath.arg(pin)

        at_entry = float(mpmath.diff(angle, mpmath.mpf(wheel.breaks[0]), 3))
    assert float(wheel.jerk(wheel.breaks[0])) == pytest.approx(at_entry, rel=1e-8)
