"""Extrema of the driver speed next to an angle at which the acceleration jumps."""

from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from both_engines import agree

WHEEL = esc.Geneva(4, crank_radius=0.01, pin_radius=5e-4)
TIMER = esc.Escapement(
    WHEEL, esc.Inertia(2.5e-7, 5e-6), torque=0.01, driver_bearing_friction=0.2,
    driver_bearing_radius=1e-3, follower_bearing_friction=0.2, follower_bearing_radius=1e-3,
)  # fmt: skip


def test_a_minimum_just_before_a_change_of_sliding_is_found():
    """With journals the acceleration jumps down where the contact point changes its way.

    A minimum before that place and another behind it lie next to each other; the scan moves them
    over the place.
    """
    pairs = 0
    for friction in np.linspace(0.254, 0.262, 60):
        motion = esc.terminal(replace(TIMER, friction=friction)).motion
        change = motion.slide_changes.time
        near = change[0] + np.linspace(-1.0, 1.0, 2001) * 0.02 * motion.end_time
        lowest = motion.at(near[(near > 0.0) & (near < motion.end_time)]).theta_dot.min()
        extrema = motion.extrema
        found = extrema.theta_dot[~extrema.maximum].min()
        assert found <= lowest * (1.0 + 1e-13)
        close = np.abs(extrema.time - change[0]) < 0.02 * motion.end_time
        pairs += np.count_nonzero(close) > 1
    assert pairs > 0


def test_a_maximum_behind_the_reversal_of_a_spent_spring_is_found():
    timer = esc.Escapement(
        esc.Geneva(12, 2), esc.Inertia(1.2222e-6, 1.35e-7), torque=0.08135, spring_rate=0.0015876,
        friction=13.6, follower_drag=2.671e-9,
    )  # fmt: skip
    one, two = (motion.extrema for motion in agree(timer, 20, rtol=1e-10))
    assert one.theta == pytest.approx(two.theta, abs=1e-6)
