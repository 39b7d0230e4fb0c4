"""Rise times that do not jump, against the handoffs of the motion itself."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import escapement as esc
from both_engines import each_engine
from escapement.base.status import Status
from escapement.base.units import INCH_POUND

INERTIA = esc.Inertia(3e-6 * INCH_POUND, 50e-6 * INCH_POUND)
MEYER = esc.Escapement(esc.Geneva(4), INERTIA, 0.1 * INCH_POUND, 0.35)
CASES = {
    "little friction": (replace(MEYER, friction=0.05), 0.0),
    "much friction": (MEYER, 0.0),
    "three pins": (replace(MEYER, mechanism=esc.Geneva(6)), 0.0),
    "with a dwell": (replace(MEYER, mechanism=esc.Geneva(5, pins=1), load_torque=1e-3), 0.0),
    "from above": (replace(MEYER, friction=0.2), 1000.0),
    "from just below": (replace(MEYER, friction=0.1), 140.0),
    "drag": (replace(MEYER, friction=0.1, driver_drag=1e-9, follower_viscous=1e-7), 0.0),
}


def read_off(handoffs, terminal, share):
    """When the deviation has fallen to a share of the first, by the definition alone."""
    (_, start), *_ = handoffs
    depth = [(t, -math.log(abs(v - terminal) / abs(start - terminal))) for t, v in handoffs]
    for (before, high), (after, low) in pairwise(depth):
        if low >= -math.log(share):
            return before + (-math.log(share) - high) / (low - high) * (after - before)
    raise AssertionError("the motion is too short")


@pytest.mark.parametrize(
    ("case", "engine"), [*((case, "energy") for case in CASES), ("from above", "ivp")]
)
def test_they_are_read_off_the_handoffs(case, engine):
    timer, start = CASES[case]
    cycle = esc.terminal(timer, engine=engine, initial_speed=start)
    motion = esc.simulate(timer, 60, initial_speed=start)
    handoffs = [(0.0, start), *zip(motion.handoff_times, motion.handoff_velocities, strict=True)]
    for name, share in (("rise_time_63", math.exp(-1.0)), ("rise_time_98", 0.02)):
        expected = read_off(handoffs, cycle.handoff_velocity, share)
        assert getattr(cycle, name) == pytest.approx(
            expected, rel=1e-6 if engine == "ivp" else 1e-9
        )


def test_they_pass_smoothly_where_the_rise_time_jumps():
    names = ["rise_time", "rise_time_63", "rise_time_98"]
    study = esc.sweep(MEYER, friction=np.linspace(0.2338, 0.2339, 1000), results=names)
    jumping, *smooth = (np.diff(study.results[name]) for name in names)
    assert np.abs(jumping).max() > 0.02
    for steps in smooth:
        # the slope hardly changes over so little friction: no step differs from their mean
        np.testing.assert_allclose(steps, steps.mean(), rtol=1e-2)


IMPERFECT = {
    "four pins": esc.Geneva(
        4, crank_radius=0.01, centre_distance_error=-2e-5, pin_angle_errors=(1e-3, 0.0, -2e-3, 0.0)
    ),
    "two pins": esc.Geneva(5, 2, crank_radius=0.01, slot_offsets=(1e-5, 0.0, 4e-5, 0.0, -2e-5)),
}


@pytest.mark.parametrize(
    ("wheel", "engine"), [("four pins", "energy"), ("two pins", "energy"), ("four pins", "ivp")]
)
def test_with_imperfect_parts_each_handoff_has_its_own_terminal_speed(wheel, engine):
    timer = replace(MEYER, mechanism=IMPERFECT[wheel], friction=0.15)
    cycle, motion = esc.terminal(timer, engine=engine), esc.simulate(timer, 60)
    # the last handoff of a pattern begins the next one
    ends = np.roll(cycle.motion.handoff_velocities, 1)
    assert np.ptp(ends) > 1e-3 * ends[0]
    speeds = np.append(0.0, motion.handoff_velocities)
    shares = abs(speeds - np.resize(ends, speeds.size)) / ends[0]
    times = np.append(0.0, motion.handoff_times)
    handoffs = [*zip(times, np.maximum(shares, 1e-12), strict=True)]
    for name, share in (("rise_time_63", math.exp(-1.0)), ("rise_time_98", 0.02)):
        expected = read_off(handoffs, 0.0, share)
        assert getattr(cycle, name) == pytest.approx(expected, rel=1e-6)


@each_engine
def test_a_motion_that_starts_at_its_terminal_speed_has_risen(engine):
    start = esc.terminal(MEYER, engine=engine).handoff_velocity
    cycle = esc.terminal(MEYER, engine=engine, initial_speed=start)
    assert (cycle.rise_time_63, cycle.rise_time_98) == (0.0, 0.0)


def test_a_deviation_that_is_lost_in_rounding_counts_as_a_billionth():
    timer = replace(MEYER, friction=0.405)  # an engagement leaves less than 1e-20 of it
    cycle, first = esc.terminal(timer), esc.simulate(timer, 1).handoff_times[0]
    assert cycle.rise_time_63 == pytest.approx(first / (9.0 * math.log(10.0)), rel=1e-12)


@pytest.mark.parametrize(
    ("change", "status", "said"),
    [
        ({"friction": 0.0}, Status.NO_TERMINAL, "no terminal"),
        ({"friction": 0.5}, Status.PAINLEVE, "Painleve"),
        ({"load_torque": 1.0}, Status.STALL, "stalls"),
        ({"friction": 1e-8}, Status.OK, "take more than 1 000 000 engagements"),
    ],
)
def test_there_is_none_without_a_terminal_speed_or_beyond_a_million_engagements(
    change, status, said
):
    cycle = esc.terminal(replace(MEYER, **change))
    assert cycle.status is status
    assert said in cycle.message
    assert math.isnan(cycle.rise_time_98)
    study = esc.sweep(MEYER, results=["rise_time_98"], **{n: [v] for n, v in change.items()})
    assert np.isnan(study.results["rise_time_98"]).all()
