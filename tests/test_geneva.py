"""The Geneva wheel against 40 digits of its pin's path, and every number of pins."""

import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from escapement.base.errors import InvalidValue
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import Mechanism

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
        assert wheel.radius(theta) == pytest.approx(float(abs(path(mpf(theta)))), rel=1e-12)
        assert all(e <= mpf("1e-15") * 8 * (1 + s) for e, s in zip(error, sizes, strict=True))
        turned = float(mp.arg(path(mpf(theta))))
        assert wheel.follower_angle(theta) == pytest.approx(turned, rel=1e-12, abs=1e-300)


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


def test_a_wheel_is_a_value():
    assert Geneva(4) == Geneva(slots=np.int64(4), pins=4, internal=np.False_)
    assert len({Geneva(4), Geneva(4, 4), Geneva(4, 2), Geneva(4, crank_radius=1.0)}) == 3
    with pytest.raises(FrozenInstanceError):
        Geneva(4).slots = 5
    shape = Geneva(5).transmission(np.zeros((2, 0, 3))).g.shape
    assert shape == Geneva(5).follower_angle(np.zeros((2, 0, 3))).shape == (2, 0, 3)


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


@pytest.mark.parametrize(("n", "pins"), [(3, 6), (4, 4), (5, 1), (6, 3), (7, 1), (1000, 1)])
def test_default_pins(n, pins):
    """One, or as many as make one follow the other without a gap."""
    wheel = Geneva(n)
    assert wheel.pins == pins
    assert Geneva(n, internal=True).pins == 1
    assert wheel.continuous == (n in (3, 4, 6))
    if wheel.continuous:
        assert wheel.motion_ratio == 1.0
        assert wheel.breaks[-1] - wheel.breaks[0] == wheel.cell_angle
