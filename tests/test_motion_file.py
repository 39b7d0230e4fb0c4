"""A motion that was written and read back is the motion that was computed."""

import h5py
import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InputFileError
from escapement.motion_file import read_motion, write_motion
from tabulated_drive import exact, measured

LIGHT, MEYER = esc.Inertia(3e-8, 1e-5), esc.Inertia(3.39e-7, 5.65e-6)
CAM = esc.TorqueCurve([0.0, 0.5, 2.0, 2.9], [0.01, 0.012, 0.006, 0.01], periodic=True)
UNEVEN = esc.Geneva(4, crank_radius=0.01, pin_angle_errors=(1e-3, 0.0, -1e-3, 0.0))
# a light driver's speed peaks between two of a hundred samples an engagement
SCENES = {
    "dwell": esc.Escapement(esc.Geneva(3, pins=1), LIGHT, 0.01, friction=0.02),
    "light": esc.Escapement(esc.Geneva(8), LIGHT, 0.01, friction=0.02),
    "mesh": esc.Escapement(esc.EllipticalPlanetary(0.016, 0.009), LIGHT, 0.01, efficiency=0.9),
    "meyer": esc.Escapement(esc.Geneva(4), MEYER, 0.0113, friction=0.35),
    "load": esc.Escapement(esc.Geneva(6), MEYER, 0.0113, friction=0.2, load_torque=0.004),
    "table": esc.Escapement(exact(24), LIGHT, 0.01, efficiency=0.9),
    "measured table": esc.Escapement(measured(40, 0.005), LIGHT, 0.01, efficiency=0.9),
    "errors": esc.Escapement(UNEVEN, MEYER, 0.0113, friction=0.2),
    "trains": esc.Escapement(
        esc.Geneva(4), MEYER, 0.0565, friction=0.25, load_torque=2e-4, spring_rate=1e-4,
        barrel=esc.Train(5.0, 0.8, 8e-6), load_train=esc.Train(3.0, 0.9, 6e-8),
    ),
    "curve": esc.Escapement(esc.Geneva(4), MEYER, CAM, friction=0.2),
}  # fmt: skip


@pytest.mark.parametrize(
    ("scene", "engine"), [*((scene, "energy") for scene in SCENES), ("load", "ivp")]
)
def test_every_state_is_that_of_the_motion_written(scene, engine, tmp_path):
    motion = esc.simulate(SCENES[scene], 4, engine=engine, initial_speed=3.0, rtol=1e-10)
    write_motion(motion, tmp_path / "motion.h5")
    again = read_motion(tmp_path / "motion.h5")
    assert again.escapement == motion.escapement
    np.testing.assert_array_equal(again.handoff_velocities, motion.handoff_velocities)
    np.testing.assert_array_equal(again.extrema.theta_dot, motion.extrema.theta_dot)
    times = np.linspace(0.0, motion.end_time, 5001)
    found, written = again.at(times), motion.at(times)
    for name in ("theta", "theta_dot", "phi", "phi_dot"):
        expected = getattr(written, name)
        scale = 1e-10 * np.abs(expected).max()
        np.testing.assert_allclose(getattr(found, name), expected, rtol=0.0, atol=scale)
    assert again.ledger.residual == pytest.approx(motion.ledger.residual, abs=1e-10)


STOPS = {
    **{f"load {load}": {"friction": 0.1, "load_torque": load}
       for load in (0.0112, 0.0125, 0.016, 0.02)},
    # a reversal lies at dead centre, up to rounding, where another piece begins
    "spent": {"friction": 0.3, "spring_rate": 1e-3},
}  # fmt: skip


@pytest.mark.parametrize("engine", ["energy", "ivp"])
@pytest.mark.parametrize("name", STOPS)
def test_a_motion_that_stops_is_read_back(name, engine, tmp_path):
    timer = esc.Escapement(esc.Geneva(4), MEYER, 0.0113, **STOPS[name])
    speed = 0.0 if name == "spent" else 30.0
    motion = esc.simulate(timer, 200, initial_speed=speed, engine=engine)
    assert motion.status.label == ("spent" if name == "spent" else "stall")
    assert (np.diff(motion.trajectory.start) >= 0.0).all()
    write_motion(motion, tmp_path / "motion.h5")
    again = read_motion(tmp_path / "motion.h5")
    times = np.linspace(0.0, motion.end_time, 301)
    np.testing.assert_allclose(again.at(times).theta, motion.at(times).theta, atol=1e-9)


def test_a_mechanism_of_the_users_own_is_no_damage(tmp_path):
    class Mine(esc.Geneva):
        pass

    motion = esc.simulate(esc.Escapement(Mine(4), MEYER, 0.0113, friction=0.2), 2)
    write_motion(motion, tmp_path / "motion.h5")
    with pytest.raises(InputFileError, match=r"can describe, got one of class .*Mine;"):
        read_motion(tmp_path / "motion.h5")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("motion") / "motion.h5"
    write_motion(esc.simulate(SCENES["meyer"], 3), path)
    return path


DAMAGED = "must be whole, and cannot be read in full: ", "or compute it again under another name"
OTHERS = "must have the handoffs that this version computes, got others; ", "with h5py or xarray"


def check_refused(written, tmp_path, change, told=DAMAGED):
    """A copy of a motion file is refused after a change."""
    path = tmp_path / "motion.h5"
    path.write_bytes(written.read_bytes())
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(InputFileError) as caught:
        read_motion(path)
    said = str(caught.value)
    assert said.startswith(f"motion {path} {told[0]}")
    assert said.endswith(told[1])


CHANGES = {
    **{f"end {end}": lambda file, end=end: file.attrs.update(end_time=end)
       for end in (np.nan, -1.0, "soon", [0.0, 1.0])},
    **{f"text {text}": lambda file, text=text: file.attrs.update(configuration=text)
       for text in ("[]", "5", "null", '"a"', "{}", "{")},
    "group for a dataset": lambda file: file.create_group("configuration"),
}  # fmt: skip
OTHER_MOTIONS = {
    "other handoffs": lambda file: file["handoff_times"].write_direct(np.arange(1.0, 4.0)),
    "another status": lambda file: file.attrs.update(status="stall"),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_damaged_motion_is_refused(written, tmp_path, change):
    check_refused(written, tmp_path, change)


@pytest.mark.parametrize("change", OTHER_MOTIONS.values(), ids=OTHER_MOTIONS)
def test_what_this_version_does_not_compute_is_refused(written, tmp_path, change):
    check_refused(written, tmp_path, change, OTHERS)
