"""Figures of wheels nearly without losses, whose transient is leapt over."""

import math
from time import process_time

import numpy as np
import pytest

import escapement as esc
from escapement.base.status import Status
from escapement.dynamics.figure_table import TRANSIENT
from escapement.dynamics.figures_of_merit import fall_times, read_transient
from slow_wheels import random_wheel, with_lossy_trains, with_uneven_parts

GENEVA, INERTIA, TORQUE = esc.Geneva(4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113


def wheel(geneva=GENEVA, **numbers):
    return esc.Escapement(geneva, INERTIA, torque=TORQUE, **numbers)


@pytest.mark.parametrize(
    ("escapement", "start"),
    [
        (wheel(friction=1e-4), 0.0),
        (wheel(friction=1e-4), 3e4),
        (wheel(friction=1e-4, load_torque=2e-3), 0.0),
        (wheel(friction=3e-5, driver_viscous=1e-9), 0.0),
        (wheel(friction=0.0, follower_drag=2e-9), 0.0),
        # here an extremum appears at the pin exit when its speed is in the band already
        (wheel(esc.Geneva(8), friction=1e-4), 0.0),
    ],
)
def test_times_are_those_of_the_motion(escapement, start):
    figures = esc.terminal(escapement, initial_speed=start)
    assert 0.99 < figures.contraction < 0.9999
    decay = 6.0 + 2.0 * math.log1p(start / figures.handoff_velocity)
    count = int(decay / (1.0 - figures.contraction))
    motion = esc.simulate(escapement, count, initial_speed=start)
    rise, settled = read_transient(motion, figures)
    cycle = esc.simulate(escapement, 1, initial_speed=figures.handoff_velocity)
    told = (rise, *fall_times(motion, start, cycle), settled)
    for name, time in zip(TRANSIENT, told, strict=True):
        assert getattr(figures, name) == pytest.approx(time, rel=1e-9)


def test_a_drag_of_the_driver_alone_balances_the_torque():
    """Without friction the drag c w takes the work of the drive over a cell, to first order."""
    drag = 1e-11
    figures = esc.terminal(wheel(friction=0.0, driver_drag=drag))
    # w (rho + g^2) is nearly constant: its mean of w over the cell decides
    theta = np.linspace(*GENEVA.breaks[::2], 20001)
    g = GENEVA.transmission(theta).g
    share = INERTIA.driver / (INERTIA.driver + INERTIA.follower * g**2)
    square = TORQUE / (drag * np.trapezoid(share, theta) / (theta[-1] - theta[0]))
    assert figures.handoff_velocity == pytest.approx(math.sqrt(square), rel=1e-4)


@pytest.mark.parametrize("seed", range(20))
def test_no_wheel_takes_long(seed):
    escapement, start = random_wheel(np.random.default_rng(seed))
    esc.terminal(wheel(friction=0.3))
    before = process_time()
    figures = esc.terminal(escapement, initial_speed=start)
    assert process_time() - before < 0.05
    assert not figures.status.failed


@pytest.mark.parametrize("kind", [with_lossy_trains, with_uneven_parts])
def test_trains_that_lose_power_and_uneven_parts_take_little_longer(kind):
    """The least of three times. A few trains lose so much that the motion is marched, not leapt."""
    esc.terminal(kind(np.random.default_rng(0))[0])
    late = []
    for seed in range(12):
        escapement, start = kind(np.random.default_rng(seed))
        seconds = []
        for _ in range(3):
            before = process_time()
            status = esc.terminal(escapement, initial_speed=start).outcome
            seconds.append(process_time() - before)
        assert status is not Status.NOT_CONVERGED
        late += [seed] if min(seconds) > 0.2 else []
    assert late == []


@pytest.mark.parametrize(("friction", "load"), [(1e-4, 0.0), (5e-4, 1e-3)])
def test_uneven_parts_rise_as_their_motion_does(friction, load):
    geneva = esc.Geneva(5, 2, crank_radius=0.01, slot_offsets=(1e-8, 0.0, 4e-8, 0.0, -2e-8))
    escapement = wheel(geneva, friction=friction, load_torque=load)
    figures = esc.terminal(escapement)
    # long enough that its last engagements are those of the cycle
    motion, cycle = esc.simulate(escapement, 30_000), figures.motion
    rise, settled = read_transient(motion, figures)
    told = (rise, *fall_times(motion, 0.0, cycle), settled)
    for name, time in zip(TRANSIENT, told, strict=True):
        assert getattr(figures, name) == pytest.approx(time, rel=1e-9, nan_ok=True)


@pytest.mark.parametrize(
    ("escapement", "start"),
    [
        (wheel(friction=1e-7, load_torque=0.0115), 3e3),
        (wheel(friction=1e-7, load_torque=0.0114, driver_viscous=1e-10), 3e3),
        (
            wheel(
                friction=1e-6, load_torque=2e-3,
                barrel=esc.Train(10.0, 0.9), load_train=esc.Train(1.1, 0.9),
            ),
            1e4,
        ),
    ],
)  # fmt: skip
def test_a_fast_start_that_ends_in_a_stall_is_leapt_over(escapement, start):
    """The stall is that of the motion, of which every engagement is marched."""
    motion = esc.simulate(escapement, 20_000, initial_speed=start)
    figures = esc.terminal(escapement, initial_speed=start)
    assert figures.outcome is motion.outcome is Status.STALL
    assert figures.message == motion.message


def test_without_any_loss_there_is_no_terminal_cycle():
    for load in (0.0, 1e-3):
        figures = esc.terminal(wheel(friction=0.0, load_torque=load))
        assert figures.status is Status.NO_TERMINAL
        assert math.isnan(figures.period)
