"""What is allowed comes to an end, and says what is missing."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

import escapement as esc
from bad_calls import MODEL, TIMER, WHEEL, built, first_steps, ivp, wheel
from escapement.engines.time import piece
from escapement.status import Status


@pytest.fixture
def few_steps(monkeypatch):
    """A limit that is met soon; the real one takes seconds."""
    monkeypatch.setattr(piece, "MOST_STEPS", 1000)


@pytest.mark.usefixtures("few_steps")
@pytest.mark.parametrize(
    "options", [{"method": "RK23", "rtol": 1e-8}, {"method": "RK45", "max_step": 1e-5}]
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


def test_errors_beyond_a_step_end_in_a_status():
    """An atol that allows any error: the corrected end of a step may lie before its start."""
    drive = esc.EllipticalPlanetary(0.02, 0.009)
    mesh = esc.Escapement(drive, esc.Inertia(3e-6, 5e-6), 0.01, load_torque=0.001, efficiency=0.8)
    loose = {"rtol": 0.9, "atol": 1e6, "max_step": 2e-3, "method": "RK23"}
    motion = esc.simulate(mesh, 3, engine="ivp", **loose)
    assert motion.status is Status.NOT_CONVERGED
    assert "errors greater than a whole step; choose a smaller rtol" in motion.message
    assert esc.simulate(mesh, 3, engine="ivp", **loose | {"atol": 1e-3}).status is Status.OK


@pytest.mark.usefixtures("few_steps")
def test_too_many_steps_on_the_command_line(command, tmp_path):
    code, _, err = command("run", *MODEL, "--engine", "ivp", "--method", "RK23", "--rtol", "1e-8")
    assert code == 3
    unwritten, reason = err.splitlines()
    assert "no out.h5 and no out.png was made" in unwritten
    assert "choose a larger rtol, a larger max_step or method 'DOP853'" in reason
    assert not list(tmp_path.iterdir())


# what is allowed ends, and says what is missing
ODD = {
    "nothing but a driver": built(inertia=esc.Inertia(1e8, 1.0), torque=1.0),
    "nothing but a follower": built(inertia=esc.Inertia(1e-6, 1.0), torque=1.0, friction=1e-3),
    "hardly any friction": built(friction=1e-12),
    "a load that stops it": built(load_torque=1.0),
    "a load it cannot start": built(load_torque=1e50),
    "a load without friction": built(friction=0.0, load_torque=0.0102),
    "a wheel of a thousand slots": built(mechanism=wheel(slots=1000)),
    "friction beyond the limit": built(friction=1e300),
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
    best = first_steps()
    error = abs(motion.handoff_times[0] / best.handoff_times[0] - 1.0)
    assert error <= 10.0 * settings.get("rtol", 1e-10)


@pytest.mark.usefixtures("patience")
@pytest.mark.parametrize("engine", ["energy", "ivp"])
def test_any_speed_that_is_allowed_is_simulated(engine):
    """So fast that the torque is nothing: friction alone takes its share of the speed."""
    rho, mu = TIMER.inertia.driver / TIMER.inertia.follower, TIMER.friction

    def loss(theta):
        """d ln(E)/d theta of the kinetic energy E, whose share at both ends is the driver's."""
        x = WHEEL.transmission(theta)
        rubbing = mu * abs(x.u) * math.copysign(1.0, x.dg)
        return -2.0 * rubbing * rho * x.dg / ((rho + x.g * (x.g + rubbing)) * (rho + x.g**2))

    left = math.exp(0.5 * sum(quad(loss, *half)[0] for half in pairwise(WHEEL.breaks)))
    unit = math.sqrt(TIMER.torque / TIMER.inertia.follower)
    for exponent in (10, 20, 50, 99):
        speed = 10.0**exponent * unit
        motion = esc.simulate(TIMER, 1, engine=engine, initial_speed=speed)
        assert motion.status is Status.OK
        assert motion.handoff_velocities[0] == pytest.approx(speed * left, rel=1e-6)
