"""Mechanisms that hand the kernels a table instead of a pin path."""

import numpy as np
import pytest

import escapement as esc
from escapement.errors import InvalidValue
from escapement.mechanisms.slotted import radius, transmission
from escapement.mechanisms.table import chebyshev_table
from escapement.status import Status


class Drive:
    """A smooth drive made up for these tests: g = A (1 - cos(k theta))^2, stops at both ends."""

    cell_angle = 3.0
    breaks = (0.0, 3.0)
    order = 2.0 * np.pi / cell_angle
    follower_step = 1.5 * 0.8 * cell_angle

    def g(self, theta):
        return 0.8 * (1.0 - np.cos(self.order * np.asarray(theta))) ** 2

    def dg(self, theta):
        angle = self.order * np.asarray(theta)
        return 1.6 * (1.0 - np.cos(angle)) * np.sin(angle) * self.order

    def follower_angle(self, theta):
        angle = self.order * np.asarray(theta, dtype=float)
        return 0.8 * (1.5 * angle - 2.0 * np.sin(angle) + np.sin(2.0 * angle) / 4.0) / self.order

    @property
    def path(self):
        return chebyshev_table(self.g, self.breaks)


def timer(**changes):
    numbers = {"torque": 1.3, "efficiency": 0.8} | changes
    return esc.Escapement(Drive(), esc.Inertia(1.0, 2.0), **numbers)


def test_a_table_is_its_function_to_rounding():
    drive = Drive()
    theta = np.linspace(*drive.breaks, 1001)
    table = transmission(drive.path, theta)
    assert np.abs(table.g - drive.g(theta)).max() <= 3e-15 * 3.2
    assert np.abs(table.dg - drive.dg(theta)).max() <= 2e-12 * np.abs(drive.dg(theta)).max()
    np.testing.assert_array_equal(table.u, table.g)
    assert np.isnan(radius(drive.path, theta)).all()


def test_a_corner_between_two_edges_is_refused():
    with pytest.raises(InvalidValue, match=r"a transmission, must be smooth .* near 0\.2999999"):
        chebyshev_table(lambda theta: np.abs(theta - 0.3), (0.0, 1.0))
    broken = chebyshev_table(lambda theta: np.abs(theta - 0.3), (0.0, 0.3, 1.0))
    assert transmission(broken, 0.2).g == pytest.approx(0.1, abs=2e-16)
    assert transmission(broken, 0.3).dg == pytest.approx(1.0, abs=5e-13)  # rounding times 17^2


@pytest.mark.parametrize("load", [0.0, 0.2])
@pytest.mark.parametrize("efficiency", [0.85, 0.6])
def test_both_engines_agree_on_a_mesh(efficiency, load):
    scene = timer(efficiency=efficiency, load_torque=load)
    fast = esc.simulate(scene, 4, rtol=1e-12)
    slow = esc.simulate(scene, 4, engine="ivp", rtol=1e-11)
    np.testing.assert_allclose(fast.handoff_times, slow.handoff_times, rtol=1e-10)
    np.testing.assert_allclose(fast.handoff_velocities, slow.handoff_velocities, rtol=1e-10)
    np.testing.assert_allclose(fast.extrema.theta_dot, slow.extrema.theta_dot, rtol=1e-10)
    assert abs(fast.ledger.residual) <= 1e-11
    ours, theirs = esc.terminal(scene), esc.terminal(scene, engine="ivp")
    for name in ("velocity_max", "velocity_min", "period", "settling_time", "rise_time"):
        assert getattr(ours, name) == pytest.approx(getattr(theirs, name), rel=1e-9), name


def test_what_a_mesh_loses_is_its_share_of_what_passes():
    """Terminal cycle: the work of the drive is lost in the mesh, both ways."""
    eta = 0.7
    scene = timer(efficiency=eta)
    cycle = esc.terminal(scene)
    motion = esc.simulate(scene, 1, initial_speed=cycle.handoff_velocity)
    t = np.linspace(0.0, motion.end_time, 40001)
    state = motion.at(t)
    power = state.contact_moment * state.phi_dot
    loss = np.where(power > 0.0, power * (1.0 / eta - 1.0), -power * (1.0 - eta))
    work = scene.torque * Drive.cell_angle
    assert np.trapezoid(loss, t) == pytest.approx(work, rel=1e-6)
    assert float(motion.handoff_velocities[0]) == pytest.approx(cycle.handoff_velocity, rel=1e-10)


def test_without_a_loss_there_is_no_terminal_speed():
    assert esc.terminal(timer(efficiency=1.0)).status is Status.NO_TERMINAL


def test_a_mesh_has_no_painleve_limit():
    assert esc.terminal(timer()).critical_friction == np.inf


def test_each_loss_has_its_mechanism():
    with pytest.raises(InvalidValue, match="friction must be 0 for a mechanism without a slot"):
        timer(friction=0.1)
    with pytest.raises(InvalidValue, match="efficiency must be 1 for a slotted mechanism"):
        esc.Escapement(esc.Geneva(4), esc.Inertia(1.0, 1.0), 1.0, efficiency=0.9)
    for value in (0.0, -1.0, 1.1, np.nan, 1e-9):
        with pytest.raises(InvalidValue, match="efficiency must be"):
            timer(efficiency=value)
