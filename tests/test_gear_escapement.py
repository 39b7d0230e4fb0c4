"""Gear-driven wheels under a torque, and at constant speed."""

import numpy as np
import pytest

from escapement import Escapement, GearDriven, Inertia, sweep
from escapement.base.errors import InvalidValue
from escapement.constant_speed import index

DRIVES = [
    GearDriven(12, 5, "epicycloid", pins=6),
    GearDriven(24, 5, "hypocycloid", pins=2),
    GearDriven(24, 5, "contracted-hypocycloid", pins=2),
    GearDriven(12, 3, "hypocycloid"),
    GearDriven(8, "1/2", "epicycloid", pins=2),
    GearDriven(9, 5, "pericycloid", pins=2),
]


def test_constant_speed_has_a_closed_mean():
    """Without a loss the work over an engagement is that on the load."""
    for wheel in DRIVES:
        result = index(wheel, 20.0, 0.3, follower_inertia=1e-3)
        nodes, weights = np.polynomial.legendre.leggauss(80)
        half = wheel.breaks[-1]
        work = 2.0 * half * 0.5 * weights @ result.at(half * nodes).torque
        assert work == pytest.approx(0.3 * wheel.follower_step, rel=1e-12)
        inertia_free = index(wheel, 20.0, 0.3, follower_inertia=1e-9)
        assert inertia_free.zone == 1
        assert result.torque_max > inertia_free.torque_max


def test_fractions_may_be_swept_as_text():
    drive = Escapement(GearDriven(4, 2, "epicycloid"), Inertia(1e-6, 1e-5), 0.01, friction=0.1)
    periods = sweep(drive, lobes=[2, "1/2"]).results["period"]
    np.testing.assert_array_equal(periods, sweep(drive, lobes=[2.0, 0.5]).results["period"])
    with pytest.raises(InvalidValue, match=r"lobes\[1\] must be a rational number .* 'half'"):
        sweep(drive, lobes=[2, "half"])
