"""Pins with width, rollers, bearings and drag: printed examples, two engines, limits, refusals.

The printed numbers come from two computations that share nothing with this package: one in time
with all reactions as unknowns, one over the driver angle.
"""

import math

import numpy as np
import pytest

import escapement as esc
from both_engines import agree, each_engine
from escapement.base.status import Status
from escapement.base.units import INCH_POUND
from escapement.dynamics.painleve import friction_limits

CRANK = 0.01  # m; only ratios to it matter
INERTIA = esc.Inertia(driver=3e-6 * INCH_POUND, follower=50e-6 * INCH_POUND)
TORQUE = 0.10 * INCH_POUND
VISCOUS = math.sqrt(INERTIA.follower * TORQUE)
LOSSES = ("friction", "driver_bearing", "follower_bearing", "driver_drag", "follower_drag")

JOURNALS = {
    "driver_bearing_friction": 0.15,
    "driver_bearing_radius": 0.08 * CRANK,
    "follower_bearing_friction": 0.15,
    "follower_bearing_radius": 0.08 * CRANK,
}
DRAG = {"driver_drag": 0.005 * INERTIA.follower, "follower_drag": 0.02 * INERTIA.follower}
OIL = {"driver_viscous": 0.05 * VISCOUS, "follower_viscous": 0.02 * VISCOUS}
# of each: the wheel's numbers, the escapement's, and period, maximum and minimum speed
EXAMPLES = {
    "ideal": ({}, {}, (0.0414950340, 131.539286, 18.4683731)),
    "pin": ({"pin_radius": 0.08 * CRANK}, {}, (0.0396950554, 139.999377, 19.2957318)),
    "journals": ({}, JOURNALS, (0.0425791403, 126.432686, 18.0548638)),
    "bearing torque": (
        {},
        {"driver_bearing_torque": 0.1 * TORQUE},
        (0.0437396063, 124.789124, 17.5206371),
    ),
    "air": ({}, DRAG, (0.0419743449, 129.148538, 18.2660395)),
    "oil": ({}, OIL, (0.0430254882, 125.334148, 17.8837598)),
    # a loose dry bush of coefficient m has the torque m/sqrt(1 + m^2) times its load
    "roller": (
        {"pin_radius": 0.04 * CRANK, "roller_radius": 0.1 * CRANK},
        {"friction": 0.3 / math.sqrt(1.0 - 0.3**2)},
        (0.0260426801, 251.810293, 27.0413128),
    ),
}


def timer(wheel=(), slots=4, **numbers):
    mechanism = esc.Geneva(slots, crank_radius=CRANK, **dict(wheel))
    return esc.Escapement(mechanism, INERTIA, **{"friction": 0.3, "torque": TORQUE} | numbers)


def everything(**changes):
    return timer({"pin_radius": 0.05 * CRANK}, **JOURNALS | DRAG | OIL | changes)


@each_engine
@pytest.mark.parametrize("name", EXAMPLES)
def test_printed_examples(name, engine):
    wheel, numbers, (period, fastest, slowest) = EXAMPLES[name]
    cycle = esc.terminal(timer(wheel, **numbers), engine=engine)
    assert cycle.period == pytest.approx(period, abs=0.51e-10)
    assert cycle.velocity_max == pytest.approx(fastest, abs=0.51e-6)
    assert cycle.velocity_min == pytest.approx(slowest, abs=0.51e-7)


def test_a_constant_torque_of_the_bearing_is_less_torque():
    share = 0.3
    held = esc.terminal(timer(driver_bearing_torque=share * TORQUE))
    assert held.period == pytest.approx(
        esc.terminal(timer()).period / math.sqrt(1.0 - share), rel=1e-13
    )


@pytest.mark.parametrize("slots", [4, 5])  # with five slots there is a dwell
def test_engines_agree_with_all_effects_and_losses_add_up(slots):
    real = everything(slots=slots, friction=0.2, load_torque=0.05 * TORQUE)
    fast, slow = agree(real, 4, rtol=1e-11)
    np.testing.assert_allclose(fast.slide_changes.theta, slow.slide_changes.theta, atol=1e-9)
    for name in LOSSES:
        lost = getattr(fast.ledger, name)
        assert lost > 0.0
        assert lost == pytest.approx(getattr(slow.ledger, name), rel=1e-9)
        # the powers at times add up to the same work
        power = np.trapezoid(fast.at(grid := _grid(fast)).power_lost[name], grid)
        assert lost == pytest.approx(power, rel=5e-3)  # it jumps at a handoff


def _grid(motion):
    return np.unique(np.concatenate([motion.t, np.linspace(0.0, motion.end_time, 20_001)]))


def test_numbers_of_zero_leave_every_bit():
    zeros = dict.fromkeys((*JOURNALS, *DRAG, *OIL, "driver_bearing_torque"), 0.0)
    one, two = (esc.simulate(timer(**numbers), engagements=9) for numbers in ({}, zeros))
    np.testing.assert_array_equal(one.handoff_times, two.handoff_times)
    np.testing.assert_array_equal(one.reversals.theta, two.reversals.theta)


@pytest.mark.parametrize(("radius", "degrees"), [(0.0, 0.0), (0.05, -2.85), (0.1, -5.59)])
def test_the_contact_point_changes_its_sense_of_sliding_on_the_line_of_centres(radius, degrees):
    motion = esc.simulate(timer({"pin_radius": radius * CRANK}, friction=0.1), engagements=1)
    found = np.degrees(motion.slide_changes.theta)
    assert found[0] == pytest.approx(degrees, abs=0.005)
    # there the wall is crossed without sliding: no power is lost in the slot
    at = motion.at(motion.slide_changes.time)
    assert abs(at.power_lost["friction"][0]) < 1e-9 * TORQUE * at.theta_dot[0]


def test_a_pin_with_width_parts_the_limits_of_existence_and_of_uniqueness():
    existence, uniqueness = friction_limits(timer({"pin_radius": 0.05 * CRANK}))
    assert existence == pytest.approx(0.4231149, abs=5e-8)
    assert uniqueness == pytest.approx(0.3902965, abs=5e-8)
    between = timer({"pin_radius": 0.05 * CRANK}, friction=0.40)
    cycle, motion = esc.terminal(between), esc.simulate(between)
    assert cycle.status is motion.status is Status.OK
    assert (cycle.critical_friction, cycle.uniqueness_friction) == (existence, uniqueness)
    for outcome in (cycle, motion, esc.terminal(between, engine="ivp")):
        assert "a second motion is possible" in outcome.message
    beyond = esc.terminal(timer({"pin_radius": 0.05 * CRANK}, friction=0.43))
    assert beyond.status is Status.PAINLEVE
