"""Extrema of the driver speed next to an angle at which the acceleration jumps."""

from dataclasses import replace

import numpy as np

import escapement as esc

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
