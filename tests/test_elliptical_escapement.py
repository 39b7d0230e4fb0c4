"""The elliptical planetary drive under a torque, with losses in its gears."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import escapement as esc
from elliptical_tools import PAPER
from escapement.base.units import INCH_POUND

INERTIA = esc.Inertia(driver=3e-6 * INCH_POUND, follower=50e-6 * INCH_POUND)
TORQUE = 0.1 * INCH_POUND


def test_a_motion_integrated_with_nothing_of_ours():
    """The equation of motion with the paper's (9) and the loss by hand, in time."""
    eta = 0.8
    k, driver, follower = 16 / 9, INERTIA.driver, INERTIA.follower
    e = (k - 1) / (k + 1)

    def ratio(theta):
        rho = (1 - e * e) / (1 - e * np.cos(k * theta))
        slope = -rho * e * k * np.sin(k * theta) / (1 - e * np.cos(k * theta))
        return k * rho / (2 - rho) - 1, 2 * k * slope / (2 - rho) ** 2

    def motion(_t, y):
        g, dg = ratio(y[0])
        # the moment on the follower has the sign of this, whatever the mesh loses
        pushed = driver * follower * dg * y[1] ** 2 + follower * g * TORQUE >= 0.0
        p = g / eta if pushed else g * eta
        return y[1], (TORQUE - p * follower * dg * y[1] ** 2) / (driver + follower * g * p)

    found = esc.simulate(esc.Escapement(PAPER, INERTIA, TORQUE, efficiency=eta), 4)
    times = np.linspace(0.0, found.handoff_times[-1], 25)
    run = solve_ivp(
        motion, (0.0, times[-1]), [PAPER.breaks[0], 0.0], t_eval=times, rtol=1e-10, atol=1e-12,
        max_step=1e-3,
    )  # fmt: skip
    np.testing.assert_allclose(found.at(times).theta_dot, run.y[1], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("efficiency", [0.98, 0.9, 0.6])
def test_contraction_in_closed_form(efficiency):
    """(rho + eta g^2)/(rho + g^2/eta), g being that of the reversal.

    Without a load the speed obeys a linear equation on each side of the reversal, and
    where the force is zero both sides are one: its shift changes nothing at first order.
    """
    cycle = esc.terminal(esc.Escapement(PAPER, INERTIA, TORQUE, efficiency=efficiency))
    angle = cycle.reversal_angles[0]
    rho, square = INERTIA.driver / INERTIA.follower, float(PAPER.transmission(angle).g) ** 2
    expected = (rho + efficiency * square) / (rho + square / efficiency)
    assert cycle.contraction == pytest.approx(expected, rel=1e-8)
    # and the reversal is where I_d (I_f g' w) + I_f g tau = 0
    motion = esc.simulate(
        esc.Escapement(PAPER, INERTIA, TORQUE, efficiency=efficiency), 1,
        initial_speed=cycle.handoff_velocity,
    )  # fmt: skip
    speed, table = motion.reversals.theta_dot[0], PAPER.transmission(motion.reversals.theta[0])
    balance = INERTIA.driver * float(table.dg) * speed**2 / (float(table.g) * TORQUE)
    assert balance == pytest.approx(-1.0, abs=1e-8)


def test_without_a_loss_the_energy_is_the_work():
    found = esc.simulate(esc.Escapement(PAPER, INERTIA, TORQUE), 10)
    assert esc.terminal(found.escapement).status.label == "no_terminal"
    # at a stop the follower rests, so all of it is the driver's
    work = TORQUE * PAPER.cell_angle * np.arange(1, 11)
    np.testing.assert_allclose(0.5 * INERTIA.driver * found.handoff_velocities**2, work, rtol=1e-12)
