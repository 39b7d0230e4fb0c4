"""Loads that jump, bend and err: the figures are those of a dense scan."""

import numpy as np
import pytest
from scipy.optimize import brentq

import escapement as esc
from escapement.errors import InvalidValue

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


def test_what_is_too_rough_is_refused():
    with pytest.raises(InvalidValue, match="load_torque must be smooth but for at most 5000 kinks"):
        driven(lambda phi: np.sin(1e6 * phi))


def test_a_load_may_carry_the_rounding_of_another_precision():
    exact, rough = (driven(lambda phi, t=t: np.sin(phi).astype(t)) for t in ("f8", "f4"))
    assert rough.torque_max == pytest.approx(exact.torque_max, rel=1e-6)
    np.testing.assert_allclose(rough.reversals, exact.reversals, atol=1e-5)
