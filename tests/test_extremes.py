"""Extreme but valid inputs: every computation ends, and a message names missing figures."""

import math

import numpy as np
import pytest

import escapement as esc
from bad_calls import TIMER, built, ivp, wheel
from escapement.base.status import Status
from escapement.engines.ivp import piece
from random_drives import drive


@pytest.fixture
def few_steps(monkeypatch):
    """A limit that is met soon; the real one takes seconds."""
    monkeypatch.setattr(piece, "MOST_STEPS", 1000)


@pytest.mark.usefixtures("few_steps")
@pytest.mark.parametrize(
    "options", [{"method": "RK23", "rtol": 1e-8}, {"method": "RK45", "max_step": 2e-5}]
)
def test_too_many_steps_end_in_a_status(options, monkeypatch):
    motion = ivp(**options)
    assert motion.status is Status.NOT_CONVERGED
    assert "more than 1000 steps" in motion.message
    assert motion.handoff_times.size == 0
    figures = esc.terminal(TIMER, engine="ivp", **options)
    assert (figures.status, figures.message) == (motion.status, motion.message)
    assert math.isnan(figures.velocity_max)
    monkeypatch.setattr(piece, "MOST_STEPS", 10_000)
    assert ivp(**options).status is Status.OK


# what is allowed ends, and says what is missing
ODD = {
    "nothing but a follower": built(inertia=esc.Inertia(1e-6, 1.0), torque=1.0, friction=1e-3),
    "hardly any friction": built(friction=1e-12),
    "a load that stops it": built(load_torque=1.0),
    "a load without friction": built(friction=0.0, load_torque=0.0102),
    "a wheel of a thousand slots": built(mechanism=wheel(slots=1000)),
    "friction beyond the limit": built(friction=2.0),
}
ALWAYS = ("velocity_max", "velocity_min", "velocity_mean", "period", "handoff_velocity")


@pytest.mark.usefixtures("patience")
@pytest.mark.parametrize("engine", ["energy", "ivp"])
@pytest.mark.parametrize("name", ODD)
def test_a_missing_figure_has_a_status_or_a_message(name, engine):
    rtol = {"energy": 1e-12, "ivp": 1e-6}[engine]
    found = esc.terminal(ODD[name], engine=engine, rtol=rtol)
    missing = [math.isnan(getattr(found, figure)) for figure in ALWAYS]
    assert all(missing) == any(missing) == (found.status is not Status.OK)
    if found.status is not Status.OK or math.isnan(found.settling_time):
        assert found.message != "done"
        assert "nan" not in found.message
    motion = esc.simulate(ODD[name], 2, engine=engine, rtol=rtol)
    if motion.status is Status.OK:
        assert np.isfinite(motion.handoff_velocities).all()
        assert motion.handoff_velocities.size == 2
    else:
        assert motion.message != "done"
    # from rest both tell the same story: what cannot do one cell has no terminal cycle
    assert motion.status.failed == found.status.failed


@pytest.mark.usefixtures("patience")
@pytest.mark.parametrize("settings", [{"atol": 0.0}, {"atol": 0.0, "rtol": 1e-13}, {"rtol": 0.5}])
def test_any_tolerance_that_is_allowed_ends(settings):
    motion = ivp(**settings)
    best = esc.simulate(TIMER, 1)
    error = abs(motion.handoff_times[0] / best.handoff_times[0] - 1.0)
    assert error <= 10.0 * settings.get("rtol", 1e-10)


@pytest.mark.parametrize(("engine", "load"), [("energy", 0.0), ("energy", 0.25), ("ivp", 0.25)])
def test_a_constant_ratio_speeds_up_without_end(engine, load):
    """theta_ddot = (1 - p load)/(rho + g p) with p = g/efficiency, whatever the speed."""
    theta = np.linspace(0.0, 2.0 * np.pi, 19)
    table, inertia = esc.Tabulated(theta, 0.5 * theta), esc.Inertia(0.5, 1.0)
    gears = esc.Escapement(table, inertia, 1.0, efficiency=0.9, load_torque=load)
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
    heavy = drive(15, 2, 2697136.0225537354, 0.07568599921333452, 7.261626849626713)
    for speed in (0.04, 0.4, 3.75, 4.5, 8.0, 20.0):
        motion = esc.simulate(heavy, 1, initial_speed=speed)
        assert motion.handoff_velocities[0] < speed
    status = esc.terminal(heavy, initial_speed=20.152993992877356, rtol=1e-5).status
    assert status in (Status.STALL, Status.NOT_CONVERGED)


# hardly any loss, a stop after many turns, no end at all; in natural units
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
    timer = drive(slots, pins, rho, friction, load)
    figures = esc.terminal(timer, rtol=1e-13)
    assert 0.0 < 1.0 - figures.contraction < 1e-3
    cycle = esc.simulate(timer, 1, initial_speed=figures.handoff_velocity, rtol=1e-13)
    wheel = timer.mechanism
    work = wheel.cell_angle - load * wheel.follower_step
    assert cycle.trajectory.losses.sum() == pytest.approx(work, rel=1e-12)
