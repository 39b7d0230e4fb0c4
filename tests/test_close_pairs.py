"""Two reversals, or two extrema, close together: neither engine may pass over them."""

import pytest

import escapement as esc
from random_drives import drive

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("slots", "inertia", "friction", "load", "speed"),
    [
        (4, 5.0, 0.5, 0.37, 0.12065),
        (4, 14.606151221241705, 3.726891127293215, 0.12967044109526968, 0.0414),
        (100, 0.11379251425400713, 3.535209570940652, 10.023919222737323, 17.74156477897008),
        # the first of the two a hair behind the middle of the way out
        (6, 77.1660000212392, 8.676917340368181, 0.050086541193986145, 0.12167297189104886),
    ],
)
def test_with_friction_the_speed_depends_on_it(slots, inertia, friction, load, speed):
    scene = drive(slots, 1, inertia, friction, load)
    one = esc.simulate(scene, 1, initial_speed=speed)
    two = esc.simulate(scene, 1, initial_speed=speed, engine="ivp", rtol=1e-12)
    assert one.reversals.theta == pytest.approx(two.reversals.theta, abs=1e-8)
    assert len(one.reversals.theta) == 2
    assert one.handoff_velocities == pytest.approx(two.handoff_velocities, rel=1e-12)
    assert one.handoff_times == pytest.approx(two.handoff_times, rel=1e-12)
    assert abs(one.ledger.residual) < 1e-14
