"""A motion that was written and read back is the motion that was computed."""

import numpy as np
import pytest

import escapement as esc
from escapement.store_motion import read_motion, write_motion

LIGHT, MEYER = esc.Inertia(3e-8, 1e-5), esc.Inertia(3.39e-7, 5.65e-6)
# a light driver's speed peaks between two of a hundred samples an engagement
SCENES = {
    "dwell": esc.Escapement(esc.Geneva(3, pins=1), LIGHT, 0.01, friction=0.02),
    "light": esc.Escapement(esc.Geneva(8), LIGHT, 0.01, friction=0.02),
    "mesh": esc.Escapement(esc.EllipticalPlanetary(0.016, 0.009), LIGHT, 0.01, efficiency=0.9),
    "meyer": esc.Escapement(esc.Geneva(4), MEYER, 0.0113, friction=0.35),
    "load": esc.Escapement(esc.Geneva(6), MEYER, 0.0113, friction=0.2, load_torque=0.004),
}


@pytest.mark.parametrize("engine", ["energy", "ivp"])
@pytest.mark.parametrize("scene", SCENES)
def test_every_state_is_that_of_the_motion_written(scene, engine, tmp_path):
    motion = esc.simulate(SCENES[scene], 4, engine=engine, initial_speed=3.0, rtol=1e-10)
    write_motion(motion, tmp_path / "motion.h5")
    again = read_motion(tmp_path / "motion.h5")
    times = np.linspace(0.0, motion.end_time, 5001)
    found, written = again.at(times), motion.at(times)
    for name in ("theta", "theta_dot", "phi", "phi_dot"):
        expected = getattr(written, name)
        scale = 1e-10 * np.abs(expected).max()
        np.testing.assert_allclose(getattr(found, name), expected, rtol=0.0, atol=scale)
    assert again.ledger.residual == pytest.approx(motion.ledger.residual, abs=1e-10)


@pytest.mark.parametrize("load", [0.0112, 0.02])
def test_a_motion_that_stops_is_read_back(load, tmp_path):
    timer = esc.Escapement(esc.Geneva(4), MEYER, 0.0113, friction=0.1, load_torque=load)
    motion = esc.simulate(timer, 200, initial_speed=30.0)
    assert motion.status.label == "stall"
    write_motion(motion, tmp_path / "motion.h5")
    again = read_motion(tmp_path / "motion.h5")
    times = np.linspace(0.0, motion.end_time, 301)
    np.testing.assert_allclose(again.at(times).theta, motion.at(times).theta, atol=1e-9)
