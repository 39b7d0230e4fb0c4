"""Tables instead of pin paths: the numbers that kernels read, and followers that stop."""

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.mechanisms.protocol import Mechanism
from escapement.mechanisms.slotted import radius, transmission
from escapement.mechanisms.table import chebyshev_table

WHEEL = esc.Geneva(4)
DRIVE = esc.EllipticalPlanetary(sun_radius=0.016, planet_radius=0.009)
INERTIA = esc.Inertia(3.39e-7, 5.65e-6)


class Drive(Mechanism):
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
    with pytest.raises(InvalidValue, match=r"transmission must be smooth .* near 0\.2999999"):
        chebyshev_table(lambda theta: np.abs(theta - 0.3), (0.0, 1.0))
    broken = chebyshev_table(lambda theta: np.abs(theta - 0.3), (0.0, 0.3, 1.0))
    assert transmission(broken, 0.2).g == pytest.approx(0.1, abs=2e-16)
    assert transmission(broken, 0.3).dg == pytest.approx(1.0, abs=5e-13)  # rounding times 17^2


def moved_by(table):
    return esc.Escapement(table, INERTIA, torque=0.0113, efficiency=0.9)


def exact(drive, rows):
    theta = np.linspace(*drive.breaks[:: len(drive.breaks) - 1], rows)
    return esc.Tabulated(theta, drive.follower_angle(theta))


def measured(noise_deg, seed):
    random = np.random.default_rng(seed)
    theta = np.linspace(*DRIVE.breaks, 148)[:-1]
    phi = DRIVE.follower_angle(theta) + np.radians(noise_deg) * random.normal(size=theta.size)
    return esc.Tabulated(
        theta, phi, measured=True, cell_angle=DRIVE.cell_angle, follower_step=DRIVE.follower_step
    )


@pytest.mark.parametrize(
    "table", [exact(WHEEL, 91), exact(DRIVE, 61), measured(0.1, 1)], ids=["geneva", "gear", "data"]
)
def test_motions_keep_energy_and_tolerance_over_the_knots(table):
    """Made for smooth functions, quadrature would lose 1e-8 there, a solver be a hundred off."""
    drive = moved_by(table)
    fast = esc.simulate(drive, 3, rtol=1e-12)
    slow = esc.simulate(drive, 3, engine="ivp", rtol=1e-10)
    assert abs(esc.simulate(drive, 3).ledger.residual) < 1e-12
    assert abs(slow.ledger.residual) < 1e-10
    np.testing.assert_allclose(slow.handoff_times, fast.handoff_times, rtol=1e-10)
    np.testing.assert_allclose(slow.handoff_velocities, fast.handoff_velocities, rtol=1e-10)
    figures = esc.terminal(drive)
    assert abs(figures.energy_residual) < 1e-12
    again = esc.simulate(drive, 1, initial_speed=figures.handoff_velocity)
    assert again.handoff_velocities[0] == pytest.approx(figures.handoff_velocity, rel=1e-11)


@pytest.mark.parametrize("rows", [451, 601])
def test_rounding_next_to_a_stop_is_no_turning_back(rows):
    """g is a rounding error below zero where the follower stops."""
    table = exact(DRIVE, rows)
    assert -1e-12 < table.transmission(table.breaks[0]).g < 0.0
    motion, true = esc.simulate(moved_by(table), 3), esc.simulate(moved_by(DRIVE), 3)
    assert motion.status is Status.OK
    np.testing.assert_allclose(motion.handoff_velocities, true.handoff_velocities, rtol=1e-9)
