"""Motions whose end is far off: hardly any loss, a stop after thousands of turns, no end at all.

Units are natural ones: follower inertia and torque are 1.
"""

import numpy as np
import pytest

import escapement as esc
from escapement.status import Status


def natural(mechanism, rho, **losses):
    return esc.Escapement(mechanism, esc.Inertia(rho, 1.0), torque=1.0, **losses)


@pytest.mark.parametrize(
    ("slots", "pins", "rho", "friction", "load"),
    [
        (7, 1, 981.539600105676, 0.28009345558399046, 0.0),
        (3, 6, 1783041.2109403554, 7.75424409679428e-10, 6.334169734701668e-07),
        (4, 4, 500.0, 1e-4, 0.0),
    ],
)
def test_a_cycle_that_hardly_loses_loses_what_the_drive_gives(slots, pins, rho, friction, load):
    """The speed is the root of what is lost, and one part in 1e4 to 1e14 of its energy is.

    Loss is integrated over the contact moment, the work known in closed form.
    """
    timer = natural(esc.Geneva(slots, pins=pins), rho, friction=friction, load_torque=load)
    figures = esc.terminal(timer, rtol=1e-13)
    assert 0.0 < 1.0 - figures.contraction < 1e-3
    cycle = esc.simulate(timer, 1, initial_speed=figures.handoff_velocity, rtol=1e-13)
    wheel = timer.mechanism
    work = wheel.cell_angle - load * wheel.follower_step
    assert cycle.trajectory.friction_loss.sum() == pytest.approx(work, rel=1e-12)


def test_a_stop_is_told_where_it_happens():
    """Newton's method stalls at once; the motion does after 679 engagements."""
    wheel, rho = esc.Geneva(27, pins=2), 233299.4562732638
    timer = natural(wheel, rho, friction=44929.73726719754, load_torque=12.951931653740314)
    speed = 177.4613364531827
    motion = esc.simulate(timer, 1000, initial_speed=speed)
    assert motion.status is Status.STALL
    assert motion.handoff_times.size > 500
    figures = esc.terminal(timer, initial_speed=speed)
    assert figures.status is Status.STALL
    assert figures.message == motion.message


@pytest.mark.parametrize(("engine", "load"), [("energy", 0.0), ("energy", 0.25), ("ivp", 0.25)])
def test_a_constant_ratio_speeds_up_without_end(engine, load):
    """theta_ddot = (1 - p load)/(rho + g p) with p = g/efficiency, whatever the speed."""
    theta = np.linspace(0.0, 2.0 * np.pi, 19)
    gears = natural(esc.Tabulated(theta, 0.5 * theta), 0.5, efficiency=0.9, load_torque=load)
    bent = 0.5 / 0.9
    acceleration = (1.0 - bent * load) / (0.5 + 0.5 * bent)
    motion = esc.simulate(gears, 3, engine=engine)
    passed = 2.0 * np.pi * np.arange(1, 4)
    np.testing.assert_allclose(
        motion.handoff_velocities, np.sqrt(2.0 * acceleration * passed), rtol=1e-9
    )
    figures = esc.terminal(gears, engine=engine)
    assert figures.status is Status.NO_TERMINAL
    assert "a ratio that varies" in figures.message


def test_a_motion_that_loses_at_every_speed_has_no_terminal_cycle():
    """Fast it turns around in the slot, slow it does not: neither is what it settles to."""
    wheel, rho = esc.Geneva(15, pins=2), 2697136.0225537354
    heavy = natural(wheel, rho, friction=0.07568599921333452, load_torque=7.261626849626713)
    for speed in (0.04, 0.4, 3.75, 4.5, 8.0, 20.0):
        motion = esc.simulate(heavy, 1, initial_speed=speed)
        assert motion.handoff_velocities[0] < speed
    status = esc.terminal(heavy, initial_speed=20.152993992877356, rtol=1e-5).status
    assert status in (Status.STALL, Status.NOT_CONVERGED)
