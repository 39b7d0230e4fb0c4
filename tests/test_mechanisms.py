"""The Geneva wheel against the sources' own formulas and against its pin's path."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from escapement.mechanisms import Geneva
from escapement.model import Escapement, Inertia, Mechanism
from escapement.painleve import critical_friction
from escapement.simulation import simulate

wheels = st.builds(Geneva, slots=st.integers(3, 1000), pins=st.just(1), internal=st.booleans())
places = st.floats(-1.0, 1.0)


def pin(wheel, theta):
    """Pin and its first two derivatives, seen from the follower's axis."""
    c = 1.0 / math.sin(math.pi / wheel.slots)
    sense = 1j if wheel.internal else -1j
    r = np.exp(sense * theta) * (1.0 if wheel.internal else -1.0)
    return c + r, sense * r, sense**2 * r


@settings(deadline=None)
@given(wheels, places)
def test_transmission_is_that_of_the_pins_path(wheel, place):
    theta = place * wheel.breaks[-1]
    position, first, second = pin(wheel, theta)
    q = first / position
    found = wheel.transmission(theta)
    scale = 1.0 + abs(q) ** 2 + abs(second / position)
    assert float(found.g) == pytest.approx(q.imag, abs=1e-12 * scale)
    assert float(found.u) == pytest.approx(q.real, abs=1e-12 * scale)
    assert float(found.dg) == pytest.approx((second / position - q**2).imag, abs=1e-11 * scale)
    assert float(wheel.radius(theta)) == pytest.approx(abs(position), rel=1e-12)


@settings(deadline=None)
@given(st.integers(3, 1000), places)
def test_external_wheel_obeys_meyer_1_6_to_1_8_and_filemon_2_and_3(n, place):
    wheel = Geneva(n, pins=1)
    theta = place * wheel.breaks[-1]
    a = 1.0 / math.sin(math.pi / n)
    length = 1.0 + a * a - 2.0 * a * math.cos(theta)
    meyer_7 = (a * math.cos(theta) - 1.0) / length
    meyer_8 = a * math.sin(theta) * (1.0 - a * a) / length**2
    c = 1.0 / a
    scaled = 1.0 + c * c - 2.0 * c * math.cos(theta)
    filemon_2 = c * (math.cos(theta) - c) / scaled
    filemon_3 = -c * (1.0 - c * c) * math.sin(theta) / scaled**2
    found = wheel.transmission(theta)
    rounding = 1e-13 * (1.0 + a * a) / length
    for g in (meyer_7, filemon_2):
        assert float(found.g) == pytest.approx(g, rel=rounding, abs=rounding)
    for dg in (meyer_8, filemon_3):
        assert float(found.dg) == pytest.approx(dg, rel=rounding, abs=rounding)
    tangent = math.tan(float(wheel.follower_angle(theta)))
    assert tangent == pytest.approx(math.sin(theta) / (a - math.cos(theta)), rel=1e-12, abs=1e-14)


@settings(deadline=None)
@given(wheels, st.floats(-0.999, 0.999))
def test_derivatives_are_derivatives(wheel, place):
    theta, h = place * wheel.breaks[-1], 1e-5
    nodes = theta + h * np.array([-2.0, -1.0, 1.0, 2.0])
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * h)
    found = wheel.transmission(theta)
    near = wheel.transmission(np.linspace(theta - 0.1, theta + 0.1, 41))
    scale = 1.0 + np.abs(near.dg).max()
    assert weights @ wheel.follower_angle(nodes) == pytest.approx(float(found.g), abs=1e-8 * scale)
    slope = weights @ wheel.transmission(nodes).g
    assert slope == pytest.approx(float(found.dg), abs=1e-7 * scale)
    slide = weights @ np.log(wheel.radius(nodes))
    assert slide == pytest.approx(float(found.u), abs=1e-8 * scale)


@settings(deadline=None)
@given(wheels)
def test_pins_enter_and_leave_along_the_slots(wheel):
    entry, centre, exit_ = wheel.breaks
    ends = wheel.transmission(np.array([entry, exit_]))
    assert np.abs(ends.g).max() < 1e-12 * (1.0 + np.abs(ends.u).max())
    assert centre == 0.0
    assert float(wheel.transmission(0.0).u) == 0.0
    turned = np.diff(wheel.follower_angle(np.array([entry, exit_])))[0]
    assert turned == pytest.approx(wheel.follower_step, rel=1e-12)
    ratio = 0.5 + (1.0 if wheel.internal else -1.0) / wheel.slots
    assert wheel.motion_ratio == pytest.approx(ratio, rel=1e-12)
    assert isinstance(wheel, Mechanism)


def test_three_pairs_are_always_engaged():
    continuous = {
        (n, p)
        for n in range(3, 200)
        for p in range(1, 2 * n // (n - 2) + 1)
        if Geneva(n, pins=p).continuous
    }
    assert continuous == {(3, 6), (4, 4), (6, 3)}
    for n, p in continuous:
        wheel = Geneva(n)
        assert wheel.pins == p
        assert wheel.motion_ratio == 1.0
        assert wheel.breaks[-1] - wheel.breaks[0] == wheel.cell_angle


@pytest.mark.parametrize(("n", "pins"), [(3, 6), (4, 4), (5, 1), (6, 3), (7, 1), (1000, 1)])
def test_default_pins(n, pins):
    assert Geneva(n).pins == pins
    assert Geneva(n, internal=True).pins == 1


@settings(deadline=None)
@given(wheels, st.floats(-8.0, 8.0))
def test_painleve_limit_is_the_least_ratio_and_is_reached(wheel, exponent):
    rho = 10.0**exponent
    limit = critical_friction(wheel, Inertia(rho, 1.0))
    half = wheel.breaks[-1]
    # dense near the ends, where a light driver has its limit
    away = np.concatenate([np.geomspace(1e-12, 1.0, 4000), np.linspace(1e-6, 1.0, 4000)])
    theta = half * np.concatenate([1.0 - away, away])
    found = wheel.transmission(theta)
    with np.errstate(divide="ignore"):
        ratio = (rho + found.g**2) / (np.abs(found.g) * np.abs(found.u))
    assert limit <= ratio.min() * (1.0 + 1e-12)
    assert limit == pytest.approx(ratio.min(), rel=1e-3)


@pytest.mark.parametrize("internal", [False, True])
@pytest.mark.parametrize("rho", [1e-24, 1e-34, 1e-99])
def test_painleve_limit_of_a_very_light_driver(rho, internal):
    """It is met nearer to the exit than two angles lie apart, at g = sqrt(rho)."""
    for n in (3, 4, 7, 100):
        limit = critical_friction(Geneva(n, internal=internal), Inertia(rho, 1.0))
        assert limit == pytest.approx(2.0 * math.sqrt(rho) / math.tan(math.pi / n), rel=1e-9)
    model = Escapement(Geneva(4, internal=internal), Inertia(rho, 1.0), 1.0, friction=0.3)
    assert f"Painleve limit {2.0 * math.sqrt(rho):.6g}, first met" in simulate(model).message


@pytest.mark.parametrize(
    ("n", "rho", "limit"),
    [(3, 0.6, 0.4 * math.sqrt(2)), (4, 0.06, 0.406079), (6, 0.075, 0.824379), (4, 0.6, 1.106078)],
)
def test_painleve_limit_of_known_drives(n, rho, limit):
    assert critical_friction(Geneva(n), Inertia(rho, 1.0)) == pytest.approx(limit, abs=5e-7)
