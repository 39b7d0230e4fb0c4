"""The Geneva wheel in 40 digits, and with every number of pins that fits."""

import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from escapement.errors import InvalidValue
from escapement.mechanisms import Geneva

wheels = st.builds(Geneva, slots=st.integers(3, 1000), pins=st.just(1), internal=st.booleans())
places = st.floats(-1.0, 1.0)
tens = settings(deadline=None, max_examples=40)


def pin_path(wheel):
    """C(theta) in mpmath, from the axis of the follower, crank radius 1 (Meyer 1-1, 1-2)."""
    c = 1 / mp.sin(mp.pi / wheel.slots)
    turn = 1 if wheel.internal else -1
    return lambda theta: c + turn * mp.expj(turn * theta)


@tens
@given(wheels, places)
def test_transmission_to_the_last_digits(wheel, place):
    """q = C'/C by mpmath's own derivative; errors in units of what a rounded angle does."""
    theta = place * wheel.breaks[-1]
    found = wheel.transmission(theta)
    with mp.workdps(40):
        path = pin_path(wheel)
        q = mp.diff(path, mpf(theta)) / path(mpf(theta))
        second = mp.diff(path, mpf(theta), 2) / path(mpf(theta))
        slope = mp.im(second - q**2)
        bend = abs(mp.diff(lambda x: mp.im(mp.diff(path, x) / path(x)), mpf(theta), 2))
        top = abs(q)
        error = [abs(found.g - mp.im(q)), abs(found.u - mp.re(q)), abs(found.dg - slope)]
        sizes = [top + abs(slope), top + abs(second) + top**2, abs(slope) + bend + top**2]
        assert all(e <= mpf("1e-15") * 8 * (1 + s) for e, s in zip(error, sizes, strict=True))


@tens
@given(wheels, st.floats(0.0, 1.0))
def test_complex_step_gives_the_slope(wheel, place):
    """Meyer 1-7 with a complex angle: no difference is taken, so no digit is lost."""
    theta, step = place * wheel.breaks[-1], 1e-100
    a = 1.0 / math.sin(math.pi / wheel.slots)
    sense = -1.0 if wheel.internal else 1.0
    cosine = np.cos(theta + 1j * step)
    g = (a * cosine - sense) / (1.0 + a * a - 2.0 * sense * a * cosine)
    g, dg = g.real, g.imag / step
    found = wheel.transmission(theta)
    near = 1.0 + 1.0 / abs(a - sense * math.cos(theta)) ** 2
    assert float(found.g) == pytest.approx(g, abs=1e-13 * near)
    assert float(found.dg) == pytest.approx(dg, rel=1e-10, abs=1e-13 * near)


@tens
@given(wheels)
def test_greatest_ratio_is_at_dead_centre(wheel):
    """1/(a - 1) outside, 1/(a + 1) inside: slow wheels have long cranks (Meyer 1-7)."""
    a = wheel.centre_distance
    sense = -1.0 if wheel.internal else 1.0
    found = wheel.transmission(np.linspace(*wheel.breaks[::2], 401))
    assert found.g.max() == pytest.approx(1.0 / (a - sense), rel=1e-9)
    assert found.g.min() >= -1e-12 * found.g.max()
    assert np.argmax(found.g) == 200
    centre = wheel.transmission(0.0)
    assert float(centre.u) == float(centre.dg) == 0.0
    assert np.all(found.u * found.dg * sense <= 0.0)


@settings(deadline=None)
@given(st.integers(3, 1000), st.booleans(), st.integers(1, 6))
def test_pins_fit_while_their_motions_do(n, internal, pins):
    """p pins move the wheel p times a turn, each for 1/2 - 1/n or 1/2 + 1/n of it."""
    share = 0.5 + (1.0 if internal else -1.0) / n
    if pins * share > 1.0 + 1e-12 or (internal and pins > 1):
        with pytest.raises(InvalidValue, match=rf"pins must be at most [1-6] for .*, got {pins};"):
            Geneva(n, pins, internal)
        return
    wheel = Geneva(n, pins, internal)
    assert wheel.cell_angle == pytest.approx(2.0 * math.pi / pins, rel=1e-15)
    assert wheel.motion_ratio == pytest.approx(pins * share, rel=1e-14)
    assert wheel.engagement_angle == pytest.approx(2.0 * math.pi * share, rel=1e-14)
    assert wheel.continuous == (abs(pins * share - 1.0) < 1e-12)
    assert wheel.follower_step * n == pytest.approx(2.0 * math.pi, rel=1e-15)
    assert wheel.breaks[-1] - wheel.breaks[0] <= wheel.cell_angle * (1.0 + 1e-15)


def test_most_pins_are_six_four_three_and_then_two():
    def most(n):
        fitting = []
        for pins in range(1, 8):
            try:
                fitting.append(Geneva(n, pins).pins)
            except InvalidValue:
                break
        return fitting[-1]

    assert [most(n) for n in (3, 4, 5, 6, 7, 8, 1000)] == [6, 4, 3, 3, 2, 2, 2]


def test_a_wheel_is_a_value():
    assert Geneva(4) == Geneva(slots=np.int64(4), pins=4, internal=np.False_)
    assert len({Geneva(4), Geneva(4, 4), Geneva(4, 2), Geneva(4, crank_radius=1.0)}) == 3
    with pytest.raises(FrozenInstanceError):
        Geneva(4).slots = 5
    shape = Geneva(5).transmission(np.zeros((2, 0, 3))).g.shape
    assert shape == Geneva(5).follower_angle(np.zeros((2, 0, 3))).shape == (2, 0, 3)
