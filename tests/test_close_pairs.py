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


def test_a_pair_a_hair_behind_the_edge_of_a_panel_is_one():
    """At sixteenths of the engagement, where the fast engine's panels end."""
    one = drive(8, 1, 21.229480106477777, 0.0, 0.5605460519473697)
    two = drive(4, 1, 19.59796696558348, 0.0, 2.101616849446852, internal=True)
    motions = [
        (esc.simulate(one, 1, initial_speed=0.8372590709099732, engine=engine).reversals.theta,
         esc.simulate(two, 1, initial_speed=2.348679211668878, engine=engine).extrema.theta)
        for engine in ("energy", "ivp")
    ]  # fmt: skip
    for fast, reference in zip(*motions, strict=True):
        assert len(fast) == 2
        assert fast == pytest.approx(reference, abs=1e-6)


@pytest.mark.parametrize("friction", [0.0, 0.002])
@pytest.mark.parametrize("speed", [299.0375, 299.04, 299.05, 299.1])
def test_the_last_step_of_a_piece_is_looked_through(friction, speed):
    scene = drive(1000, 1, 1.2811205572454039, friction, 280.9483327670186)
    one, two = (esc.simulate(scene, 1, initial_speed=speed, engine=e) for e in ("energy", "ivp"))
    assert len(one.reversals.theta) == (1 if speed > 299.042 else 2)
    assert one.reversals.theta == pytest.approx(two.reversals.theta, abs=1e-7)


@pytest.mark.parametrize(
    ("inertia", "friction"),
    [(0.7436058826003106, 0.7153156866920372), (2.697559013652471, 6.6148256530536775)],
)
def test_a_pair_of_extrema_may_decide_when_a_motion_has_settled(inertia, friction):
    scene = drive(6, 1, inertia, friction, 0.0)
    one, two = (esc.terminal(scene, engine=engine) for engine in ("energy", "ivp"))
    assert one.settling_time == pytest.approx(two.settling_time, rel=1e-9)
    study = esc.sweep(scene, friction=[friction])
    assert study.results["settling_time"][0] == pytest.approx(two.settling_time, rel=1e-9)
