"""Motions: the check value, and properties that hold for every engine."""

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.units import INCH_POUND

ENGINES = {"energy": 1e-12, "ivp": 1e-9}


def timer(slots=4, friction=0.35, torque=0.1, load=0.0, driver=3e-6, **wheel):
    return esc.Escapement(
        mechanism=esc.Geneva(slots, **wheel),
        inertia=esc.Inertia(driver * INCH_POUND, 50e-6 * INCH_POUND),
        torque=torque * INCH_POUND,
        friction=friction,
        load_torque=load * INCH_POUND,
    )


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("scene", [timer(), timer(8, 0.2, pins=2, load=0.02), timer(friction=0.0)])
def test_laws_that_every_motion_obeys(engine, scene):
    motion = esc.simulate(scene, engagements=4, engine=engine)
    mechanism, close = scene.mechanism, ENGINES[engine] * 100.0
    speed = motion.theta_dot.max()
    # sample times are only looked up: a coarse and a fine grid meet in the same values
    fine = motion.at(np.linspace(0.0, motion.end_time, 401))
    coarse = motion.at(fine.t[::100])
    np.testing.assert_array_equal(fine.theta[::100], coarse.theta)
    # at rest to begin with: Appendix D's initial acceleration
    found = mechanism.transmission(mechanism.breaks[0])
    reduced = scene.scene.rho + abs(scene.friction * found.u * found.g)
    load = 1.0 - scene.friction * abs(found.u) * scene.scene.load
    start = scene.torque / scene.inertia.follower * load / reduced
    assert coarse.theta_ddot[0] == pytest.approx(start, rel=1e-9)
    assert coarse.theta_dot[0] == pytest.approx(0.0, abs=close * speed)
    # every handoff: a cell further, a step further, the follower at rest
    before = motion.at(motion.handoff_times[:-1])
    cells = np.arange(1, 4)
    at = mechanism.breaks[0] + cells * mechanism.cell_angle
    np.testing.assert_allclose(before.theta, at, rtol=0, atol=close)
    turned = mechanism.follower_step * (cells - 0.5)
    np.testing.assert_allclose(before.phi, turned, rtol=0, atol=close)
    np.testing.assert_allclose(before.phi_dot, 0.0, rtol=0, atol=1e3 * close * speed)
    np.testing.assert_allclose(before.theta_dot, motion.handoff_velocities[:-1], rtol=close)
    # on a reversal nothing is transmitted and the driver turns free
    turns = motion.at(motion.reversals.time)
    np.testing.assert_allclose(turns.contact_moment / scene.torque, 0.0, atol=1e5 * close)
    free = scene.torque / scene.inertia.driver
    np.testing.assert_allclose(turns.theta_ddot, free, rtol=1e5 * close)
    # extrema are extrema
    step = 1e-5 * motion.end_time
    inside = (motion.extrema.time > step) & (motion.extrema.time < motion.end_time - step)
    for when, value, top in zip(
        motion.extrema.time[inside],
        motion.extrema.theta_dot[inside],
        motion.extrema.maximum[inside],
        strict=True,
    ):
        beside = motion.at([when - step, when + step]).theta_dot
        assert np.all(beside < value) if top else np.all(beside > value)
    # and the energy is all there
    assert abs(motion.ledger.residual) < 10.0 * ENGINES[engine]


@pytest.mark.parametrize("piece", [-1, 9, [0, 9], 0.5, True, "first"])
def test_a_piece_that_is_not_there_is_refused(piece):
    motion = esc.simulate(timer(4, 0.35), engagements=3)
    assert motion.trajectory.start.size == 9
    with pytest.raises(InvalidValue, match="piece must be whole and from 0 to 8, got"):
        motion.within(piece, np.zeros(2))
    assert motion.within(8, motion.end_time).theta_dot == motion.at(motion.end_time).theta_dot
