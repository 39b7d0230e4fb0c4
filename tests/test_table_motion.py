"""Motions of tables: the energy they keep, and followers that stop or turn back a little."""

import numpy as np
import pytest

import escapement as esc
from escapement.mechanisms.table import read_table
from escapement.status import Status

WHEEL = esc.Geneva(4)
DRIVE = esc.EllipticalPlanetary(sun_radius=0.016, planet_radius=0.009)
INERTIA = esc.Inertia(3.39e-7, 5.65e-6)


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
    "table", [exact(WHEEL, 181), exact(DRIVE, 61), measured(0.1, 1)], ids=["geneva", "gear", "data"]
)
def test_motions_keep_their_energy_over_the_knots(table):
    """Quadrature that is made for smooth functions would lose 1e-8 of the work there."""
    timer = moved_by(table)
    assert abs(esc.simulate(timer, 3).ledger.residual) < 1e-12
    figures = esc.terminal(timer)
    assert abs(figures.energy_residual) < 1e-12
    again = esc.simulate(timer, 1, initial_speed=figures.handoff_velocity)
    assert again.handoff_velocities[0] == pytest.approx(figures.handoff_velocity, rel=1e-11)


@pytest.mark.parametrize(
    "table", [exact(WHEEL, 91), exact(DRIVE, 61), measured(0.1, 1)], ids=["geneva", "gear", "data"]
)
def test_the_reference_engine_keeps_its_tolerance_over_the_knots(table):
    """A solver that steps over them is off by a hundred tolerances."""
    timer = moved_by(table)
    fast = esc.simulate(timer, 2, rtol=1e-12)
    slow = esc.simulate(timer, 2, engine="ivp", rtol=1e-10)
    np.testing.assert_allclose(slow.handoff_times, fast.handoff_times, rtol=1e-10)
    np.testing.assert_allclose(slow.handoff_velocities, fast.handoff_velocities, rtol=1e-10)
    assert abs(slow.ledger.residual) < 1e-10


def test_many_rows_cost_the_reference_engine_no_digits():
    """Steps of the ratio at the knots, were they but roundings of the table, would add up."""
    timer = esc.Escapement(exact(DRIVE, 601), INERTIA, torque=0.0113)
    velocity = esc.simulate(timer, 1, engine="ivp", rtol=1e-13).handoff_velocities[0]
    work = timer.torque * DRIVE.cell_angle
    assert velocity == pytest.approx(np.sqrt(2.0 * work / INERTIA.driver), rel=1e-13)


@pytest.mark.parametrize("rows", [61, 201, 601])
def test_a_ratio_has_no_steps_at_the_knots(rows):
    _edges, series = read_table(exact(DRIVE, rows).path)
    steps = (series * (-1.0) ** np.arange(series.shape[1])).sum(axis=1)[1:] - series.sum(axis=1)[
        :-1
    ]
    assert np.abs(steps).max() < 10.0 * np.finfo(float).eps * DRIVE.ratio_max
    # nor a bias: the mean of steps of half a rounding error each, by chance
    chance = 4.0 * 0.6 / np.sqrt(steps.size)
    assert abs(steps.mean()) < chance * np.finfo(float).eps * DRIVE.ratio_max


@pytest.mark.parametrize("rows", [451, 601])
def test_rounding_next_to_a_stop_is_no_turning_back(rows):
    """g is a rounding error below zero where the follower stops."""
    table = exact(DRIVE, rows)
    assert -1e-12 < table.transmission(table.breaks[0]).g < 0.0
    motion, true = esc.simulate(moved_by(table), 3), esc.simulate(moved_by(DRIVE), 3)
    assert motion.status is Status.OK
    np.testing.assert_allclose(motion.handoff_velocities, true.handoff_velocities, rtol=1e-9)


@pytest.mark.parametrize("seed", [23, 100])
def test_a_reversal_at_the_very_start_is_one(seed):
    """Of uneven rows g may be below zero from the start on, by rounding: not all along after it."""
    random = np.random.default_rng(seed)
    theta = np.linspace(*DRIVE.breaks, 109)
    theta[1:-1] += random.uniform(-0.3, 0.3, theta.size - 2) * (theta[1] - theta[0])
    timer = moved_by(esc.Tabulated(theta, DRIVE.follower_angle(theta)))
    motion, judge = (esc.simulate(timer, 2, engine=name) for name in ("energy", "ivp"))
    assert motion.reversals.theta[0] == timer.mechanism.breaks[0]
    assert motion.reversals.theta.size == judge.reversals.theta.size
    assert np.isfinite(motion.reversals.time).all()
    assert abs(motion.ledger.residual) < 1e-12


@pytest.mark.parametrize(("noise_deg", "seed"), [(0.5, 2), (0.5, 3), (0.1, 6), (0.01, 3)])
def test_a_follower_that_seems_to_turn_back_a_little_moves(noise_deg, seed):
    """Noise makes g change its sign beside a stop, and with it the sense of what is lost."""
    table = measured(noise_deg, seed)
    assert table.transmission(np.linspace(*table.breaks, 2000)).g.min() < 0.0
    fast, judge = (esc.simulate(moved_by(table), 2, engine=name) for name in ("energy", "ivp"))
    assert fast.status is judge.status is Status.OK
    np.testing.assert_allclose(fast.handoff_times, judge.handoff_times, rtol=1e-9)
    np.testing.assert_allclose(fast.handoff_velocities, judge.handoff_velocities, rtol=1e-9)


def test_a_constant_ratio_turns_nowhere():
    """Its g' is a rounding error, whose sign means nothing."""
    theta = np.linspace(0.0, 2.0 * np.pi, 73)
    found = esc.drive_torque(
        esc.Tabulated(theta, 0.5 * theta), speed=10.0, load_torque=0.0, follower_inertia=1e-5
    )
    assert found.reversals.size == 0
    assert found.zone == 1
