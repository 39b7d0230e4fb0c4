"""Both engines, which share no numerical method, find one motion and one cycle in every scene."""

from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
import test_imperfect_planet
from both_engines import agree
from elliptical_tools import PAPER
from escapement.base.status import Status
from escapement.dynamics.painleve import friction_limits
from random_drives import drive
from test_gear_escapement import DRIVES
from test_motor import geared
from test_real_mechanism import CRANK, DRAG, INERTIA, OIL, TORQUE, everything
from test_table import measured, moved_by

LOSSES = DRAG | OIL | {"driver_bearing_torque": 0.1 * TORQUE}
AT_STOPS = {"events": False}
"""Beside a stop of the follower rounding decides on reversals."""


def turned(mechanism, share=0.0, **numbers):
    """An escapement with a share of the greatest friction."""
    plain = esc.Escapement(mechanism, INERTIA, TORQUE, **numbers)
    return replace(plain, friction=share * min(*friction_limits(plain), 0.8)) if share else plain


def spring(slots):
    return {"spring_rate": 0.2 * TORQUE / esc.Geneva(slots).cell_angle}


MOTIONS = {
    **{f"{wheel.stations} {wheel.curve}": (turned(wheel, 0.6, load_torque=5e-4), 6, {"rtol": 1e-9})
       for wheel in DRIVES},
    # g is rounded below zero where the wheel starts from rest
    "rounded": (esc.Escapement(esc.GearDriven(24, 0, "epicycloid", pins=2),
                               esc.Inertia(0.8560442686544377, 1.0), 1.0, 0.03787595660111593),
                2, {"rtol": 1e-9}),
    "mesh": (turned(PAPER, efficiency=0.9), 5, AT_STOPS),
    "loaded mesh": (turned(esc.EllipticalPlanetary(3.0, 1.0), efficiency=0.8,
                           load_torque=0.1 * TORQUE), 5, AT_STOPS),
    # the sign of the force at a stop must not be rounding
    "heavy driver": (esc.Escapement(esc.EllipticalPlanetary(1.65, 1.0), esc.Inertia(242.0, 1.0),
                                    1.0, efficiency=0.84), 3, AT_STOPS),
    # behind a reversal close to the stop the first steps of time are shorter than rounding
    "short steps": (esc.Escapement(esc.EllipticalPlanetary(2.0, 1.0), esc.Inertia(0.0114, 0.1), 4.0,
                                   load_torque=0.2, load_curve=esc.Unbalance(0.72, -1.5),
                                   efficiency=0.9, follower_viscous=0.02), 2, {}),
    "gears with drag": (turned(esc.GearDriven(6, "1/2", fixed_radius=CRANK), **LOSSES), 2, {}),
    "mesh with drag": (turned(PAPER, efficiency=0.9, **LOSSES), 2, AT_STOPS),
    **{f"all effects, {n} slots": (everything(slots=n, friction=0.2, **spring(n)), 4, {})
       for n in (4, 5)},
    "cam": (turned(esc.CamIndexer(8, 2.1), efficiency=0.9), 3, {}),
    # the work of the drive is taken from the way, whose parts are unequal
    "uneven, spring": (turned(esc.Geneva(5, 2, crank_radius=CRANK, crank_radius_errors=(3e-5, 0.0)),
                              0.4, **spring(5)), 6, {}),
    # its rotor pushes the driver, and is pushed by it
    "motor": (geared(driver_viscous=0.1), 3, {}),
    "a stop in oil": (everything(friction=0.1, load_torque=0.7 * TORQUE), 20, {"rtol": 1e-8}),
    # the greatest speed lies behind the reversal of a spent spring
    "spent": (esc.Escapement(esc.Geneva(12, 2), esc.Inertia(1.2222e-6, 1.35e-7), torque=0.08135,
                             spring_rate=0.0015876, friction=13.6, follower_drag=2.671e-9), 20, {}),
    # noise makes g change its sign beside a stop, and with it the sense of what is lost
    **{f"noise {noise}, {seed}": (moved_by(measured(noise, seed)), 2, AT_STOPS | {"rtol": 1e-9})
       for noise, seed in ((0.5, 2), (0.5, 3), (0.1, 6), (0.01, 3))},
}  # fmt: skip


@pytest.mark.parametrize("name", MOTIONS)
def test_both_engines_find_one_motion(name):
    timer, engagements, options = MOTIONS[name]
    fast, slow = agree(timer, engagements, **options)
    assert fast.message == slow.message
    if options.get("events", True):
        assert fast.extrema.theta == pytest.approx(slow.extrema.theta, abs=1e-6)
    if name == "a stop in oil":
        assert fast.status is esc.terminal(timer).status is Status.STALL


def sized(slots, pins=None, *numbers, crank=0.02, **internal):
    return drive(slots, pins, *numbers, crank_radius=crank, **internal)


PLANET = test_imperfect_planet.imperfect(np.random.default_rng(3), *test_imperfect_planet.CURVES[2])
CYCLES = {
    "four pins": (sized(4), 0.0),
    "one pin, from above": (sized(8, 1, 0.5, 0.4, 0.05), 40.0),
    "internal": (sized(5, 1, 0.3, 0.2, internal=True), 0.0),
    # an extremum on a handoff belongs to both of its engagements
    "at a handoff": (sized(4, 1, 3.848446, 0.877957, internal=True), 0.0),
    **{
        f"{wheel.stations} {wheel.curve}": (turned(wheel, 0.6, load_torque=5e-4), 0.0)
        for wheel in DRIVES[::2]
    },
    "mesh": (turned(PAPER, efficiency=0.9), 0.0),
    # drag holds it at its final speed in the dwell
    "light driver": (replace(everything(slots=5, friction=0.05),
                             inertia=esc.Inertia(1.3e-8, 5.65e-6)), 0.0),
    "uneven gears": (turned(PLANET, 0.5), 20.0),
}  # fmt: skip


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.slow] * (n == "uneven gears")) for n in CYCLES],
)
def test_both_engines_give_the_same_figures(name):
    timer, speed = CYCLES[name]
    fast, judge = (
        esc.terminal(timer, engine=engine, initial_speed=speed) for engine in ("energy", "ivp")
    )
    assert fast.status is judge.status is Status.OK
    np.testing.assert_allclose(fast.beats, judge.beats, rtol=1e-9)
    assert fast.contraction == pytest.approx(judge.contraction, abs=1e-6)
    found = fast.as_dict()
    for figure, value in judge.as_dict().items():
        if figure not in ("contraction", "energy_residual", "message"):
            # rises to a share are differences of speeds
            rel = 1e-6 if figure in ("rise_time_63", "rise_time_98") else 1e-8
            assert found[figure] == pytest.approx(value, rel=rel, abs=1e-15, nan_ok=True), figure
