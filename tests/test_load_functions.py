"""Loads with jumps and kinks, and wrong ones: the figures agree with a dense scan."""

import numpy as np
import pytest
from scipy.optimize import brentq

import escapement as esc
from escapement.constant_speed import contact_moment
from escapement.numerics import chebyshev

WHEEL = esc.Geneva(8)


def driven(load, inertia=0.019, **options):
    return esc.drive_torque(WHEEL, 10.0, load, inertia, **options)


@pytest.mark.parametrize("low", [0.1, -1.0])
@pytest.mark.parametrize("phi", [-0.21, 0.05, 0.2])
@pytest.mark.parametrize("rises", [True, False])
def test_a_jump_counts_from_both_sides(low, phi, rises):
    """Also where it is itself the reversal."""
    found = driven(lambda x: np.where((x > phi) == rises, 5.0, low))
    jump = brentq(lambda x: float(WHEEL.follower_angle(x)) - phi, *WHEEL.breaks[::2], xtol=1e-15)
    theta = np.linspace(*WHEEL.breaks[::2], 20001)
    theta = np.concatenate([theta, jump + np.array([-1e-13, 1e-13])])
    torque = found.at(theta).torque
    assert found.torque_max == pytest.approx(torque.max(), rel=1e-6)
    assert found.torque_min == pytest.approx(torque.min(), rel=1e-6, abs=1e-6)
    assert found.power_max == 10.0 * found.torque_max
    for place, angle in (
        (torque.argmax(), found.torque_max_angle),
        (torque.argmin(), found.torque_min_angle),
    ):
        assert angle == pytest.approx(theta[place], abs=2e-4)


@pytest.mark.parametrize("count", [100, 1000])
def test_a_rough_table_is_resolved(count):
    """A scan finds no greater torque, and the sign changes at the same places."""
    random = np.random.default_rng(count)
    angles, values = np.linspace(-0.4, 0.4, count), random.uniform(0.1, 5.0, count)
    found = driven(lambda phi: np.interp(phi, angles, values))
    knots = np.interp(angles, WHEEL.follower_angle(_GRID), _GRID)
    scan = found.at(np.concatenate([_GRID, knots]))
    assert scan.torque.max() <= found.torque_max * (1.0 + 1e-7)
    assert scan.torque.min() >= found.torque_min - 1e-7
    assert scan.torque.max() == pytest.approx(found.torque_max, rel=1e-4)
    moment = found.at(_GRID).contact_moment
    crossings = _GRID[1:][np.diff(np.sign(moment)) != 0.0]
    seen = found.reversals[np.searchsorted(found.reversals, crossings) - 1]
    assert (np.abs(crossings - seen) < 2.0 * (_GRID[1] - _GRID[0])).all()


_GRID = np.linspace(*WHEEL.breaks[::2], 100_001)


@pytest.mark.parametrize(
    "mechanism", [esc.Geneva(6), esc.Geneva(8, internal=True), esc.EllipticalPlanetary(2.0, 1.0)]
)
def test_a_jump_at_dead_centre_turns_the_pin(mechanism):
    found = esc.drive_torque(mechanism, 1.0, lambda phi: np.where(phi > 0.0, 1.0, -2.0), 0.01)
    assert found.reversals == pytest.approx([0.0], abs=1e-8)
    waves = esc.drive_torque(mechanism, 1.0, lambda phi: np.sign(np.sin(40.0 * phi)), 1e-6)
    theta = np.linspace(mechanism.breaks[0], mechanism.breaks[-1], 400_001)
    sides = np.sign(waves.at(theta).contact_moment)
    assert len(waves.reversals) == np.count_nonzero(np.diff(sides[sides != 0.0])) > 5


def test_kinks_alone_count_against_a_load(monkeypatch):
    """Not the rounding at the ends of the engagement, where the follower hardly moves."""
    monkeypatch.setattr(chebyshev, "MOST_KINKS", 500)
    angles = np.linspace(-0.4, -0.3, 350)
    found = driven(lambda phi: np.interp(phi, angles, 1.0 + 0.3 * (np.arange(350) % 2)))
    assert found.torque_max == pytest.approx(found.at(_GRID).torque.max(), rel=1e-4)


def test_a_load_may_carry_the_rounding_of_another_precision():
    exact, rough = (driven(lambda phi, t=t: np.sin(phi).astype(t)) for t in ("f8", "f4"))
    assert rough.torque_max == pytest.approx(exact.torque_max, rel=1e-6)
    np.testing.assert_allclose(rough.reversals, exact.reversals, atol=1e-5)


def test_a_contact_moment_is_that_of_the_drive():
    load = np.cos
    found = driven(load)
    theta = np.linspace(WHEEL.breaks[0], WHEEL.breaks[0] + WHEEL.cell_angle, 101)
    moment = contact_moment(WHEEL, theta, 10.0, 0.0, load, 0.019)
    np.testing.assert_allclose(moment, found.at(theta).contact_moment, rtol=0.0, atol=1e-14)
    assert (moment[theta > WHEEL.breaks[-1]] == 0.0).all()
